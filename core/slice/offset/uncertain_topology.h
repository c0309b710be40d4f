// UncertainTopology holds the places where a simplified outline may bound other areas than its contours.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::slice {

/// The offset curve near a place at distance d depends on the contours within d of it plus a margin. At an
/// uncertain place these contours are therefore kept when the outline is simplified again (refinement), which
/// resolves the place. Units.
class UncertainTopology {
 public:
  struct Place {
    geometry::Vec at;
    double d;
  };
  /// Begins an outline. @param simplified maximum distance between it and the contours, except where these
  /// are kept
  void begin(double simplified) {
    simplified_ = simplified;
    listed_.clear();
  }
  /// Lists a place unless it is resolved.
  void add(geometry::Vec at, double d) {
    if (!resolved(at, d)) listed_.push_back({at, d});
  }
  /// Returns whether the place is resolved: the outline is kept there, or a listed place covers it.
  bool resolved(geometry::Vec at, double d) const { return exact(at, d) || any_resolves(listed_, at, d); }
  /// Returns whether the outline is kept there, so that points at distance d from it are at distance d from
  /// the contours.
  bool exact(geometry::Vec at, double d) const { return any_resolves(kept_, at, d); }
  bool any() const { return !listed_.empty(); }
  /// Returns whether there are so many places that little would remain to be simplified.
  bool many() const { return listed_.size() > kMany; }
  /// Resolves the listed places: contours within reach() of them are kept from now on.
  void refine() {
    kept_.insert(kept_.end(), listed_.begin(), listed_.end());
    listed_.clear();
  }
  void forget() {
    kept_.clear();
    listed_.clear();
  }
  std::span<const Place> kept() const { return kept_; }
  double reach(const Place& place) const { return place.d + kKept * simplified_; }
  /// Places no further apart leave no unresolved point between them.
  double spacing() const { return (kKept - kSure) * simplified_; }

 private:
  bool any_resolves(std::span<const Place> uncertain, geometry::Vec at, double d) const {
    return std::any_of(uncertain.begin(), uncertain.end(), [&](const Place& place) {
      const double off = reach(place) - kSure * simplified_ - d;
      return off >= 0 && dot(at - place.at, at - place.at) <= off * off;
    });
  }
  static constexpr std::size_t kMany = 1000;
  static constexpr double kKept = 40, kSure = 5;  // simplifications
  double simplified_ = 0;
  std::vector<Place> listed_, kept_;
};

}  // namespace firn::slice
