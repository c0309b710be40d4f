// SegmentBatch finds the nearest or opposite one of up to 64 boundary segments, four at a time.
//
// Nearly all boundary chains are that short, and for them an R-tree is slower: slicing a scanned part with it
// alone takes 1.6 % more instructions.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/slice/medial/medial_axis.h"

namespace firn::slice {

/// Coordinates are floats relative to the first segment: precise to 0.01 um on a chain of 100 mm. Keeps its
/// working memory.
class SegmentBatch {
 public:
  static constexpr std::size_t kMaxSegments = 64;

  void take(std::span<const BoundarySegment> segments) {
    size_ = segments.size();
    blocks_.resize((segments.size() + 3) / 4);
    origin_ = segments.empty() ? geometry::Vec{} : segments[0].from;
    for (std::size_t i = 0; i < 4 * blocks_.size(); ++i) {
      Block& b = blocks_[i / 4];
      const std::size_t lane = i % 4;
      const BoundarySegment w =
          i < segments.size() ? segments[i]
                              : BoundarySegment{origin_ + geometry::Vec{kFar, kFar}, {}, {}, 0, 0, false};
      b.x[lane] = float(w.from.x - origin_.x);
      b.y[lane] = float(w.from.y - origin_.y);
      b.nx[lane] = float(w.normal.x);
      b.ny[lane] = float(w.normal.y);
      b.length[lane] = float(w.length);
    }
  }

  /// Returns the segment that bounds the disc which touches the outline in the sample and, on the opposite
  /// side, a segment or the corner where it begins.
  /// @param facing cosine of the angle between two normals beyond which segments do not face each other
  /// @param limit larger discs are ignored
  /// @return the number of segments if there is no such disc
  std::size_t opposite(const BoundarySample& sample, double facing, double limit) const {
    const Lanes fx = all(float(sample.at.x - origin_.x)), fy = all(float(sample.at.y - origin_.y));
    const Lanes nx = all(float(sample.normal.x)), ny = all(float(sample.normal.y));
    const Lanes open = all(float(1 - facing)), zero{}, none = all(std::numeric_limits<float>::max());
    Lanes best = all(float(limit));
    Ints at = {-1, -1, -1, -1}, here = {0, 1, 2, 3};
    for (const Block& b : blocks_) {
      const Lanes ox = b.x - fx, oy = b.y - fy;
      const Lanes ahead = ox * nx + oy * ny, square = ox * ox + oy * oy, twice = ahead + ahead;
      const Lanes to_corner = ((ahead > zero) & (square * open <= twice * ahead)) ? square / twice : none;
      const Lanes height = -(ox * b.nx + oy * b.ny), opening = 1 - (nx * b.nx + ny * b.ny),
                  radius = height / opening;
      // Distance along the segment from its first point to the centre of the disc; the direction is the
      // normal turned to the right.
      const Lanes along = (radius * nx - ox) * b.ny - (radius * ny - oy) * b.nx;
      const Lanes to_wall =
          ((opening >= open) & (height >= zero) & (along >= zero) & (along <= b.length)) ? radius : none;
      const Lanes nearer = to_corner < to_wall ? to_corner : to_wall;
      at = nearer < best ? here : at;
      best = nearer < best ? nearer : best;
      here += 4;
    }
    std::size_t segment = size_;
    float least = float(limit);
    for (std::size_t lane = 0; lane < 4; ++lane)
      if (at[lane] >= 0 && best[lane] < least) {
        least = best[lane];
        segment = std::size_t(at[lane]);
      }
    return segment;
  }

  /// Returns the square of the distance to the nearest segment.
  double square_depth(geometry::Vec place) const {
    const Lanes px = all(float(place.x - origin_.x)), py = all(float(place.y - origin_.y)), zero{};
    Lanes best = all(std::numeric_limits<float>::max());
    for (const Block& b : blocks_) {
      const Lanes ox = px - b.x, oy = py - b.y;
      const Lanes way = ox * b.ny - oy * b.nx, ahead = way > zero ? way : zero,
                  along = ahead < b.length ? ahead : b.length;
      const Lanes x = ox - along * b.ny, y = oy + along * b.nx, square = x * x + y * y;
      best = square < best ? square : best;
    }
    const Lanes turned = __builtin_shufflevector(best, best, 2, 3, 0, 1), two = best < turned ? best : turned;
    return double(two[0] < two[1] ? two[0] : two[1]);
  }

 private:
  using Lanes = float __attribute__((vector_size(16)));
  using Ints = std::int32_t __attribute__((vector_size(16)));
  struct Block {
    Lanes x, y, nx, ny, length;  // of four segments
  };
  static constexpr double kFar = 1e9;
  static Lanes all(float v) { return Lanes{v, v, v, v}; }

  std::vector<Block> blocks_;
  std::size_t size_ = 0;
  geometry::Vec origin_;
};

}  // namespace firn::slice
