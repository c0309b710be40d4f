// The medial axis between walls, sampled by the largest discs that touch them, and what of it is worth a
// bead.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::slice {

/// An edge of an outline, area on its left.
struct Wall {
  Vec from, to, normal;  ///< normal: unit, to the left
  double begin = 0;      ///< way along the walls before it
  double length = 0;
  bool sampled = false;  ///< feet stand along it
};

/// A place of an outline that asks for the disc which touches the outline there.
struct Foot {
  Vec at, normal;
  double order = 0;      ///< way along the walls
  std::int32_t run = 0;  ///< feet of one run follow each other without a break
};

/// A place of the medial axis.
struct MedialPlace {
  Vec at;
  double radius = 0;  ///< of the disc about it that touches what is covered already, units
};

/// What a medial axis is asked with.
class AxisField {
 public:
  virtual ~AxisField() = default;
  /// How far a place is from what the next level covers; anything beyond `limit` may be told as that.
  virtual double clearance(Vec place, double limit) = 0;
};

struct AxisLimits {
  double covered = 0;    ///< distance from the walls at which the radius is 0
  double next = 0;       ///< distance from the walls beyond which nothing is asked for
  double narrowest = 0;  ///< least radius
  double drawn = 0;      ///< error of distances between drawn lines
  double inside = 0;     ///< so far the walls stand inward of those that shape the discs
};

/// Lines of places on the medial axis between `walls`, each with radius and clearance > 0, such that about no
/// foot's disc a spot of the least radius stays uncovered once each place's disc is: chains where two walls
/// face each other by more than 100 degrees, and single discs (chains of two places) for what is left then,
/// widest first. The centre of the largest disc that touches the outline in a foot lies on the medial axis:
/// the "shrinking ball" of J. Ma, S. Bae, S. Choi, "3D medial axis point approximation using nearest
/// neighbors and the normal field" (2012). Keeps its working memory.
class MiddleLines {
 public:
  MiddleLines();
  ~MiddleLines();
  /// @return valid until the next call
  std::span<const std::vector<MedialPlace>> operator()(std::span<const Wall> walls,
                                                       std::span<const Foot> feet, const AxisLimits& limits,
                                                       AxisField& field);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace firn::slice
