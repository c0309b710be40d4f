// Value, limit, unit and key of interlocks beside the sentences that the checks themselves write.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "config/fields.h"
#include "core/grid/random.h"
#include "firn/enums.h"
#include "procs/scheduler/jet_check.h"
#include "procs/scheduler/path_batch.h"
#include "procs/scheduler/path_map_check.h"
#include "procs/scheduler/rise_check.h"
#include "procs/scheduler/scrape_check.h"
#include "procs/scheduler/sensor_check.h"
#include "tests/support/figure_words.h"

using namespace firn;

namespace {

const GridSpec kTwelve{12, 12, 0.25, 0.25, 0.0, 0.0};

void check(const Violation& v, double value, double limit, const std::string& unit, const std::string& key) {
  INFO(v.text);
  REQUIRE_FALSE(v.empty());
  CHECK(figure_words::figure_contradiction(v.text, v.figure) == "");
  CHECK(v.figure.value.value_or(NAN) == Approx(value).epsilon(1e-4));
  CHECK(v.figure.limit.value_or(NAN) == Approx(limit).epsilon(1e-4));
  CHECK(v.figure.unit == unit);
  CHECK(v.figure.key == key);
}

bool is_key(const std::string& key) {
  static Experiment e;
  for (const Field& f : fields(e))
    if (f.key == key) return true;
  return false;
}

}  // namespace

TEST_CASE("the clearance that is left is told beside the one that is needed") {
  HeightMap map(kTwelve, 0.2);
  map.at(3, 4) = 0.9;
  check(scrape(map, 1.0, 0.3), 0.1, 0.3, "mm", "process.nozzle_clearance_mm");
  check(scrape(map, 0.8, 0.3), -0.1, 0.3, "mm", "process.nozzle_clearance_mm");
  path_job_t job{};
  job.x_max_mm = job.y_max_mm = 2.5;
  job.z_mm = 1.2;
  check(scrape(job, map, 0.5), 0.3, 0.5, "mm", "ice.clearance_mm");
  map.at(3, 4) = kNotMeasured;
  CHECK_FALSE(scrape(map, 1.0, 0.3).figure.value);  // a cell without a height has no figure
  CHECK_FALSE(scrape(job, map, 0.5).figure.value);
}

TEST_CASE("a dead nozzle and a leak are told by the share of the rise that was expected") {
  Experiment e;
  e.grid = kTwelve;
  e.process.least_rise_share = 0.3;
  e.process.most_rise_share = 2.0;
  const double layer_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm;
  const HeightMap before(kTwelve, 0.1);
  const DropletPattern all(kTwelve, 1);
  const auto of = [&](const DropletPattern& drops, double rise_mm) {
    return RiseCheck().check(e, {before, HeightMap(kTwelve, 0.1 + rise_mm), 0.0, 0.0, drops, {}, {}});
  };
  // Cells at the edge expect less: by the model's own sum over the grid.
  double expected_mm = 0.0;
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) {
      const int x = i > 0 && i < 11 ? 2 : 1, y = j > 0 && j < 11 ? 2 : 1;
      expected_mm += e.model.h1_mm + e.model.h2_mm * (x + y) + e.model.h3_mm * x * y;
    }
  expected_mm /= 144.0;
  check(of(all, 0.1 * layer_mm), 0.1 * layer_mm / expected_mm, 0.3, "", "process.least_rise_share");
  check(of(all, 3.0 * layer_mm), 3.0 * layer_mm / expected_mm, 2.0, "", "process.most_rise_share");
  check(of(DropletPattern(kTwelve), 0.5 * layer_mm), 500.0 * layer_mm, 300.0 * layer_mm, "um",
        "process.least_rise_share");
}

TEST_CASE("a sensor that is not as calibrated is told by how far it is off") {
  const SensorWords words{"the bare table", "its zero", "calibrate", "laser_profiler.bias_limit_mm"};
  check(check_bare(HeightMap(kTwelve, -0.042), 0.01, words), -0.042, 0.01, "mm", words.key);
  const GridSpec grid{40, 40, 0.1, 0.1, 0.0, 0.0};
  Mask laid(grid);
  HeightMap rise(grid, 0.0);
  for (int j = 10; j < 30; ++j)
    for (int i = 10; i < 30; ++i) {
      laid.at(i, j) = 1;
      rise.at(i + 3, j - 4) = 0.2;
    }
  const Violation aside = check_outline(rise, laid, {}, 0.2, words);
  check(aside, std::hypot(0.3, 0.4), 0.2, "mm", words.key);
}

