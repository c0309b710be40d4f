// Tuning from logs: keys and their ranges, the promise's variance components, a whole answer on a small part.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/include.h"
#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "estimators/lab/layer_features.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/import/imported_run.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "studies/tune/print_journal.h"
#include "studies/tune/tune_answer.h"
#include "studies/tune/verify_promise.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

using namespace firn;
using namespace firn::tune;
using Catch::Contains;

namespace {

Experiment small_print() {
  Experiment e = test::tiny_print("tuned", "smf");
  e.grid.nx = 14;
  e.grid.ny = 12;
  e.part.shape.width_mm = 2.6;
  e.part.shape.depth_mm = 2.1;
  e.part.shape.height_mm = 0.055;
  return e;
}

/// With fewer points a profile, and fewer profiles.
Experiment quick(Experiment e) {
  e.laser_profiler.points = 64;
  e.process.scan_speed_mm_s = 15.0;
  return e;
}

RecordedRun recorded_print(const Experiment& e, const LabDraw& lab) {
  const Blobs inputs = make_inputs(full_product(), e, ".");
  const LabPrint print = print_in_lab(without_plant(e), inputs, lab, {.features = true});
  REQUIRE(print.finished);
  REQUIRE_FALSE(print.features.empty());
  return {"a run", e, inputs, print.features, 0};
}

const LabClass& droplets() { return lab_classes()[0]; }

LabDraw usual_lab(std::uint64_t seed) {
  return {&droplets(), std::vector<double>(droplets().parameters.size(), 0.3), seed};
}

/// A laboratory of the usual parameters that is known, so that nothing needs to be learned.
FittedLab known_lab() {
  FittedLab lab;
  lab.lab = &droplets();
  lab.posterior = lab::standard_normal(droplets().parameters.size());
  for (double& v : lab.posterior.mean) v = 0.3;
  for (double& v : lab.posterior.covariance) v *= 1e-4;
  return lab;
}

}  // namespace

TEST_CASE(
    "A setting is left out that saturates, swings or spills more than a quarter above the recorded one") {
  const PrintTraits recorded{0.2, -0.1, 0.1, 0.08};
  CHECK(unsafe_trait(recorded, recorded).empty());
  CHECK(unsafe_trait({0.29, -0.1, 0.1, 0.08}, recorded).empty());
  CHECK_THAT(unsafe_trait({0.31, -0.1, 0.1, 0.08}, recorded), Contains("saturates: 31 %"));
  CHECK_THAT(unsafe_trait({0.2, -0.6, 0.16, 0.08}, recorded), Contains("oscillates"));
  CHECK(unsafe_trait({0.2, -0.4, 0.16, 0.08}, recorded).empty());
  CHECK_THAT(unsafe_trait({0.2, -0.1, 0.1, 0.12}, recorded), Contains("deposits outside"));
}

TEST_CASE("A key to tune that another lab has is refused by that name") {
  const Experiment e = test::tiny_print("x", "smf");
  CHECK_THROWS_WITH(TuneKey("control.smf.version", e),
                    Catch::Contains("'control.smf.version' is a key of another lab; the run's is inkjet"));
}

TEST_CASE("A key to tune has its range from the table of options, or a narrower one that is given") {
  const Experiment e = test::tiny_print("x", "smf");
  const TuneKey kp("control.smf.kp", e);
  CHECK(kp.recorded() == e.control.smf.kp);
  CHECK(kp.at(0.5) == Approx(e.control.smf.kp));
  CHECK(kp.at(0.0) > 0.0);  // 0 is outside (0, 10]
  CHECK(kp.at(1.0) == Approx(10.0));
  for (const double u : {0.1, 0.37, 0.9}) CHECK(kp.place(kp.at(u)) == Approx(u));
  const TuneKey narrow("control.smf.kp=0.5:2", e);
  CHECK(narrow.at(0.0) == Approx(0.5));
  CHECK(narrow.at(1.0) == Approx(2.0));
  const TuneKey drops("control.smf.max_drops=1:4", e);
  CHECK(std::vector<double>(drops.values().begin(), drops.values().end()) == std::vector<double>{1, 2, 3, 4});
  const TuneKey words("control.smf.rounding", e);
  CHECK(words.values().size() == 3);
  CHECK(words.text(words.recorded()) == "diffusion");
}

