// Where the tips of the front would be, had the outline not been thinned.
//
// An outline thinned by e moves the front by e, but a tip in which two walls of half angle a meet by e /
// sin(a). So tips are taken from the contours that the outline was thinned from: the place that lies at the
// asked distance from both walls.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/box_search.h"
#include "core/slice/offset/doubts.h"
#include "core/geometry/region.h"
#include "core/geometry/vec.h"
#include "core/slice/offset/wall_edges.h"

namespace firn::slice {

class ExactTips {
 public:
  /// Forgets its doubts. @param contours from which an outline was thinned; they stay where they are
  void take(const Rings& contours);

  /// One of the two walls that meet in a tip: the tip's foot on it, and the direction (of length 1) of the
  /// outline there.
  struct Wall {
    Vec foot, along;
  };
  /// Cosine of the turn of the front from which on it is a tip: what is blunter moves by at most 1.06 times
  /// the thinning.
  static constexpr double kTip = 0.8;

  /// The tip between walls `before` and `after`, known to be about `tip`, at distance d from the contours.
  /// @return false if there is none near by, or if it is in its place: then `tip` is as it was
  bool move(Vec& tip, const Wall& before, const Wall& after, double d);
  /// For an outline. @param thinned units by which it and the contours may differ @param asks whether doubts
  /// are to be listed
  void begin(double thinned, bool asks) {
    thinned_ = thinned, asks_ = asks, failed_ = false;
    doubts_.begin(thinned);
  }
  bool asks() const { return asks_; }
  /// Is no wall nearer to a tip than d, to within a quarter of the thinning? Two walls alone tell where a tip
  /// is; where an area is hardly wider than the thinning a third one may be nearer.
  bool clear(Vec tip, double d) const { return within(tip, d - 0.25 * thinned_); }
  /// Is a place at least d from the contours?
  bool within(Vec place, double d) const;
  double thinned() const { return thinned_; }
  /// Rings do not fit together although the outline is as the contours are.
  void fail() { failed_ = asks_; }
  /// Is the outline better not thinned at all?
  bool failed() const { return failed_ || doubts_.many(); }
  /// Where a tip sharper than a right angle has no exact place, or is far from it, an area may begin or end;
  /// and wherever else somebody finds that.
  Doubts& doubts() { return doubts_; }
  /// Which of the contours' points are to stay in an outline that has doubts kept?
  std::vector<char> kept() const;
  /// Bends no further apart are one tip.
  double near() const { return 4 * thinned_; }

 private:
  double furthest(const Wall& before, const Wall& after) const;
  bool find(Vec& tip, const Wall& before, const Wall& after, double d);
  void look_along(Vec tip, Vec direction, double far, double closes, double d);
  void look(const Wall& wall, const Wall& other, double reach, WallEdges& edges) const;

  std::span<const Point> points_;  // of the contours
  double thinned_ = 0;
  bool asks_ = false, failed_ = false;
  Doubts doubts_;
  std::vector<std::uint32_t> next_;
  BoxSearch tree_;
  WallEdges edges_[2];  // of each wall
};

}  // namespace firn::slice
