#include <catch2/catch.hpp>

#include <cmath>
#include <optional>
#include <set>

#include "tests/procs/fake_lab.h"

namespace firn {
namespace {

using test::FakeLab;
using test::small;

TEST_CASE(
    "an undisturbed print fires every planned droplet exactly once, in as many passes as a cell has drops") {
  FakeLab lab(7);
  REQUIRE(lab.print(0.0) == 0);
  for (int layer = 1; layer <= lab.layers; ++layer)
    for (std::size_t c = 0; c < lab.planned[layer].size(); ++c)
      for (int pass = 0; pass < 3; ++pass)
        REQUIRE(lab.fired[{layer, pass}][std::uint32_t(c)] == (lab.planned[layer].cells[c] > pass ? 1 : 0));
}

TEST_CASE("however often a print crashes and resumes, no droplet is fired twice and no layer is skipped") {
  int crashes = 0, doubts = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    CAPTURE(seed);
    FakeLab lab(seed);
    crashes += lab.print(0.12);
    for (const auto& [where, cells] : lab.fired)
      for (const auto& [cell, times] : cells) {
        CAPTURE(where.first, where.second, cell);
        REQUIRE(times <= 1);
        REQUIRE(lab.planned[where.first].cells[cell] > where.second);
      }
    std::set<int> reported, doubtful;
    for (const auto& r : lab.all(channels::kDepositionReport)) {
      reported.insert(r.layer);
      if (r.unknown_to > r.unknown_from) doubtful.insert(r.layer);
    }
    for (int layer = 1; layer <= lab.layers; ++layer) {
      CAPTURE(layer);
      REQUIRE(reported.count(layer) == 1);
      if (doubtful.count(layer)) continue;  // the rest of a doubtful layer is left to the next plan
      for (std::size_t c = 0; c < lab.planned[layer].size(); ++c)
        for (int pass = 0; pass < 3; ++pass)
          REQUIRE(lab.fired[{layer, pass}][std::uint32_t(c)] == (lab.planned[layer].cells[c] > pass ? 1 : 0));
    }
    doubts += int(doubtful.size());
  }
  REQUIRE(crashes > 300);
  REQUIRE(doubts > 30);
}

TEST_CASE("a doubtful pass is followed by a scan before the next plan is carried out") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    FakeLab lab(seed);
    lab.print(0.2);
    bool doubt = false;
    for (const auto& s : lab.sent) {
      if (s.channel == "DEPOSITION_REPORT") {
        const auto r = test::NodeBench::decode<deposition_report_t>(s);
        doubt = doubt || r.unknown_to > r.unknown_from;
      }
      if (s.channel == "LAYER_METRICS") doubt = false;  // a scan has been made and accepted
      if (s.channel == "STAGE_COMMAND" &&
          StageVerb(test::NodeBench::decode<stage_command_t>(s).verb) == StageVerb::kPass) {
        CAPTURE(seed);
        REQUIRE_FALSE(doubt);
      }
    }
  }
}