TEST_CASE("A value at an end of the searched range is one where the key's own limits allow more") {
  const Experiment e = test::tiny_print("x", "smf");
  const TuneKey kp("control.smf.kp", e), narrow("control.smf.kp=0.5:2", e);
  CHECK(narrow.at_open_end(0.5));
  CHECK(narrow.at_open_end(1.99));
  CHECK_FALSE(narrow.at_open_end(1.2));
  CHECK_FALSE(kp.at_open_end(10.0));
  CHECK(TuneKey("control.smf.max_drops=1:4", e).at_open_end(4.0));
  CHECK_FALSE(TuneKey("control.smf.rounding", e).at_open_end(2.0));
  CHECK(TuneKey(std::string(kSpacing), e).at_open_end(1.3 * e.grid.pitch_x_mm));
}

TEST_CASE("A setting that breaks a rule between keys is left out with that rule alone") {
  const Experiment e = quick(small_print());
  const std::vector<TuneKey> keys{{"process.sub_patterns=2:4", e}};
  const RecordedRun run{"a run", e, make_inputs(full_product(), e, "."), {}, 0};
  const Advice advice = advise(known_lab(), run, keys, {.seed = 2, .threads = 2, .prints = 40});
  const auto three = std::ranges::find(advice.rejected, "process.sub_patterns = 3", &Rejected::setting);
  REQUIRE(three != advice.rejected.end());
  CHECK(three->reason == "a layer has 1, 2 or 4 sub-patterns");
}

TEST_CASE(
    "A key whose limits only keep nonsense out is searched about its recorded value, or asks for a range") {
  Experiment e = test::tiny_print("x", "open_loop");
  CHECK_THROWS_WITH(TuneKey("control.open_loop.layers", e), Contains("control.open_loop.layers=LOW:HIGH"));
  e.control.open_loop.layers = 40;
  const TuneKey layers("control.open_loop.layers", e);
  CHECK(layers.at(0.0) == 10.0);
  CHECK(layers.at(0.5) == 40.0);
  CHECK(layers.at(1.0) == 160.0);
}

TEST_CASE("From one log under SMF other schemes are tuned too: a planted bad value of each key is found") {
  const Experiment log = small_print();
  const FittedLab lab = known_lab();
  struct Planted {
    const char* what;
    std::vector<std::string> set;
    std::string key;
    double low, high;  ///< the advised value lies between
  };
  const std::vector<Planted> all{
      {"layers of the open loop",
       {"control.scheme=open_loop", "control.open_loop.layers=4"},
       "control.open_loop.layers",
       5.5,
       9.5},
      {"noise gate of MPC",
       {"control.scheme=mpc", "control.noise_gate=12"},
       "control.noise_gate=0.1:20",
       0.0,
       8.0},
      {"target of MPC",
       {"control.scheme=mpc", "control.target_offset_mm=0.012"},
       "control.target_offset_mm=-0.01:0.02",
       -0.006,
       0.006},
  };
  for (const Planted& p : all) {
    const Experiment e = parse_experiment({{"log", dump(log)}}, p.set);
    const RecordedRun start{"a run", e, make_inputs(full_product(), e, "."), {}, 0};
    const std::vector<TuneKey> keys{{p.key, e}};
    const Advice advice = advise(lab, start, keys, {.seed = 2, .threads = 2, .prints = 100});
    std::string left_out;
    for (const Rejected& r : advice.rejected) left_out += r.setting + ": " + r.reason + "\n";
    CAPTURE(p.what, left_out, advice.old_setting[0], advice.new_setting[0], advice.promise.old_mean,
            advice.promise.new_mean);
    CHECK(advice.gain_shown);
    CHECK(advice.new_setting[0] >= p.low);
    CHECK(advice.new_setting[0] <= p.high);
  }
}

TEST_CASE("The spacing of droplets is a key: the field keeps its size, the model its volume") {
  const Experiment e = small_print();
  const std::vector<TuneKey> keys{{std::string(kSpacing), e}};
  const Experiment wide = with_setting(keys, {0.3}, e);
  CHECK(wide.grid.pitch_x_mm == 0.3);
  CHECK(wide.grid.nx * wide.grid.pitch_x_mm >= e.grid.nx * e.grid.pitch_x_mm);
  CHECK(wide.model.h1_mm * 0.3 * 0.3 == Approx(e.model.h1_mm * e.grid.pitch_x_mm * e.grid.pitch_x_mm));
  CHECK(with_setting(keys, {e.grid.pitch_x_mm}, e).grid == e.grid);
  Experiment mesh = e;
  mesh.part.mesh = "part.stl";
  CHECK_THROWS_WITH(TuneKey(std::string(kSpacing), mesh), Contains("plain shape"));
  CHECK_THROWS_WITH(TuneKey("grid.pitch_mm=0.1:0.3", e), Contains("within a half and twice"));

  const RecordedRun run{"a run", e, make_inputs(full_product(), e, "."), {}, 0};
  const FittedLab lab = known_lab();
  const Advice advice = advise(lab, run, keys, {.seed = 2, .threads = 2, .prints = 60});
  CHECK(advice.evaluations >= 2);
  CHECK(advice.promise.old_mean > 0.0);
  FittedLab other = lab;
  other.lab = &lab_classes()[1];
  CHECK_THROWS_WITH(advise(other, run, keys, {}), Contains("at their spacing alone"));
}

