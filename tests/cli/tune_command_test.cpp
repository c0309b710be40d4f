#include "cli/tune_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "files/usage_error.h"
#include "studies/identify/identification_study.h"

using namespace firn;

namespace {

// A plate printed by full layers on the paper's own plant, whose droplets are worth 7.6 um; `believed` is the
// model's value.
std::vector<double> found(double believed) {
  const auto um = [&](double h) { return std::to_string(h * believed * 1e-3); };
  return disturbance_of(observe_print(
      std::string(FIRN_SOURCE_DIR) + "/experiments/demo.toml",
      {"plant.model=lu2015", "plant.variation=0", "control.scheme=open_loop", "control.open_loop.layers=8",
       "part.shape=cuboid", "part.width_mm=8", "part.depth_mm=8", "estimator.droplets=off",
       "model.h1_mm=" + um(4.4), "model.h2_mm=" + um(0.6), "model.h3_mm=" + um(0.2)}));
}

double mean(const std::vector<double>& d) {
  return std::accumulate(d.begin(), d.end(), 0.0) / double(d.size());
}

}  // namespace

TEST_CASE("A run's disturbance is what its droplets added beyond what the model foretells") {
  const auto right = found(1.0), low = found(0.8);
  REQUIRE(right.size() == 8);
  // The border gives away a few percent; a model 20 % low sees 25 % more than that.
  CHECK(std::abs(mean(right)) < 0.08);
  CHECK(mean(low) > 0.15);
  CHECK(mean(low) == Approx(1.25 * (1.0 + mean(right)) - 1.0).margin(0.01));
}

TEST_CASE("firn tune smf names an algorithm it does not know and a start that is no triple") {
  TuneCommandOptions o;
  o.algorithm = "newton";
  CHECK_THROWS_WITH(run_tune_smf(o), Catch::Contains("newton") && Catch::Contains("slsqp"));
  o.algorithm = "cobyla";
  o.start = {1.0, 0.3};
  CHECK_THROWS_WITH(run_tune_smf(o), Catch::Contains("--start"));
  o.start = {1.0, 0.3, 0.0};
  o.model.intervals = 0;
  CHECK_THROWS_AS(run_tune_smf(o), UsageError);
}
