// Places where an outline thinned from contours may bound other areas than they do.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::slice {

/// What can be about a place at distance d depends on the contours within d of it, and a little more. So
/// where there is a doubt, those are kept as they are when the outline is thinned again, and then there is
/// none. Units.
class Doubts {
 public:
  struct Doubt {
    Vec at;
    double d;
  };
  /// For an outline. @param thinned by how much it and the contours may differ, but where they are kept
  void begin(double thinned) { thinned_ = thinned, listed_.clear(); }
  /// Unless the outline is kept there, or a doubt listed.
  void add(Vec at, double d) {
    if (!settled(at, d)) listed_.push_back({at, d});
  }
  /// Is nothing to be asked there: is the outline kept, or will it be?
  bool settled(Vec at, double d) const { return exact(at, d) || any_settles(listed_, at, d); }
  /// Is the outline kept there, so that what is d from it is d from the contours?
  bool exact(Vec at, double d) const { return any_settles(kept_, at, d); }
  bool any() const { return !listed_.empty(); }
  /// So many that little would be left to thin?
  bool many() const { return listed_.size() > kMany; }
  /// From now on contours within reach() of what is listed are kept.
  void keep() {
    kept_.insert(kept_.end(), listed_.begin(), listed_.end());
    listed_.clear();
  }
  void forget() { kept_.clear(), listed_.clear(); }
  std::span<const Doubt> kept() const { return kept_; }
  double reach(const Doubt& doubt) const { return doubt.d + kKept * thinned_; }
  /// Doubts no further apart leave nothing between them that is not settled.
  double spacing() const { return (kKept - kSure) * thinned_; }

 private:
  bool any_settles(std::span<const Doubt> doubts, Vec at, double d) const {
    return std::any_of(doubts.begin(), doubts.end(), [&](const Doubt& doubt) {
      const double off = reach(doubt) - kSure * thinned_ - d;
      return off >= 0 && dot(at - doubt.at, at - doubt.at) <= off * off;
    });
  }
  static constexpr std::size_t kMany = 1000;
  static constexpr double kKept = 40, kSure = 5;  // thinnings
  double thinned_ = 0;
  std::vector<Doubt> listed_, kept_;
};

}  // namespace firn::slice
