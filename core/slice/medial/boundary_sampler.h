// BoundarySampler computes boundary samples with normals along chains without a next level, from which the
// medial axis is computed.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/boundary_chains.h"
#include "core/slice/medial/medial_axis.h"
#include "core/slice/medial/next_level.h"

namespace firn::slice {

/// Keeps its working memory.
class BoundarySampler {
 public:
  explicit BoundarySampler(NextLevel& next) : next_(next) {}

  /// @param limit distance of the levels, including the error of their drawing
  /// @param void_at distance from a sample to the centre of the smallest void that touches the covered edge
  /// in the sample
  /// @param enough voids whose centre is no further from the next level are ignored
  /// @param eroded_cores whether the chains bound eroded cores: only a sample beside a cusp of these sees the
  /// remaining void
  void begin(double limit, double void_at, double enough, bool eroded_cores);
  void clear();
  /// Adds the boundary segments of a chain and samples on them.
  void add(std::span<const geometry::Vec> points, const geometry::BoundaryChains::Chain& chain);
  void add_segments(std::span<const geometry::Vec> points, const geometry::BoundaryChains::Chain& chain);

  std::vector<BoundarySegment> segments;
  std::vector<BoundarySample> samples;

 private:
  bool covered(geometry::Vec void_disc);
  void add_sample(geometry::Vec at, geometry::Vec normal, double order);
  void sample_corner(std::size_t edge, std::size_t before);
  void sample_edge(std::size_t edge);

  NextLevel& next_;
  double limit_ = 0, void_at_ = 0, enough_ = 0;
  bool eroded_cores_ = false;
  bool begun_ = false;  // whether the run has a sample
  geometry::Vec last_at_, last_tip_;
  std::size_t first_segment_ = 0;  // first segment of the chain
  const geometry::BoundaryChains::Chain* chain_ = nullptr;
  std::int32_t run_ = 0;
  double way_ = 0;  // arc length of all segments
};

}  // namespace firn::slice
