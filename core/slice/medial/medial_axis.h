// MedialAxis computes the medial axis between boundary segments, sampled by maximal inscribed discs.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::slice {

/// A boundary segment, with the area on its left.
struct BoundarySegment {
  geometry::Vec from, to, normal;  ///< normal: unit, to the left
  double begin = 0;                ///< arc length of the segments before it
  double length = 0;
  bool sampled = false;  ///< samples add_sample along it
};

/// A boundary sample: a point of the outline with its normal, for which the maximal inscribed disc that
/// touches it is computed.
struct BoundarySample {
  geometry::Vec at, normal;
  double order = 0;      ///< way along the segments
  std::int32_t run = 0;  ///< samples of one run follow each other without a break
};

/// A point of the medial axis.
struct MedialPoint {
  geometry::Vec at;
  double radius = 0;  ///< of the disc about it that touches the covered area, units
};

/// ClearanceField computes distances to the area that the next level covers.
class ClearanceField {
 public:
  virtual ~ClearanceField() = default;
  /// Returns the distance of a point from the covered area; `limit` may stand for any distance beyond it.
  virtual double clearance(geometry::Vec place, double limit) = 0;
};

struct MedialLimits {
  double covered = 0;    ///< distance from the segments where the radius is 0
  double next = 0;       ///< maximum distance from the segments
  double narrowest = 0;  ///< minimum radius
  double drawn = 0;      ///< error of distances between drawn rings
  double inside = 0;     ///< distance of the segments from those that define the discs
};

/// Computes branches of the medial axis between `segments`: points with radius and clearance > 0 such that no
/// void of the minimum radius remains uncovered about the disc of any sample. Branches are polylines where
/// two segments face each other by more than 100 degrees; areas that they leave uncovered get single discs
/// (branches of two points), in descending order of their radius. The centre of the largest disc that touches
/// the outline in a sample lies on the medial axis: the "shrinking ball" of J. Ma, S. Bae, S. Choi, "3D
/// medial axis point approximation using nearest neighbors and the normal field" (2012). Keeps its working
/// memory.
class MedialAxis {
 public:
  MedialAxis();
  ~MedialAxis();
  /// @return valid until the next call
  std::span<const std::vector<MedialPoint>> operator()(std::span<const BoundarySegment> segments,
                                                       std::span<const BoundarySample> samples,
                                                       const MedialLimits& limits, ClearanceField& field);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace firn::slice