TEST_CASE(
    "the open loop stops for the operator when droplets are in doubt, and goes on when they are accepted") {
  Experiment e = small();
  e.control.scheme = "open_loop";
  FakeLab lab(3, e);
  lab.begin(0);
  answer_t doubt{};
  while (lab.serve(0.0)) {
    if (lab.all(channels::kStageCommand).empty()) continue;
    const auto c = lab.last(channels::kStageCommand);
    if (StageVerb(c.verb) != StageVerb::kPass) continue;
    doubt.node = "stage";
    doubt.command_id = c.command_id;
    doubt.outcome = std::int8_t(Outcome::kUnknown);
    doubt.unknown_from = 2;
    doubt.unknown_to = 5;
    lab.crash();
    lab.begin(1);
    lab.seen = lab.sent.size();
    lab.give(channels::answer(NodeId::kStage), doubt);
    break;
  }
  while (lab.serve(0.0)) {
  }
  REQUIRE(lab.wake());
  REQUIRE(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kWaitsForOperator);
  REQUIRE(lab.last(channels::kRunEnd).reason.find("--accept-doubt") != std::string::npos);

  const std::size_t passes = lab.all(channels::kDepositionReport).size();
  lab.seen = lab.sent.size();
  lab.begin(2);
  operator_command_t accept{};
  accept.verb = std::int8_t(OperatorVerb::kAcceptDoubt);
  lab.give(channels::kOperatorCommand, accept);
  while (lab.serve(0.0)) {
  }
  REQUIRE(lab.all(channels::kDepositionReport).size() > passes);
  REQUIRE(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("a map that measures too little is taken again, then stops the print by name", "[I13]") {
  Experiment e = small();
  e.process.max_rescans = 2;
  FakeLab lab(5, e);
  lab.begin(0);
  int maps = 0;
  while (lab.seen < lab.sent.size()) {
    const auto s = lab.sent[lab.seen];
    if (s.channel == "PROFILER_COMMAND" &&
        ProfilerVerb(test::NodeBench::decode<profiler_command_t>(s).verb) == ProfilerVerb::kEnd) {
      ++lab.seen;
      const auto c = test::NodeBench::decode<profiler_command_t>(s);
      lab.plain(NodeId::kLaserProfiler, c, 0.0);
      height_map_t m{};
      m.layer = c.layer;
      m.attempt = c.attempt;
      m.map_id = ++lab.map_id;
      m.measured_fraction = 0.79;
      set_height(m, HeightMap(e.grid, 0.0));
      m.quality.assign(m.height_mm.size(), 0);
      lab.give(channels::kHeightMap, m);
      ++maps;
    } else if (!lab.serve(0.0)) {
      break;
    }
  }
  REQUIRE(maps == 3);
  const fault_t f = lab.last(channels::fault(NodeId::kScheduler));
  REQUIRE(f.code == 13);
  REQUIRE(Severity(f.severity) == Severity::kStop);

  // A resume measures again, and does not wait for the map that was refused.
  lab.seen = lab.sent.size();
  lab.begin(1);
  while (lab.serve(0.0)) {
  }
  REQUIRE(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("a SAFE_STOP of an older incarnation, delivered only after the resume, stops nothing") {
  FakeLab lab(5);
  lab.begin(0);
  lab.begin(1);
  safe_stop_t stop{};
  stop.enable_epoch = lab.epoch;
  stop.cause = "test";
  lab.give_of(0, channels::kSafeStop, stop);
  CHECK(lab.all(channels::kRunEnd).empty());
  lab.give_of(1, channels::kSafeStop, stop);
  REQUIRE(lab.all(channels::kRunEnd).size() == 1);
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kStoppedSafely);
}

namespace {

// A lab whose maps lack rows: how many, by the attempt at the layer.
struct LossyLab : FakeLab {
  explicit LossyLab(const Experiment& e, std::vector<int> lost_of)
      : FakeLab(5, e), lost(std::move(lost_of)) {}
  // Serves until a plan is due or the print has ended.
  void to_plan() {
    while (all(channels::kLayerMetrics).empty() && all(channels::kRunEnd).empty()) {
      if (seen == sent.size()) throw std::runtime_error("nothing to serve");
      const Sent s = sent[seen];
      const bool map_due = s.channel == "PROFILER_COMMAND" &&
                           ProfilerVerb(decode<profiler_command_t>(s).verb) == ProfilerVerb::kEnd;
      if (!map_due) {
        serve(0.0);
        continue;
      }
      ++seen;
      plain(NodeId::kLaserProfiler, decode<profiler_command_t>(s), 0.0);
      send_lossy_map(lost.at(std::size_t(scan.attempt)));
    }
  }
  void send_lossy_map(int gone) {
    height_map_t m{};
    m.layer = scan.layer;
    m.attempt = scan.attempt;
    m.map_id = ++map_id;
    m.rows_expected = experiment.grid.ny;
    m.rows_received = m.rows_expected - gone;
    m.measured_fraction = double(m.rows_received) / m.rows_expected;
    HeightMap h(experiment.grid, 0.05);
    m.quality.assign(h.size(), 0);
    for (int j = 0; j < gone; ++j)
      for (int i = 0; i < h.spec.nx; ++i) {
        h.at(i, j) = 0.06;  // a guess
        m.quality[h.spec.index(i, j)] = 1;
      }
    set_height(m, h);
    give(channels::kHeightMap, m);
  }
  std::vector<double> scan_speeds() const {
    std::vector<double> speeds;
    for (const stage_command_t& c : all(channels::kStageCommand))
      if (StageVerb(c.verb) == StageVerb::kScan) speeds.push_back(c.speed_mm_s);
    return speeds;
  }
  std::vector<int> lost;
};

}  // namespace

TEST_CASE("a scan that lost more rows than the limit is made again, slower, and the lost rows are counted",
          "[I13]") {
  Experiment e = small();
  e.process.max_lost_rows_share = 0.1;
  e.laser_profiler.bias_limit_mm = 0.0;  // its bare table is 50 um high
  e.process.max_rescans = 2;
  e.process.min_measured_fraction = 0.5;
  LossyLab lab(e, {2, 1, 0});
  lab.begin(0);
  lab.to_plan();
  CHECK(lab.scan_speeds() == std::vector<double>{15.0, 7.5, 3.75});
  CHECK(lab.last(channels::kLayerMetrics).rows_lost == 3);
  CHECK(lab.last(channels::kLayerMetrics).cells_guessed == 0);
  const auto faults = lab.all(channels::fault(NodeId::kScheduler));
  REQUIRE(faults.size() == 2);
  CHECK_THAT(faults[0].text, Catch::Contains("2 of 5 rows") && Catch::Contains("7.5"));
}

TEST_CASE("rows lost in the last attempt count in no error, and too few measured cells stop the print") {
  Experiment e = small();
  e.laser_profiler.bias_limit_mm = 0.0;
  e.process.max_rescans = 1;
  LossyLab lab(e, {1, 1});
  lab.begin(0);
  lab.to_plan();
  const layer_metrics_t m = lab.last(channels::kLayerMetrics);
  CHECK(m.rows_lost == 2);
  CHECK(m.cells_guessed == e.grid.nx);
  CHECK(m.rms_mm == Approx(0.0).margin(1e-8));  // the guess is 10 um off, the measured cells are right
  CHECK(m.rms_rim_mm == Approx(0.0).margin(1e-8));
  CHECK(m.mean_height_mm == Approx(0.05));
  CHECK(m.volume_mm3 == Approx(0.05 * double(e.grid.size()) * 0.25 * 0.25));
  CHECK_THAT(lab.all(channels::fault(NodeId::kScheduler)).back().text, Catch::Contains("without them"));

  LossyLab blind(e, {3, 3});
  blind.begin(0);
  blind.to_plan();
  CHECK(RunOutcome(blind.last(channels::kRunEnd).outcome) == RunOutcome::kStoppedSafely);
}

TEST_CASE("a command that is not answered in time stops the print and names driver and command", "[I5]") {
  FakeLab lab(5);
  lab.begin(0);
  REQUIRE(lab.wake());
  const fault_t f = lab.last(channels::fault(NodeId::kScheduler));
  REQUIRE(f.text.find("stage has not answered command 1") != std::string::npos);
}

TEST_CASE("a plan for another map is not carried out", "[I6]") {
  FakeLab lab(5);
  lab.begin(0);
  while (lab.all(channels::kLayerMetrics).empty() && lab.serve(0.0)) {
  }
  layer_plan_t p{};
  p.layer = 1;
  p.map_id = lab.map_id + 1;
  set_drops(p, DropletPattern(lab.experiment.grid, 1));
  lab.give(channels::kLayerPlan, p);
  REQUIRE(lab.all(channels::kJetCommand).empty());
}

TEST_CASE("a map that arrived before a crash cut its scan off does not stand in for the scan made after it") {
  FakeLab lab(5);
  lab.begin(0);
  while (lab.serve(0.0)) {
    const auto commands = lab.all(channels::kProfilerCommand);
    if (!commands.empty() && ProfilerVerb(commands.back().verb) == ProfilerVerb::kEnd) break;
  }
  lab.send_map();  // overtakes the profiler's answer, which the crash swallows
  lab.crash();
  lab.seen = lab.sent.size();
  lab.begin(1);
  lab.wake();  // the profiler has nothing to say of its command
  while (lab.serve(0.0)) {
    if (!lab.all(channels::kLayerMetrics).empty()) break;
  }
  REQUIRE(lab.last(channels::kLayerMetrics).attempt == 1);
  while (lab.all(channels::kJetCommand).empty() && lab.serve(0.0)) {
  }
  REQUIRE_FALSE(lab.all(channels::kJetCommand).empty());
}

TEST_CASE("a map and its plan that overtake the profiler's last answer are not lost") {
  FakeLab lab(5);
  lab.begin(0);
  while (lab.serve(0.0)) {
    const auto commands = lab.all(channels::kProfilerCommand);
    if (!commands.empty() && ProfilerVerb(commands.back().verb) == ProfilerVerb::kEnd) break;
  }
  const auto end = lab.last(channels::kProfilerCommand);
  lab.seen = lab.sent.size();
  lab.send_map();
  REQUIRE(lab.all(channels::kLayerMetrics).empty());
  layer_plan_t p{};
  p.layer = 1;
  p.map_id = lab.map_id;
  set_drops(p, DropletPattern(lab.experiment.grid, 1));
  lab.give(channels::kLayerPlan, p);
  lab.plain(NodeId::kLaserProfiler, end, 0.0);
  REQUIRE(lab.all(channels::kLayerMetrics).size() == 1);
  REQUIRE(lab.all(channels::kJetCommand).size() == 1);
}

}  // namespace
TEST_CASE(
    "a part that lies where one is to be printed is a question to the operator, however small beside the "
    "table",
    "[I15]") {
  const auto outcome = [](double lies_mm, double limit_mm = 0.005) {
    Experiment e = small();
    e.grid = {60, 60, 0.25, 0.25, 0.0, 0.0};
    e.laser_profiler.bias_limit_mm = limit_mm;
    e.process.max_rescans = 1;
    Mask part(e.grid);
    for (int j = 28; j < 32; ++j)
      for (int i = 28; i < 32; ++i) part.at(i, j) = 1;
    FakeLab lab(6, e, part);
    lab.rise_mm = 0.0076;
    lab.alter_map = [&](height_map_t& m) {
      if (m.layer > 0) return;
      HeightMap bare(e.grid, 0.0);
      for (std::size_t c = 0; c < bare.size(); ++c) bare.cells[c] = part.cells[c] ? lies_mm : 0.0;
      set_height(m, bare);
    };
    lab.begin(0);
    while (lab.serve(0.0)) {
    }
    return lab.last(channels::kRunEnd);
  };
  const run_end_t stopped = outcome(0.05);  // 16 of 3600 cells: 0.2 um in the mean of the table
  CHECK(RunOutcome(stopped.outcome) == RunOutcome::kStoppedSafely);
  CHECK_THAT(stopped.reason, Catch::Contains("the part's place on the bare table measures 0.05") &&
                                 Catch::Contains("something lies on it"));
  CHECK(RunOutcome(outcome(0.0).outcome) == RunOutcome::kFinished);
  CHECK(RunOutcome(outcome(0.004).outcome) == RunOutcome::kFinished);
  CHECK(RunOutcome(outcome(0.05, 0.0).outcome) == RunOutcome::kFinished);
}

TEST_CASE("a dead nozzle stops the print within two layers and a leaking one at the first map, by name",
          "[I12]") {
  const auto reason = [](double rise_mm, double least_rise_share = 0.3, int within = 2) {
    Experiment e = small();
    e.process.least_rise_share = least_rise_share;
    FakeLab lab(6, e);
    lab.rise_mm = rise_mm;
    lab.begin(0);
    while (lab.serve(0.0)) {
    }
    if (RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished) return std::string();
    CHECK(lab.all(channels::kDepositionReport).back().layer <= within);
    CHECK(lab.last(channels::fault(NodeId::kScheduler)).code == 12);
    return lab.last(channels::kRunEnd).reason;
  };
  CHECK_THAT(reason(0.0), Catch::Contains("jet: ") && Catch::Contains("drops without rise"));
  CHECK_THAT(reason(0.0001), Catch::Contains("drops without rise"));
  CHECK_THAT(reason(0.1, 0.3, 1), Catch::Contains("rise without drops"));
  CHECK(reason(0.0076).empty());
  CHECK(reason(0.005).empty());
  CHECK(reason(0.0, 0.0).empty());
}

TEST_CASE("a print that a dead nozzle has stopped goes on from the map that the resume makes") {
  FakeLab lab(6);
  lab.rise_mm = 0.0;
  lab.begin(0);
  while (lab.serve(0.0)) {
  }
  REQUIRE(lab.last(channels::fault(NodeId::kScheduler)).code == 12);
  lab.layers = 1;
  lab.seen = lab.sent.size();
  lab.begin(1);
  while (lab.serve(0.0)) {
  }
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("a jet that was not seen armed puts every pulse of its pass in doubt") {
  for (const bool open_loop : {false, true}) {
    Experiment e = small();
    if (open_loop) e.control.scheme = "open_loop";
    FakeLab lab(5, e);
    lab.begin(0);
    while (lab.all(channels::kDepositionReport).empty() && lab.serve(0.0)) {
      if (lab.all(channels::kJetCommand).empty()) continue;
      const auto c = lab.last(channels::kJetCommand);
      if (JetVerb(c.verb) == JetVerb::kArm) lab.unsure_command = c.command_id + 2;  // the disarming after it
    }
    const auto r = lab.last(channels::kDepositionReport);
    CHECK(Outcome(r.outcome) == Outcome::kUnknown);
    CHECK(r.unknown_from == 0);
    CHECK(r.unknown_to == r.commanded);
    lab.unsure_command = -1;
    while (lab.serve(0.0)) {
    }
    if (open_loop) REQUIRE(lab.wake());
    CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) ==
          (open_loop ? RunOutcome::kWaitsForOperator : RunOutcome::kFinished));
  }
}

namespace {

/// Prints until the map of `lab` stops it. @returns the faults of interlock 6
std::vector<fault_t> faults_of_height(FakeLab& lab) {
  lab.begin(0);
  while (lab.serve(0.0)) {
  }
  std::vector<fault_t> faults;
  for (const fault_t& f : lab.all(channels::fault(NodeId::kScheduler)))
    if (f.code == 6) faults.push_back(f);
  return faults;
}

Experiment low_nozzle(double clearance_mm) {
  Experiment e = small();
  e.process.nozzle_gap_mm = 0.03;
  e.process.nozzle_clearance_mm = clearance_mm;
  return e;
}

}  // namespace

TEST_CASE("I6: a map that reaches into the nozzle's clearance is made again, then the print stops", "[I6]") {
  FakeLab lab(6, low_nozzle(0.01));  // 0.0076 mm a layer: the third is too high
  const auto faults = faults_of_height(lab);
  REQUIRE(faults.size() == std::size_t(lab.experiment.process.max_rescans) + 1);
  CHECK_THAT(faults.front().text, Catch::Contains("layer 3") && Catch::Contains("measuring again"));
  CHECK(faults.back().severity == std::int8_t(Severity::kStop));
  CHECK_THAT(lab.last(channels::kRunEnd).reason,
             Catch::Contains("0.0228") && Catch::Contains("process.nozzle_clearance_mm"));
  for (const auto& [where, cells] : lab.fired) CHECK(where.first <= 3);

  FakeLab unchecked(6, low_nozzle(0.0));
  CHECK(faults_of_height(unchecked).empty());
  CHECK(RunOutcome(unchecked.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("I6: with two jets the lower nozzle keeps the clearance, whichever it is", "[I6]") {
  for (const double offset_mm : {0.03, -0.03}) {
    CAPTURE(offset_mm);
    Experiment e = low_nozzle(0.01);
    e.process.nozzle_gap_mm = 0.06;
    e.geometry.solid.kind = "pipe";
    e.geometry.solid.outer_diameter_mm = 1.2;
    e.geometry.solid.inner_diameter_mm = 0.5;
    e.jet_b.offset_z_mm = offset_mm;
    FakeLab lab(6, e);
    const auto faults = faults_of_height(lab);
    REQUIRE_FALSE(faults.empty());
    CHECK_THAT(faults.back().text, Catch::Contains("the nozzle is at 0.03"));
    for (const auto& [where, cells] : lab.fired) CHECK(where.first <= 3);
  }
}

TEST_CASE("I6: a cell without a height counts as high", "[I6]") {
  FakeLab lab(6);
  lab.alter_map = [](height_map_t& m) {
    if (m.layer == 2 && m.attempt == 0) m.height_mm[17] = NAN;
  };
  const auto faults = faults_of_height(lab);
  REQUIRE(faults.size() == 1);
  CHECK_THAT(faults[0].text, Catch::Contains("1 cells of the map have no height and count as high"));
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("I9: whatever stopped the print, the stage parks before the lamp exposes", "[I9]") {
  int exposures = 0, resumed = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    FakeLab lab(seed);
    lab.print(0.12);
    std::optional<stage_command_t> stage;
    std::int32_t interrupted = -1;  // incarnation that ended in an exposure
    for (const auto& s : lab.sent) {
      if (s.channel == "STAGE_COMMAND") stage = test::NodeBench::decode<stage_command_t>(s);
      if (s.channel != "LAMP_COMMAND") continue;
      const auto lamp = test::NodeBench::decode<lamp_command_t>(s);
      ++exposures;
      resumed += interrupted >= 0 && lamp.header.incarnation == interrupted + 1;
      interrupted = lamp.header.incarnation;
      REQUIRE(stage);
      REQUIRE(StageVerb(stage->verb) == StageVerb::kMove);
      REQUIRE(stage->x_mm == lab.experiment.process.park_x_mm);
      REQUIRE(stage->header.incarnation == lamp.header.incarnation);
    }
  }
  CHECK(exposures > 300);
  CHECK(resumed > 20);
}

}  // namespace firn
