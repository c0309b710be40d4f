// Prints whose profiler is narrower than the part, and prints whose profiler keeps its rows.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "config/include.h"
#include "config/swaths.h"
#include "firn/height_map_t.hpp"
#include "firn/height_profile_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"

using namespace firn;

namespace {

struct PrintedSwaths {
  MemoryPrintReport report;
  std::vector<height_map_t> maps;
  std::vector<height_profile_t> first_rows;  ///< row 0 of each swath of the bare table
  int points = 0;                            ///< of all rows
  int rows_lost = 0;
};

Experiment wedge(std::vector<std::string> overrides) {
  for (const char* small : {"part.height_mm=0.06", "grid.nx=24", "grid.ny=24", "part.shape=wedge",
                            "part.width_mm=4.5", "part.depth_mm=4.5", "part.low_height_mm=0.01"})
    overrides.insert(overrides.begin(), small);
  return load_experiment(std::filesystem::path(FIRN_SOURCE_DIR) / "experiments" / "cylinder.toml", overrides);
}

PrintedSwaths printed_swaths(const std::vector<std::string>& overrides) {
  const Experiment e = wedge(overrides);
  PrintedSwaths p;
  MemoryPrintOptions o;
  o.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    const auto decode = [&](auto& m) { return m.decode(bytes.data(), 0, int(bytes.size())) > 0; };
    if (height_map_t m; channel == "HEIGHT_MAP" && decode(m)) p.maps.push_back(m);
    if (layer_metrics_t m; channel == "LAYER_METRICS" && decode(m)) p.rows_lost += m.rows_lost;
    if (height_profile_t m; channel == "HEIGHT_PROFILE" && decode(m)) {
      p.points += m.n;
      if (m.layer == 0 && m.row % e.grid.ny == 0) p.first_rows.push_back(m);
    }
  };
  p.report = print_in_memory(
      full_product(), e,
      make_inputs(full_product(), e, std::filesystem::path(FIRN_SOURCE_DIR) / "experiments"), o);
  return p;
}

}  // namespace

TEST_CASE("swaths cover the grid from rim to rim, side by side, with the overlap that was promised") {
  for (const int points : {100, 200, 333, 500, 700}) {
    const Experiment e =
        wedge({"laser_profiler.dx_mm=0.008", "laser_profiler.points=" + std::to_string(points)});
    const double line_mm = 0.008 * (points - 1), width_mm = 23 * e.grid.pitch_x_mm;
    const std::vector<double> shifts = swath_shifts_mm(e);
    INFO(points << " points, " << shifts.size() << " swaths");
    CHECK(shifts.front() - 0.5 * line_mm == Approx(-0.5 * width_mm));
    CHECK(shifts.back() + 0.5 * line_mm == Approx(0.5 * width_mm));
    for (std::size_t k = 1; k < shifts.size(); ++k)
      CHECK(shifts[k] - shifts[k - 1] <= line_mm - 2 * e.grid.pitch_x_mm + 1e-9);
    const double fewer = double(shifts.size()) - 1;  // one swath less would leave a gap or too little overlap
    CHECK(fewer * line_mm - (fewer - 1) * 2 * e.grid.pitch_x_mm < width_mm + 1e-9);
  }
  CHECK(swath_shifts_mm(wedge({"laser_profiler.dx_mm=0.008"})) == std::vector<double>{0.0});
  CHECK(swath_shifts_mm(wedge({})) == std::vector<double>{0.0});
}

TEST_CASE("a profiler narrower than the part measures it in swaths, stitched by the stage's x") {
  const PrintedSwaths wide = printed_swaths({}),
                      narrow = printed_swaths({"laser_profiler.dx_mm=0.003"});  // 2.4 mm of 6.1 mm
  REQUIRE(wide.report.result.status == 0);
  REQUIRE(narrow.report.result.status == 0);
  CHECK(wide.first_rows.size() == 1);
  REQUIRE(narrow.first_rows.size() == 3);
  for (std::size_t k = 1; k < 3; ++k) {
    CHECK(narrow.first_rows[k].row == std::int32_t(24 * k));
    CHECK(narrow.first_rows[k].rows == 72);
    CHECK(narrow.first_rows[k].x0_mm > narrow.first_rows[k - 1].x0_mm + 1.0);
    CHECK(narrow.first_rows[k].scan_id == narrow.first_rows[0].scan_id);
  }
  CHECK(narrow.rows_lost == 0);
  for (const height_map_t& m : narrow.maps) {
    CHECK(m.measured_fraction == 1.0);
    CHECK(m.rows_expected == 72);
  }
  CHECK(narrow.report.error.rms_mm < 1.2 * wide.report.error.rms_mm + 2e-4);
}

TEST_CASE("a profiler that keeps its rows loses none to a driver that asks too seldom") {
  const PrintedSwaths loses = printed_swaths(
      {"laser_profiler.poll_s=0.025", "process.max_rescans=0", "process.min_measured_fraction=0.3"});
  const PrintedSwaths keeps = printed_swaths({"laser_profiler.poll_s=0.025", "laser_profiler.read=memory"});
  CHECK(loses.rows_lost > 10);
  REQUIRE(keeps.report.result.status == 0);
  CHECK(keeps.rows_lost == 0);
  for (const height_map_t& m : keeps.maps) CHECK(m.rows_received == 24);
}

TEST_CASE("a profiler whose line is before or behind the nozzle scans the whole grid") {
  for (const char* offset : {"18.0", "-18.0"}) {
    INFO(offset);
    const PrintedSwaths p = printed_swaths({std::string("laser_profiler.offset_y_mm=") + offset});
    CHECK(p.report.result.status == 0);
    REQUIRE_FALSE(p.maps.empty());
    for (const height_map_t& m : p.maps) CHECK(m.measured_fraction == 1.0);
  }
}

TEST_CASE("a point laser that the stage moves measures each column, wherever it hangs") {
  const PrintedSwaths line = printed_swaths({});
  for (const auto& [x_mm, y_mm] : {std::pair{"0.0", "0.0"}, {"14.0", "-9.0"}}) {
    const PrintedSwaths p = printed_swaths({"devices.laser_profiler.kind=\"lkg\"",
                                            std::string("laser_profiler.offset_x_mm=") + x_mm,
                                            std::string("laser_profiler.offset_y_mm=") + y_mm});
    INFO(p.report.result.reason);
    REQUIRE(p.report.result.status == 0);
    REQUIRE(p.first_rows.size() == 24);
    for (std::size_t k = 1; k < 24; ++k) CHECK(p.first_rows[k].x0_mm > p.first_rows[k - 1].x0_mm);
    CHECK(p.rows_lost == 0);
    CHECK(p.points == int(p.maps.size()) * 24 * 24);
    for (const height_map_t& m : p.maps) {
      CHECK(m.measured_fraction > 0.95);  // a cell has one point: a place that is not seen is a hole
      CHECK(m.rows_received == 24 * 24);
      CHECK(m.noise_std_mm > 0.0);
    }
    CHECK(p.report.error.rms_mm < 2.0 * line.report.error.rms_mm);  // one sample a cell
  }
}
