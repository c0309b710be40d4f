// ExtrusionLines in gaps as motions of the arm: they are no slower than paths of their length need to be.
#include <catch2/catch.hpp>

#include "core/geometry/vec.h"
#include "core/motion/planner.h"
#include "core/slice/paths/path_plan.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

TEST_CASE("The motion along a bead in a gap takes a stop at each corner and its length at 25 mm/s, no more") {
  const auto arm = motion::make_scara(motion::cobra600());
  motion::PlanWorkspace work;
  int planned = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    LayerRegions regions{
        1,
        2500,
        2500,
        {seed % 2 ? outlines::random_star(seed, 10 + int(seed), 4, 22) : outlines::blob(seed)}};
    const LayerPaths paths = plan_layer(regions, {});
    for (std::size_t i = 0; i < paths.lines.size(); ++i) {
      const Path path = to_path(paths, i);
      if (path.closed) continue;
      INFO("seed " << seed << ", path " << i);
      motion::PathInput input;
      input.points = path.points;
      input.origin = {354, -46};
      double length_mm = 0;
      for (std::size_t p = 1; p < path.points.size(); ++p)
        length_mm += geometry::kMmPerUnit * length(to_vec(paths.lines[i][p]) - to_vec(paths.lines[i][p - 1]));
      const motion::PlanResult result = motion::plan(input, *arm, motion::cobra600_limits(), {}, work);
      REQUIRE(result.ok());
      ++planned;
      CHECK(result.continuous_s <= 0.4 * double(1 + result.stops) + length_mm / 25);
      CHECK(result.stops <= 1 + std::size_t(length_mm / 2));
    }
  }
  CHECK(planned > 50);
}

}  // namespace
}  // namespace firn::slice
