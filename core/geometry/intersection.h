// intersection_of() computes whether rings are disjoint, touch or cross.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/monotone_chains.h"
#include "core/geometry/region.h"

namespace firn::geometry {

/// Two rings touch if edges have a point in common that is not the corner between neighbours.
enum class Intersection { kDisjoint, kTouching, kCrossing };
Intersection intersection_of(const Rings& rings);

/// IntersectionCheck computes intersection_of() for many sets of rings and keeps its working memory.
class IntersectionCheck {
 public:
  /// Two edges of the same ring or of two rings.
  struct Pair {
    std::uint32_t one, other;
  };
  /// @param within if above 0, edges of opposite direction no further apart than this [units] are listed
  Intersection operator()(const Rings& rings, double within = 0);
  /// Returns the edges listed by the last check.
  std::span<const Pair> facing() const { return facing_; }
  std::uint32_t next(std::uint32_t edge) const { return next_[edge]; }
  /// Returns one of the edges with the worst intersection, if the rings are not disjoint.
  std::uint32_t met() const { return met_; }

 private:
  void add_chains(const Point* points, std::uint32_t begin, std::uint32_t end);
  MonotoneChains chains_;
  std::vector<std::uint32_t> next_;
  std::vector<Pair> facing_;
  std::uint32_t met_ = 0;
};

}  // namespace firn::geometry