TEST_CASE("a jet out of its band is told by what the camera saw") {
  droplet_sweep_t m{};
  m.frames = m.with_droplet = m.used = 20;
  m.um_per_px = 2.0;
  m.known = std::int32_t(SweepValue::kVelocity);
  m.velocity_mm_s = 900.0;
  m.velocity_std_mm_s = 20.0;
  droplet::WatchOptions o;
  o.velocity_least_m_s = 1.5;
  check(jet_out_of_band(m, o), 0.9, 1.5, "m/s", "watch.velocity_least_m_s");
  m.velocity_mm_s = 1e3 * (o.velocity_most_m_s + 1.0);
  check(jet_out_of_band(m, o), o.velocity_most_m_s + 1.0, o.velocity_most_m_s, "m/s",
        "watch.velocity_most_m_s");
  m.velocity_mm_s = 1e3 * 0.5 * (o.velocity_least_m_s + o.velocity_most_m_s);
  m.angle_rad = 0.5;
  check(jet_out_of_band(m, o), 28.6479, o.angle_most_deg, "deg", "watch.angle_most_deg");
  m.angle_rad = 0.0;
  m.satellites = o.satellites_most + 2.0;
  check(jet_out_of_band(m, o), o.satellites_most + 2.0, o.satellites_most, "", "watch.satellites_most");
  m.with_droplet = 0;
  CHECK_FALSE(jet_out_of_band(m, o).figure.value);
}

TEST_CASE("a surface that rises between two measurements of a layer is told by its rise") {
  Experiment e;
  e.ice.least_rise_share = 0.25;
  e.ice.layer_height_mm = 0.4;
  check(rise_without_command(e, 3, HeightMap(kTwelve, 0.4), HeightMap(kTwelve, 0.6)), 0.2, 0.1, "mm",
        "ice.least_rise_share");
}

TEST_CASE("every figure of random maps agrees with its sentence, and its key is one of the configuration") {
  RandomStream random(8, Purpose::kTest);
  Experiment e;
  e.grid = kTwelve;
  e.ice.least_rise_share = 0.2;
  int told = 0;
  const auto agrees = [&](const Violation& v) {
    CHECK(v.empty() != v.figure.value.has_value());
    if (v.empty()) return;
    ++told;
    REQUIRE(figure_words::figure_contradiction(v.text, v.figure) == "");
    REQUIRE(is_key(v.figure.key));
  };
  for (int n = 0; n < 2000; ++n) {
    HeightMap before(kTwelve, 0.0), after(kTwelve, 0.0);
    DropletPattern drops(kTwelve);
    const double rise_mm = random.uniform(-0.02, 0.05);
    for (std::size_t c = 0; c < before.size(); ++c) {
      before.cells[c] = random.uniform(0.0, 0.02);
      after.cells[c] = before.cells[c] + rise_mm * random.uniform(0.5, 1.0);
      drops.cells[c] = std::int8_t(random.below(n % 2 ? 2 : 1));
    }
    agrees(RiseCheck().check(e, {before, after, 0.0, 0.0, drops, {}, {}}));
    agrees(rise_without_command(e, 2, before, after));
    agrees(check_bare(after, random.uniform(0.001, 0.02), {"a", "b", "c", "laser_point.bias_limit_mm"}));
    agrees(scrape(after, random.uniform(-0.1, 0.3), random.uniform(0.01, 0.3)));
    path_job_t job{};
    job.x_max_mm = job.y_max_mm = random.uniform(0.1, 3.0);
    job.z_mm = random.uniform(-0.1, 0.3);
    agrees(scrape(job, after, random.uniform(0.01, 0.3)));
  }
  CHECK(told > 2000);
}

TEST_CASE("keys that faults of drivers and loops name are keys of the configuration") {
  for (const char* key :
       {"process.min_measured_fraction", "process.max_lost_rows_share", "process.most_beside_share",
        "process.most_path_error_mm", "process.least_rise_share", "process.most_rise_share",
        "ice.max_time_slip_s", "ice.saturated_share", "ice.least_rise_share", "ice.clearance_mm",
        "heater.low_degC", "gas.lost_share", "gas.tolerance", "gas.most_pressure_kpa",
        "laser_point.bias_limit_mm", "laser_point.offset_limit_mm", "laser_profiler.bias_limit_mm",
        "laser_profiler.offset_limit_mm", "devices.stage.dialect.tolerance_mm"}) {
    INFO(key);
    CHECK(is_key(key));
  }
}
