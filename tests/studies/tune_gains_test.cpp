// firn tune's gains against the exact optimum of one point (docs/algorithms/tuning.md), in a laboratory that
// is built to keep its assumptions: droplets without neighbours, a droplet an eighth of a layer, no
// saturation, a disturbance that is white from layer to layer, and an end at the nominal height.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "estimators/gains/tune_smf.h"
#include "print/labs/full_product.h"
#include "studies/tune/advice.h"
#include "tests/support/tiny_print.h"

using namespace firn;
using namespace firn::tune;

namespace {

constexpr double kDroplet_mm = 0.001, kVariation = 0.9;
constexpr int kDropletsOfALayer = 8, kLayersOfThePart = 9;

constexpr LabParameter kOnePoint[] = {{"plant.variation", "", kVariation, 1e-6, 0.0, 1.0}};

void set_one_point(std::span<const double> v, Experiment& e) {
  e.plant.model = "lu2015";
  e.plant.variation = v[0];
  e.plant.sensor_noise_mm = 0.00005;
  e.plant.dropout_fraction = 0.0;
}

void without_neighbours(std::span<const double> v, plant::WorldConfig& w) {
  w.lu2015.h1_mm = kDroplet_mm / (1.0 + 0.5 * v[0]);
  w.lu2015.h2_mm = w.lu2015.h3_mm = 0.0;
}

constexpr LabClass kOnePointLab{"one point", "cells that do not know each other", kOnePoint, &set_one_point,
                                &without_neighbours};

Experiment one_point_print() {
  Experiment e = test::tiny_print("gains", "smf");
  e.grid.nx = e.grid.ny = 18;
  e.part.shape.width_mm = e.part.shape.depth_mm = 4.3;
  e.laser_profiler.points = 90;
  e.process.scan_speed_mm_s = 50.0;
  e.model.h1_mm = kDroplet_mm;
  e.model.h2_mm = e.model.h3_mm = 0.0;
  e.part.shape.height_mm = kDroplet_mm * kDropletsOfALayer * kLayersOfThePart;
  e.control.smf.layer_height_mm = kDroplet_mm * kDropletsOfALayer;
  e.control.smf.max_drops = 2 * kDropletsOfALayer;
  e.control.smf.kp = 0.4;
  e.control.smf.ki_star = 0.3;
  e.control.smf.kd_star = 0.0;
  e.control.noise_gate = 100.0;
  return e;
}

// Relative sizes of the droplets of a layer, in layers.
std::vector<double> white_disturbance() {
  RandomStream random(8, Purpose::kTest);
  std::vector<double> d(4000);
  for (double& v : d)
    for (int n = 0; n < kDropletsOfALayer; ++n)
      v += kVariation * (random.uniform() - 0.5) / (1.0 + 0.5 * kVariation) / kDropletsOfALayer;
  return d;
}

}  // namespace

TEST_CASE("Tuned gains agree with the exact optimum of one point where its assumptions hold") {
  const Experiment e = one_point_print();
  const Blobs inputs = make_inputs(full_product(), e, ".");
  const RecordedRun run{"one point", e, inputs, {}, 0};
  FittedLab lab;
  lab.lab = &kOnePointLab;
  lab.posterior = {{0.0}, {1e-6}};
  const std::vector<TuneKey> keys{{"control.smf.kp=0.2:1.8", e}, {"control.smf.ki_star=0.001:1", e}};
  const Advice advice = advise(lab, run, keys, {.seed = 4, .threads = 2, .prints = 350});
  const std::vector<double> d = white_disturbance();
  const gains::TunedGains exact = gains::tune_smf(d, {});
  const gains::Gains tuned{advice.new_setting[0], advice.new_setting[1], 0.0};
  const gains::Gains before{e.control.smf.kp, e.control.smf.ki_star, 0.0};
  CAPTURE(exact.gains.kp, exact.gains.ki_star, exact.gains.kd_star, tuned.kp, tuned.ki_star);
  using control::smf_line::spread;
  // Six prints of 256 cells tell RMS errors apart that differ by some per cent.
  CHECK(spread(before, d).rms > 1.25 * exact.rms);
  CHECK(spread(tuned, d).rms < 1.05 * exact.rms);
  CHECK(advice.gain_shown);
  // The gain that whole prints promise is the one of the exact spread.
  const double promised = advice.promise.new_mean / advice.promise.old_mean;
  CHECK(promised == Approx(spread(tuned, d).rms / spread(before, d).rms).epsilon(0.05));
}
