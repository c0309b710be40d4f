// Effects of the keys of [ice] on the paths of a print, and on the material laid along them.
#include "print/inputs/ice_inputs.h"

#include <fmt/core.h>
#include <catch2/catch.hpp>
#include <cmath>

#include "config/ice_lab.h"
#include "core/slice/paths/path_codec.h"
#include "print/prepare/slice_job.h"
#include "tests/print/ice_runs.h"

using namespace firn;
using namespace firn::test;

namespace {

slice::PrintPaths paths_of(const SmallIce& part) {
  return slice::decode_print_paths(blob(part.inputs, "paths").bytes);
}

planning::PlanningSetup setup_of(const SmallIce& part) {
  const auto& bytes = blob(part.inputs, "machine").bytes;
  return planning_setup(
      part.experiment, parse_machine({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "machine"));
}

double length_of(const planning::PathTask& t) {
  double length = 0.0;
  for (std::size_t n = 1; n < t.points.size() + (t.closed ? 1 : 0); ++n) {
    const Point2 &a = t.points[n - 1], &b = t.points[n % t.points.size()];
    length += std::hypot(b.x_mm - a.x_mm, b.y_mm - a.y_mm);
  }
  return length;
}

}  // namespace

TEST_CASE(
    "Measurement paths begin as far inside their material as ice.measure_offset_mm says, and as its first "
    "bead without it") {
  const SliceSettings settings =
      load_slice_settings(std::filesystem::path(FIRN_SOURCE_DIR) / "experiments" / "slicing" / "ice.toml");
  const double edges_mm[] = {20.0, 20.0 + 2.0 * settings.paths.support.buffer_mm}, spacing_mm = 2.0;
  for (const double offset_mm : {0.0, 0.4, 1.1, 1.6}) {
    const slice::PrintPaths paths =
        paths_of(small_ice_part({fmt::format("ice.measure_offset_mm={}", offset_mm), "ice.height_mm=1.2"}));
    const slice::LayerPaths& top = paths.layers.back();
    for (std::size_t material = 0; material < 2; ++material) {
      const slice::ExtrusionOptions& bead = (material == 0 ? settings.part : settings.scaffold).bead;
      const double wanted_mm =
          offset_mm > 0.0 ? offset_mm : std::max(bead.first_offset_mm, 0.25 * spacing_mm);
      double low = 1e9, high = -1e9;
      for (std::size_t n = 0; n < top.info.size(); ++n)
        if (top.info[n].kind == PathKind::kMeasurement && top.info[n].material == material)
          for (const geometry::Point& p : top.lines[n]) {
            low = std::min(low, p.x * geometry::kMmPerUnit);
            high = std::max(high, p.x * geometry::kMmPerUnit);
          }
      INFO("offset " << offset_mm << " mm, material " << material);
      // Scaffold reaches no further than its buffer, and less by up to two chord tolerances.
      const double inside_mm = 0.5 * (edges_mm[material] - (high - low));
      CHECK(inside_mm > wanted_mm - 0.01);
      CHECK(inside_mm < wanted_mm + 0.01 + (material == 0 ? 0.0 : 2.0 * settings.contour.chord_tolerance_mm));
    }
  }
}

TEST_CASE(
    "With ice.coverage off every bead gets its width, height and length, and with the window less flows "
    "where beads overlap") {
  for (const bool off : {true, false}) {
    const SmallIce part =
        small_ice_part({std::string("ice.coverage=") + (off ? "off" : "window"), "ice.height_mm=1.2"});
    const slice::PrintPaths paths = paths_of(part);
    const planning::PlanningSetup setup = setup_of(part);
    planning::TaskPlanner planner(setup);
    double max_mm3 = 0.0;
    for (const planning::PathTask& task : planning::tasks_of(paths, paths.layers.front(), false, setup)) {
      const planning::PlannedTask planned = planner.plan(task, nullptr);
      REQUIRE(planned.problem.empty());
      max_mm3 = std::max(
          max_mm3, std::abs(planned.volume_mm3 - task.width_mm * task.layer_height_mm * length_of(task)));
    }
    constexpr double kDrop_mm3 = 0.25;
    if (off)
      CHECK(max_mm3 < kDrop_mm3);
    else
      CHECK(max_mm3 > 4.0 * kDrop_mm3);
  }
}
