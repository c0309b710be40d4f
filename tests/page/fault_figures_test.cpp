// Value and limit of interlocks, in the words that the interlocks themselves write.
#include "page/fault_figures.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "firn/enums.h"
#include "procs/scheduler/jet_check.h"
#include "procs/scheduler/path_batch.h"
#include "procs/scheduler/rise_check.h"
#include "procs/scheduler/scrape_check.h"
#include "procs/scheduler/sensor_check.h"

using namespace firn;
using namespace firn::page;

namespace {

void check(int code, const std::string& words, double value, std::optional<double> limit, const char* unit,
           const std::map<std::string, double>& settings = {}) {
  INFO(words);
  REQUIRE_FALSE(words.empty());
  const auto f = fault_figures(code, words, settings);
  REQUIRE(f);
  CHECK(f->value == Approx(value).epsilon(1e-4));
  REQUIRE(f->limit.has_value() == limit.has_value());
  if (limit) CHECK(*f->limit == Approx(*limit).epsilon(1e-4));
  CHECK(f->unit == unit);
}

const GridSpec kTwelve{12, 12, 0.25, 0.25, 0.0, 0.0};

}  // namespace

TEST_CASE("the clearance that is left is told beside the one that is needed") {
  HeightMap map(kTwelve, 0.2);
  map.at(3, 4) = 0.9;
  const std::map<std::string, double> keys{{"process.nozzle_clearance_mm", 0.3}, {"ice.clearance_mm", 0.5}};
  check(6, "layer 4: " + scrape(map, 1.0, 0.3) + "; measuring again", 0.1, 0.3, "mm", keys);
  path_job_t job{};
  job.x_max_mm = job.y_max_mm = 2.5;
  job.z_mm = 1.2;
  check(6, "path 7 of layer 2: " + scrape(job, map, 0.5), 0.3, 0.5, "mm", keys);
}

TEST_CASE("a clogged nozzle is told by its pressure, a lost gas by the share that flows") {
  check(16, "gas: sheath: 130.2 kPa behind the nozzle, gas.most_pressure_kpa = 120: it clogs", 130.2, 120.0,
        "kPa");
  const std::map<std::string, double> keys{{"gas.lost_share", 0.5}};
  check(16, "gas: sheath: 4 of 40 sccm flow: bottle, tube, valve?", 0.1, 0.5, "", keys);
  check(16, "gas: atomizer: 5 of 20 sccm flow after gas.settle_s", 0.25, 0.5, "", keys);
}

TEST_CASE("a dead nozzle and a leak are told by the share of the rise that was expected") {
  Experiment e;
  e.grid = kTwelve;
  e.process.least_rise_share = 0.3;
  e.process.most_rise_share = 2.0;
  const double layer_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm;
  const HeightMap before(kTwelve, 0.1);
  const std::map<std::string, double> keys{{"process.least_rise_share", 0.3},
                                           {"process.most_rise_share", 2.0}};
  const DropletPattern all(kTwelve, 1);
  const auto words = [&](const DropletPattern& drops, double rise_mm) {
    return "layer 3: " + check_rise(e, before, HeightMap(kTwelve, 0.1 + rise_mm), drops, {});
  };
  // Cells at the edge expect less: by the model's own sum over the grid.
  double expected_mm = 0.0;
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) {
      const int x = i > 0 && i < 11 ? 2 : 1, y = j > 0 && j < 11 ? 2 : 1;
      expected_mm += e.model.h1_mm + e.model.h2_mm * (x + y) + e.model.h3_mm * x * y;
    }
  expected_mm /= 144.0;
  check(12, words(all, 0.1 * layer_mm), 0.1 * layer_mm / expected_mm, 0.3, "", keys);
  check(12, words(all, 3.0 * layer_mm), 3.0 * layer_mm / expected_mm, 2.0, "", keys);
  check(12, words(DropletPattern(kTwelve), 0.5 * layer_mm), 500.0 * layer_mm, std::nullopt, "um", keys);
}

TEST_CASE("a sensor that is not as calibrated is told by how far it is off") {
  check(15, check_bare(HeightMap(kTwelve, -0.042), 0.01, {"the bare table", "its zero", "calibrate"}), -0.042,
        0.01, "mm");
  check(
      15,
      "the first layer lies (0.300000, -0.400000) mm aside of its outline, at most 0.200000 mm is calibrated",
      0.5, 0.2, "mm");
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
  check(11, "the jet before layer 2: " + jet_out_of_band(m, o), 0.9, 1.5, "m/s");
  m.velocity_mm_s = 1e3 * 0.5 * (o.velocity_least_m_s + o.velocity_most_m_s);
  m.angle_rad = 0.5;
  check(11, jet_out_of_band(m, o), 28.6, o.angle_most_deg, "deg");
}

TEST_CASE("other interlocks are told by the numbers of their words") {
  check(13, "height map of layer 3 measures 0.450000 of the grid; 0.800000 is needed; measuring again", 0.45,
        0.8, "");
  check(13, "the scan of layer 3 measures 0.450000 of the grid, 0.800000 is needed, and lost 4 rows", 0.45,
        0.8, "");
  check(13, "height map of layer 5: the laser has measured 0.45 of it; 0.8 is needed", 0.45, 0.8, "");
  check(13, "height map of layer 3 lacks 10 of 40 rows of its scan; measuring again at 7.5 mm/s", 0.25, 0.1,
        "", {{"process.max_lost_rows_share", 0.1}});
  check(7, "path 3 took 1.250000 s instead of 1.000000 s, as the one before: its pulses lie elsewhere", 0.25,
        0.1, "s", {{"ice.max_time_slip_s", 0.1}});
  check(10,
        "the end effector's tip is at -3.500000 degC, below heater.low_degC = 2.000000: the valves freeze",
        -3.5, 2.0, "degC");
  CHECK_FALSE(fault_figures(13, "measures nothing of the grid; 0.8 is needed", {}));
  CHECK_FALSE(fault_figures(13, "measures inf of the grid; 0.8 is needed", {}));
  CHECK_FALSE(fault_figures(1, "an emergency stop was pressed 3 times", {}));
  CHECK_FALSE(fault_figures(12, "rose by 3 um on average, 0 um is expected: drops without rise", {}));
}

TEST_CASE("random words are read or passed over, and nothing else") {
  const std::string_view pieces[] = {"measures ",
                                     "of the grid; ",
                                     "is needed",
                                     "took ",
                                     "instead of ",
                                     "rose by ",
                                     "on average, ",
                                     " lies (",
                                     ", ",
                                     "at most ",
                                     "1e999",
                                     "-",
                                     "0.5",
                                     "nan",
                                     "inf",
                                     "\xff",
                                     "",
                                     "9"};
  RandomStream random(8, Purpose::kTest);
  for (int n = 0; n < 20'000; ++n) {
    std::string words;
    for (std::uint32_t k = random.below(12); k > 0; --k)
      words += pieces[random.below(std::uint32_t(std::size(pieces)))];
    const auto f = fault_figures(int(random.below(17)), words, {});
    if (f) CHECK((std::isfinite(f->value) && (!f->limit || std::isfinite(*f->limit))));
  }
}
