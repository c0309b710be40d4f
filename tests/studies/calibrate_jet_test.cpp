// firn calibrate jet through its whole path: nodes, drivers, twins, rendered strobe pictures, fit. Planted
// jets must come out within the tolerances; sweeps that cannot tell are refused by name.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "estimators/calibration/jet_waveform.h"
#include "files/usage_error.h"
#include "studies/calibrate/lab_calibrations.h"
#include "tests/support/long_cases.h"
#include "tests/support/watched_jet.h"

namespace firn {
namespace {

using calibration::JetSpeed;
using calibration::Unidentifiable;
using Catch::Contains;

/// A lab with small pictures whose jet resonates at best_us.
Experiment resonant_lab(double best_us, double threshold_v, std::uint64_t seed) {
  Experiment e;
  test::watch_jet(e);
  e.plant.seed = seed;
  e.plant.camera.best_dwell_us = best_us;
  e.plant.camera.threshold_v = threshold_v;
  return e;
}

// The slopes are 3 us each, so the pulse that the resonance sees is so much longer than the dwell time.
double true_dwell_us(const Experiment& e) {
  return e.plant.camera.best_dwell_us - 0.5 * (e.jet.rise_us + e.jet.fall_us);
}

double true_volts(const Experiment& e, double wanted_m_s) {
  const PlantCameraConfig& c = e.plant.camera;
  return c.threshold_v + wanted_m_s / c.drop_speed_m_s * (20.0 - c.threshold_v);
}

std::vector<JetSpeed> planted_speeds(double best_us, double noise_m_s, std::uint64_t seed) {
  RandomStream random(seed, Purpose::kTest);
  std::vector<JetSpeed> speeds;
  for (int k = 0; k < 9; ++k) {
    const double d = best_us * (0.75 + 0.06 * k);
    speeds.push_back(
        {d, 20.0, 3.0 * std::cos(1.5708 * (d - best_us) / best_us) + noise_m_s * random.normal(), noise_m_s});
  }
  return speeds;
}

}  // namespace

TEST_CASE("the best dwell time of planted resonances lies within its interval") {
  int inside = 0;
  constexpr int kCases = 200;
  for (int n = 0; n < kCases; ++n) {
    RandomStream random(std::uint64_t(n), Purpose::kTest, 7);
    const double best = random.uniform(12.0, 45.0);
    const auto fit = calibration::fit_best_dwell(planted_speeds(best, 0.01, 100 + std::uint64_t(n)));
    inside += std::abs(fit.dwell_us.value - best) <= fit.dwell_us.ci95_half_width;
  }
  CHECK(inside >= 180);
  CHECK(inside <= 198);
}

TEST_CASE(
    "a velocity of few droplets that happens to be the largest does not draw the best dwell time to it") {
  std::vector<JetSpeed> speeds = planted_speeds(20.0, 0.001, 3);
  speeds.push_back({40.0, 20.0, 9.0, 4.0});
  CHECK(calibration::fastest(speeds).dwell_us < 25.0);
  CHECK(calibration::fit_best_dwell(speeds).dwell_us.value == Approx(20.0).margin(0.2));
}

TEST_CASE("the voltage of a wanted velocity follows from a line above its threshold") {
  std::vector<JetSpeed> speeds;
  for (const double v : {12.0, 16.0, 20.0, 24.0}) speeds.push_back({20.0, v, 0.25 * (v - 9.0), 0.01});
  const auto line = calibration::fit_voltage(speeds, 3.0);
  CHECK(line.threshold_v.value == Approx(9.0).margin(1e-6));
  CHECK(line.volts.value == Approx(21.0).margin(1e-6));
}

TEST_CASE("a velocity that no dwell time changes has no best one") {
  std::vector<JetSpeed> speeds;
  for (int k = 0; k < 9; ++k) speeds.push_back({10.0 + 3.0 * k, 20.0, 2.0 + 0.002 * (k % 2), 0.01});
  CHECK_THROWS_AS(calibration::fit_best_dwell(speeds), Unidentifiable);
}

TEST_CASE("calibrate jet finds the dwell time of planted resonances and the voltage of 2.5 m/s") {
  for (const std::size_t n : test::long_cases(20, 1)) {
    RandomStream random(n, Purpose::kTest, 8);
    const Experiment e = resonant_lab(random.uniform(17.0, 34.0), random.uniform(4.0, 10.0), n + 1);
    LabCalibrationOptions o;
    o.velocity_m_s = 2.5;
    const LabCalibration found = calibrate_jet(e, o);
    INFO("case " << n << ", best " << true_dwell_us(e));
    CHECK(std::abs(found.keys.at(0).value[0] - true_dwell_us(e)) <= 1.0);
    CHECK(std::abs(found.keys.at(1).value[0] - true_volts(e, 2.5)) <= 1.0);
    CHECK(found.keys.at(2).value[0] == Approx(2.0 * found.keys.at(0).value[0]).margin(0.06));
    CHECK(found.keys.at(3).value[0] == -found.keys.at(1).value[0]);
  }
}

TEST_CASE("calibrate jet refuses a range of dwell times without a maximum in it") {
  LabCalibrationOptions o;
  o.dwells_us = {8, 10, 12, 14};
  CHECK_THROWS_WITH(calibrate_jet(resonant_lab(30.0, 6.0, 1), o), Contains("14 us, an end of the range"));
}

TEST_CASE("calibrate jet refuses a jet that gives no droplet") {
  Experiment e = resonant_lab(24.0, 19.0, 1);
  LabCalibrationOptions o;
  o.dwells_us = {8, 10, 12};
  CHECK_THROWS_WITH(calibrate_jet(e, o), Contains("no droplet was measured"));
}

TEST_CASE("calibrate jet refuses pictures without a scale") {
  Experiment e = resonant_lab(24.0, 8.0, 1);
  e.watch.um_per_px = 0.0;
  CHECK_THROWS_WITH(calibrate_jet(e, {}), Contains("watch.um_per_px"));
}

TEST_CASE("calibrate jet names the voltage that a velocity beyond the sweep needs") {
  LabCalibrationOptions o;
  o.velocity_m_s = 12.0;
  CHECK_THROWS_WITH(calibrate_jet(resonant_lab(24.0, 8.0, 1), o), Contains("12 m/s need about 8"));
}

TEST_CASE("calibrate jet refuses dwell times and voltages that cannot be tried, before the lab moves") {
  const auto refused = [](std::vector<double> dwells_us, std::vector<double> voltages_v, const char* why) {
    Experiment e = resonant_lab(24.0, 8.0, 1);
    e.jet.dialect.max_abs_v = 60;
    LabCalibrationOptions o;
    o.dwells_us = std::move(dwells_us);
    o.voltages_v = std::move(voltages_v);
    CAPTURE(why);
    CHECK_THROWS_WITH(calibrate_jet(e, o), Contains(why));
    CHECK_THROWS_AS(calibrate_jet(e, o), UsageError);
  };
  refused({20}, {}, "--dwells: 1 different dwell times, 3 at least are needed");
  refused({20, 20, 24, 24}, {}, "--dwells: 2 different dwell times, 3 at least are needed");
  refused({1, 2, 3000}, {}, "--dwells 3000: echo time 6000 us is outside [0, 3276.7] us");
  refused({16.03, 20, 24}, {}, "--dwells 16.03: the jet takes multiples of 0.1 us");
  refused({}, {20}, "--voltages: 1 different voltages, 4 at least are needed");
  refused({}, {20, 30, 40, 61}, "--voltages 61: dwell voltage 61 V is beyond +-60 V");
  refused({}, {0, 20, 30, 40}, "--voltages 0: a pulse of 0 V drives no droplet");
  refused({}, {20.4, 21, 30, 40}, "--voltages 20.4: the jet takes whole volts");
}

}  // namespace firn