TEST_CASE("Keys of MPC, of its horizon and of the estimator that it learns from have an answer") {
  const Experiment e = parse_experiment(
      {{"log", dump(quick(test::tiny_print("tuned", "mpc")))}},
      {"control.scheme=mpc", "estimator.droplets=on", "control.adapt_model=on", "control.mpc.alpha=0.5"});
  const RecordedRun start{"a run", e, make_inputs(full_product(), e, "."), {}, 0};
  const FittedLab lab = known_lab();
  for (const char* key :
       {"control.mpc.alpha=0.05:1", "control.mpc.horizon=1:2", "estimator.memory_layers=3:30"}) {
    const std::vector<TuneKey> keys{{key, e}};
    const Advice advice = advise(lab, start, keys, {.seed = 2, .threads = 2, .prints = 40});
    CAPTURE(key, advice.promise.gain);
    CHECK(advice.evaluations >= 2);
    CHECK(advice.promise.old_mean > 0.0);
    CHECK(advice.promise.gain_interval.low <= advice.promise.gain_interval.high);
  }
}

TEST_CASE("Keys that cannot be tuned are refused by name, with the nearest known key or the limit") {
  const Experiment e = test::tiny_print("x", "smf");
  const auto refused = [&](const std::string& text) -> std::string {
    try {
      const TuneKey key(text, e);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  CHECK_THAT(refused("control.smf.ki"), Contains("control.smf.ki_star"));
  CHECK_THAT(refused("plant.flow"), Contains("plant.flow") && Contains("are tuned"));
  CHECK_THAT(refused("control.mpc.alpha"), Contains("scheme"));
  CHECK_THAT(refused("control.smf.kp=0.5"), Contains("LOW:HIGH"));
  CHECK_THAT(refused("control.smf.kp=2:1"), Contains("ascending"));
  CHECK_THAT(refused("control.smf.kp=0.5:20"), Contains("(0, 10]"));
  CHECK_THAT(refused("control.smf.kp=a:2"), Contains("'a' is not a number"));
}

TEST_CASE("A laboratory's parameter is a multiple of its centre, or lies on either side of it") {
  const LabParameter flow{"flow", "", 2.0, 0.5, 1.0, 3.0};
  CHECK(flow.value(0.0) == 2.0);
  CHECK(flow.value(0.4) == Approx(2.0 * std::exp(0.2)));
  CHECK(flow.value(-9.0) == 1.0);
  const LabParameter lead{"lead", "s", 0.0, 0.2, -0.5, 0.5, true};
  CHECK(lead.value(-1.0) == -0.2);
  CHECK(lead.value(9.0) == 0.5);
}

TEST_CASE("A setting is written into the experiment and read back, and nothing else changes") {
  const Experiment e = test::tiny_print("x", "smf");
  const std::vector<TuneKey> keys{{"control.smf.kp", e}, {"control.smf.rounding", e}};
  const Experiment with = with_setting(keys, {0.7, 2.0}, e);
  CHECK(with.control.smf.kp == 0.7);
  CHECK(with.control.smf.rounding == control::Rounding::kCarry);
  CHECK(differences(e, with).size() == 2);
  CHECK(text_of(keys, {0.7, 2.0}) == "control.smf.kp = 0.7, control.smf.rounding = carry");
}

TEST_CASE("A promise for the mean of many prints covers the laboratory's own gain as often as it says") {
  RandomStream random(11, Purpose::kTest);
  int covered = 0, sure = 0;
  const int trials = 1000, draws = 30, prints = 10;
  const double lab_std = 0.1, print_std = 0.2;
  for (int t = 0; t < trials; ++t) {
    std::vector<double> before, after;
    for (int d = 0; d < draws; ++d) {
      const double gain = 0.15 + lab_std * random.normal();
      for (int s = 0; s < 2; ++s) {
        const double common = random.normal();
        before.push_back(2.0 + common + gain + print_std * random.normal());
        after.push_back(2.0 + common);
      }
    }
    const Promise p = promise_of(before, after, 2, prints);
    double printed = 0.15 + lab_std * random.normal();
    for (int n = 0; n < prints; ++n) printed += print_std * random.normal() / prints;
    covered += printed >= p.gain_interval.low && printed <= p.gain_interval.high;
    sure += p.sure > 0.5;
  }
  CHECK(double(covered) / trials > 0.93);
  CHECK(double(covered) / trials < 0.98);
  CHECK(sure > trials * 9 / 10);
}

TEST_CASE(
    "A promise covers gains that scale with the laboratory, though few draws hold the largest of them") {
  RandomStream random(12, Purpose::kTest);
  int above = 0, below = 0;
  const int trials = 800, draws = 12, prints = 10;
  const auto lab = [&] { return std::pair(0.6 * random.normal(), 0.3 + 0.3 * random.normal()); };
  for (int t = 0; t < trials; ++t) {
    std::vector<double> before, after;
    for (int d = 0; d < draws; ++d) {
      const auto [size, gain] = lab();
      for (int s = 0; s < 2; ++s) {
        after.push_back(std::exp(size + 0.1 * random.normal()));
        before.push_back(after.back() * std::exp(gain + 0.05 * random.normal()));
      }
    }
    const Promise p = promise_of(before, after, 2, prints);
    const auto [size, gain] = lab();
    double printed = 0.0;
    for (int n = 0; n < prints; ++n) {
      const double one = std::exp(size + 0.1 * random.normal());
      printed += one * (std::exp(gain + 0.05 * random.normal()) - 1.0) / prints;
    }
    above += printed > p.gain_interval.high;
    below += printed < p.gain_interval.low;
  }
  CHECK(above < trials * 4 / 100);
  CHECK(below < trials * 4 / 100);
  CHECK(above + below > trials * 2 / 100);
}

TEST_CASE("A laboratory is never known by the plant section of its recorded experiment") {
  Experiment e = small_print();
  e.plant.flow = 0.6;
  e.plant.drift = 0.3;
  e.plant.seed = 99;
  e.devices.jet = "/dev/ttyUSB0";
  CHECK(differences(without_plant(e), without_plant(small_print())).empty());
}

TEST_CASE(
    "The same log gives the same answer with one thread and with three, and a search that goes on from its "
    "file of prints makes none again") {
  const Experiment e = quick(small_print());
  const std::vector<RecordedRun> runs{recorded_print(e, usual_lab(5))};
  const std::vector<TuneKey> keys{{"control.smf.ki_star=0.01:1", e}};
  const test::TempFolder folder;
  const std::filesystem::path file = folder.path() / "state";
  const auto answer = [&](int threads, PrintJournal* journal) {
    const FittedLab lab = fit_lab(runs, {.seed = 2, .threads = threads, .prints = 170, .journal = journal});
    const Advice advice =
        advise(lab, runs[0], keys, {.seed = 2, .threads = threads, .prints = 60, .journal = journal});
    CHECK(advice.promise.gain_interval.low <= advice.promise.gain);
    CHECK(advice.promise.gain <= advice.promise.gain_interval.high);
    CHECK(advice.profiles.size() == 1);
    const auto next =
        next_prints(lab, runs[0], {.seed = 2, .threads = threads, .draws = 18, .journal = journal});
    CHECK(next.size() == 3);
    const TuneAnswer answer{runs, keys, "rms_um", lab, advice, next, {}, 10, 2};
    return tune_text(answer) + tune_json(answer) + tune_page(answer);
  };
  const std::string plain = answer(1, nullptr);
  CHECK_THAT(plain, Contains("RMS") && Contains("laboratory: ") && Contains("</html>"));
  {
    PrintJournal journal(file);
    CHECK(answer(3, &journal) == plain);
    CHECK_THROWS_WITH(PrintJournal(file), Contains("state: another firn tune"));
  }
  // Killed while it wrote the last of its lines.
  const auto lines = [&] { return std::ranges::count(read_file(file), '\n'); };
  const auto whole = lines();
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 40);
  PrintJournal journal(file);
  CHECK(journal.known() > 150);
  CHECK(journal.damaged() == 1);
  CHECK(answer(3, &journal) == plain);
  CHECK(lines() == whole + 1);  // the torn line, and its print once more
}

TEST_CASE("An imported record of a print is taken as printed by the scheme of its experiment") {
  Experiment e = quick(small_print());
  e.plant.seed = 12;
  const Blobs inputs = make_inputs(full_product(), e, ".");
  ObservedRun observed(e, mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask"));
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    observed.take(channel, bytes);
  };
  print_in_memory(full_product(), e, inputs, options);
  LayerRecord record;
  record.grid = e.grid;
  for (const droplet::PrintedLayer& l : observed.printed()) {
    if (record.heights.empty()) record.heights.push_back(l.before);
    record.heights.push_back(l.after);
    Grid<double> input(e.grid);
    for (std::size_t c = 0; c < input.size(); ++c) input.cells[c] = l.fired.cells[c];
    record.inputs.push_back(std::move(input));
  }
  record.points = std::int64_t(record.heights.size() * e.grid.size());
  const test::TempFolder folder;
  const ImportedRun imported =
      write_imported_run(record, e, {"record.csv", "", 0.0, e.part.shape.height_mm}, folder.path());
  const std::vector<RecordedRun> runs{RecordedRun::read(imported.folder)};
  CHECK(runs[0].noise == MapNoise::kFromMaps);
  CHECK(runs[0].layers == observed.layers());
  const FittedLab lab = fit_lab(runs, {.seed = 3, .threads = 2, .prints = 170});
  CHECK(lab.check.passed());
  const std::vector<TuneKey> keys{{"control.smf.kp", e}};
  CHECK_THROWS_WITH(PromisePairs(runs[0], keys, {}), Contains("imported"));

  // The same record as if gains that hardly answer had printed it.
  Experiment other = e;
  other.control.smf.kp = 0.05;
  other.control.smf.ki_star = 0.0;
  const ImportedRun wrong =
      write_imported_run(record, other, {"record.csv", "", 0.0, e.part.shape.height_mm}, folder.path());
  const std::vector<RecordedRun> wrong_runs{RecordedRun::read(wrong.folder)};
  CHECK_FALSE(fit_lab(wrong_runs, {.seed = 3, .threads = 2, .prints = 170}).check.passed());
}

TEST_CASE("A laboratory that only far parameters would reproduce is refused with the farthest one's name") {
  LabDraw far = usual_lab(6);
  far.z = std::vector<double>(far.z.size(), 0.0);
  far.z[0] = 3.4;  // flow
  far.z[1] = 3.0;
  far.z[6] = 3.4;
  far.z[8] = -3.4;
  const Experiment e = quick(small_print());
  const std::vector<RecordedRun> runs{recorded_print(e, far)};
  const FittedLab lab = fit_lab(runs, {.seed = 3, .threads = 2, .prints = 168});
  REQUIRE_FALSE(lab.check.passed());
  CAPTURE(lab.posterior.mean, lab.check.missed.front().feature);
  CHECK(std::ranges::any_of(lab.check.missed, [](const FitCheck::Missed& m) {
    return m.feature.starts_with("parameters of usual laboratories (most ");
  }));
}

TEST_CASE("A log whose surface is tilted as no laboratory tilts it is refused by the feature's name") {
  const Experiment e = quick(small_print());
  std::vector<RecordedRun> runs{recorded_print(e, usual_lab(6))};
  for (std::size_t f = 0; f < lab::feature_count(); ++f)
    if (lab::feature_name(f).starts_with("tilt of the surface along y")) runs[0].features[f] += 8.0;
  const FittedLab lab = fit_lab(runs, {.seed = 3, .threads = 2, .prints = 180});
  CHECK_FALSE(lab.check.passed());
  TuneAnswer answer{runs, {}, "rms_um", lab, {}, {}, {}, 10, 3};
  CHECK_THAT(tune_line(answer), Contains("no advice") && Contains("tilt of the surface along y"));
}

TEST_CASE("A verification says whether its gain lies within, above or below the promised interval") {
  FittedLab lab;
  lab.lab = &lab_classes().front();
  lab.posterior.mean.assign(lab.lab->parameters.size(), 0.0);
  Advice advice;
  advice.promise.gain_interval = {0.2, 0.6};
  Verification verification;
  verification.pairs.pairs = 20;
  TuneAnswer answer{{}, {}, "rms_um", lab, advice, {}, verification, 20, 1};
  const auto said = [&](double gain, int stopped_new) {
    answer.verification->pairs.difference = gain;
    answer.verification->held = gain >= 0.2 && gain <= 0.6 && stopped_new == 0;
    answer.verification->stopped_new = stopped_new;
    return tune_text(answer);
  };
  CHECK_THAT(said(0.4, 0), Contains("the promise held\n"));
  CHECK_THAT(said(0.7, 0), Contains("the promise did not hold: more was gained\n"));
  CHECK_THAT(said(0.1, 0), Contains("the promise DID NOT HOLD\n"));
  CHECK_THAT(said(0.7, 1), Contains("the promise DID NOT HOLD\n"));
}
