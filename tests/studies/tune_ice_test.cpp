// Tuning from the log of an ice print: its intervals as layers, the lab that they come from, gains of its
// schemes.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "config/include.h"
#include "core/grid/random.h"
#include "estimators/lab/layer_features.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "studies/tune/advice.h"
#include "studies/tune/ice_layers.h"
#include "studies/tune/next_print.h"
#include "tests/support/ice_print.h"

using namespace firn;
using namespace firn::tune;
using Catch::Contains;

namespace {

constexpr int kIntervals = 6;

Blobs block_inputs() {
  return {{"paths", "", slice::encode(test::ice_block(kIntervals))}, {"machine", "", {}}};
}

Experiment block(const std::string& scheme = "smf") {
  return load_experiment(FIRN_SOURCE_DIR "/labs/ice-cobra600.toml",
                         {"ice.paths=\"-\"", "ice.interval_layers=1", "control.scheme=" + scheme});
}

const LabClass& ice() { return lab_classes(Deposition::kPaths)[0]; }

RecordedRun log_of(const Experiment& e, const LabDraw& lab) {
  const Blobs inputs = block_inputs();
  const LabPrint print = print_in_lab(without_plant(e), inputs, lab, {.features = true});
  CAPTURE(print.reason);
  REQUIRE(print.finished);
  REQUIRE_FALSE(print.features.empty());
  return {"an ice run", e, inputs, print.features, kIntervals};
}

/// A laboratory that is known, so that nothing needs to be learned.
FittedLab known_ice(double flow_z) {
  FittedLab lab;
  lab.lab = &ice();
  lab.posterior = lab::standard_normal(ice().parameters.size());
  lab.posterior.mean[0] = flow_z;
  for (double& v : lab.posterior.covariance) v *= 1e-4;
  return lab;
}

}  // namespace

TEST_CASE("An ice print's intervals are layers: the growth that the map before commanded, and both maps") {
  const Experiment e = block("smf");
  const Blobs inputs = block_inputs();
  IceLayers seen(e, blob(inputs, "paths").bytes);
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    seen.take(channel, bytes);
  };
  REQUIRE_FALSE(runs::can_go_on(print_in_memory(full_product(), e, inputs, options).result));
  const auto layers = seen.printed();
  REQUIRE(layers.size() == std::size_t(kIntervals));
  CHECK(seen.mask().count() > 20);
  CHECK(seen.target().cells[0] == Approx(0.24 * kIntervals));
  CHECK(seen.noise_std_mm() > 0.0);
  bool varied = false;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    if (k > 0) CHECK(layers[k].before.size() == layers[k - 1].after.size());
    for (std::size_t c = 0; c < seen.mask().size(); ++c) {
      if (!seen.mask().cells[c]) continue;
      if (k == 0) CHECK(int(layers[k].fired.cells[c]) == 100);  // no map was answered yet
      varied = varied || layers[k].fired.cells[c] != 100;
    }
  }
  CHECK(varied);
}

TEST_CASE(
    "Gains of an ice print are tuned in its lab, and those of smf_foresee, and what cannot be is refused") {
  const FittedLab lab = known_ice(-0.5);
  for (const char* key : {"control.smf.kp=0.05:1.2", "control.foresee.flow_gain"}) {
    Experiment e =
        block(std::string_view(key).find("foresee") == std::string_view::npos ? "smf" : "smf_foresee");
    e.control.smf.kp = 0.1;
    e.control.smf.ki_star = e.control.smf.kd_star = 0.0;
    e.control.surface.foresee.flow_gain = 0.0;
    const RecordedRun run{"an ice run", e, block_inputs(), {}, kIntervals};
    const std::vector<TuneKey> keys{{key, e}};
    const Advice advice =
        advise(lab, run, keys, {.goal = goal_index(e, "rms"), .seed = 3, .threads = 2, .prints = 30});
    CAPTURE(key, advice.promise.old_mean, advice.promise.new_mean, advice.new_setting[0]);
    CHECK(advice.evaluations >= 2);
    CHECK(advice.promise.gain > -0.05 * advice.promise.old_mean);
  }
  CHECK_THROWS_WITH(TuneKey("control.foresee.flow_gain", block("smf")), Contains("smf_foresee"));
  CHECK_THROWS_WITH(TuneKey(std::string(kSpacing), block()), Contains("plain shape"));
  CHECK_THROWS_WITH(TuneKey("ice.interval_layers", block()), Contains("sliced by [ice] before its print"));
  CHECK_THROWS_WITH(goal_index(block(), "droplets"), Contains("worst_rms_um"));
}

TEST_CASE("An ice log tells its water's flow, passes its check, and names the print that would tell more",
          "[full]") {
  const Experiment e = block("smf");
  std::vector<double> z(ice().parameters.size(), 0.2);
  z[0] = -0.5;
  const std::vector<RecordedRun> runs{log_of(e, {&ice(), z, 9})};
  const FittedLab lab = fit_lab(runs, {.seed = 4, .threads = 2, .prints = 120});
  CAPTURE(lab.posterior.mean[0], lab.posterior.std(0), lab.check.largest, lab.check.limit);
  CHECK(lab.check.passed());
  CHECK(lab.posterior.std(0) < 0.5);
  CHECK(std::abs(lab.posterior.mean[0] - z[0]) < 3.0 * lab.posterior.std(0));
  const auto next = next_prints(lab, runs[0], {.seed = 4, .threads = 2, .draws = 16});
  REQUIRE(next.size() == 3);
  CHECK(next[0].information >= next[2].information);
  std::vector<RecordedRun> mixed = runs;
  mixed.push_back(runs[0]);
  mixed[1].experiment = Experiment{};
  CHECK_THROWS_WITH(fit_lab(mixed, {}), Contains("another kind"));
}
