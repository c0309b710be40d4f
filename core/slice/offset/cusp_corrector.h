// CuspCorrector computes the cusps that an offset curve would have if its outline had not been simplified.
//
// A simplification by e moves the offset curve by e, but a cusp between two sides of half angle a by e /
// sin(a). Cusps are therefore computed from the contours from which the outline was simplified: a cusp is the
// point at the requested distance from both sides.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/region.h"
#include "core/geometry/rtree.h"
#include "core/geometry/vec.h"
#include "core/slice/offset/edge_batch.h"
#include "core/slice/offset/uncertain_topology.h"

namespace firn::slice {

class CuspCorrector {
 public:
  /// Begins with new contours, which must outlive their use, and clears uncertain places. @param contours
  /// from which an outline was simplified
  void take(const geometry::Rings& contours);

  /// One of the two sides of a cusp: its nearest point on the outline and the unit direction of the outline
  /// there.
  struct Side {
    geometry::Vec foot, along;
  };
  /// Cosine of the turn of the offset curve below which a corner is a cusp: blunter corners move by at most
  /// 1.06 times the simplification.
  static constexpr double kCusp = 0.8;

  /// Corrects the cusp between sides `before` and `after`, approximately at `cusp`, to distance d from the
  /// contours.
  /// @return false, with `cusp` unchanged, if there is no such point near it or if it is exact already
  bool move(geometry::Vec& cusp, const Side& before, const Side& after, double d);
  /// Begins an outline. @param simplified maximum distance [units] between it and the contours @param
  /// lists_uncertain whether uncertain places are listed
  void begin(double simplified, bool lists_uncertain) {
    simplified_ = simplified;
    lists_uncertain_ = lists_uncertain;
    failed_ = false;
    uncertain_.begin(simplified);
  }
  bool lists_uncertain() const { return lists_uncertain_; }
  /// Returns whether no contour is nearer to a cusp than d, within a quarter of the simplification. Two sides
  /// define a cusp; where an area is hardly wider than the simplification, a third one may be nearer.
  bool clear(geometry::Vec cusp, double d) const { return within(cusp, d - 0.25 * simplified_); }
  /// Returns whether a point is at least d from the contours.
  bool within(geometry::Vec place, double d) const;
  double simplified() const { return simplified_; }
  /// Reports that rings intersect although the outline is not simplified there.
  void fail() { failed_ = lists_uncertain_; }
  /// Returns whether the outline should not be simplified at all.
  bool failed() const { return failed_ || uncertain_.many(); }
  /// Places of uncertain topology: an area may begin or end where a cusp sharper than a right angle has no
  /// exact position or is far from it, and where topology_check.h finds a place.
  UncertainTopology& uncertain() { return uncertain_; }
  /// Returns which points of the contours must remain when an outline with refined places is simplified.
  std::vector<char> kept() const;
  /// Bends no further apart belong to one cusp.
  double near() const { return 4 * simplified_; }

 private:
  double furthest(const Side& before, const Side& after) const;
  bool find(geometry::Vec& cusp, const Side& before, const Side& after, double d);
  void look_along(geometry::Vec cusp, geometry::Vec direction, double far, double closes, double d);
  void look(const Side& side, const Side& other, double reach, EdgeBatch& edges) const;

  std::span<const geometry::Point> points_;  // of the contours
  double simplified_ = 0;
  bool lists_uncertain_ = false, failed_ = false;
  UncertainTopology uncertain_;
  std::vector<std::uint32_t> next_;
  geometry::StaticRTree tree_;
  EdgeBatch edges_[2];  // of each side
};

}  // namespace firn::slice
