#include <catch2/catch.hpp>

#include <map>
#include <optional>
#include <set>

#include "core/grid/firing_order.h"
#include "core/grid/random.h"
#include "firn/deposition_report_t.hpp"
#include "firn/fault_t.hpp"
#include "firn/jet_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/node.h"
#include "tests/support/node_bench.h"

namespace firn {
namespace {

Experiment small() {
  Experiment e;
  e.grid = {7, 5, 0.25, 0.25, 0.0, 0.0};
  e.control.max_layers = 50;
  return e;
}

// A lab that answers commands truthfully, counts every droplet it fires, and can crash in the middle of any command.
struct FakeLab : test::NodeBench {
  explicit FakeLab(std::uint64_t seed, const Experiment& e = small())
      : NodeBench(NodeId::kScheduler, std::make_unique<Scheduler>(e, HeightMap(e.grid, 0.05), Mask(e.grid, 1))),
        random(seed, Purpose::kTest), experiment(e) {}

  void begin(std::int32_t incarnation) {
    start(incarnation);
    ++epoch;
    if (unanswered) {
      const answer_t late = *unanswered;
      unanswered.reset();
      give(channels::answer(late_driver), late);
    }
    for (NodeId d : {NodeId::kStage, NodeId::kJet, NodeId::kLaserProfiler, NodeId::kLamp}) {
      device_state_t s{};
      s.node = info(d).name;
      s.state = std::int8_t(DeviceState::kSafe);
      give(channels::device_state(d), s);
    }
    enable_t lease{};
    lease.enable_epoch = epoch;
    lease.enabled = 1;
    lease.lease_s = 0.3;
    give(channels::kEnable, lease);
  }

  void crash() {
    safe_stop_t stop{};
    stop.enable_epoch = ++epoch;
    stop.cause = "test";
    give(channels::kSafeStop, stop);
  }

  // Carries out the newest command that has not been seen. @returns false when there is none.
  bool serve(double crash_probability) {
    while (seen < sent.size()) {
      const Sent s = sent[seen++];
      if (s.channel == "RUN_END") return false;
      if (s.channel == "STAGE_COMMAND") return stage(decode<stage_command_t>(s), crash_probability);
      if (s.channel == "JET_COMMAND") return plain(NodeId::kJet, decode<jet_command_t>(s), crash_probability);
      if (s.channel == "LAMP_COMMAND") return plain(NodeId::kLamp, decode<lamp_command_t>(s), crash_probability);
      if (s.channel == "PROFILER_COMMAND") {
        const auto c = decode<profiler_command_t>(s);
        if (ProfilerVerb(c.verb) == ProfilerVerb::kArm) scan = c;
        const bool alive = plain(NodeId::kLaserProfiler, c, crash_probability);
        if (alive && ProfilerVerb(c.verb) == ProfilerVerb::kEnd) send_map();
        return alive;
      }
      if (s.channel == "LAYER_METRICS") send_plan();
    }
    return false;
  }

  template <class Command>
  bool plain(NodeId driver, const Command& c, double crash_probability) {
    answer_t a{};
    a.node = info(driver).name;
    a.command_id = c.command_id;
    a.outcome = std::int8_t(Outcome::kDone);
    if (random.uniform() < crash_probability) {
      a.outcome = std::int8_t(random.below(2) ? Outcome::kNone : Outcome::kDone);
      if (random.below(2)) {
        late_driver = driver;
        unanswered = a;
      }
      crash();
      return false;
    }
    give(channels::answer(driver), a);
    return true;
  }

  bool stage(const stage_command_t& c, double crash_probability) {
    if (StageVerb(c.verb) != StageVerb::kPass) return plain(NodeId::kStage, c, crash_probability);
    DropletPattern drops(experiment.grid);
    drops.cells.assign(c.drops.begin(), c.drops.end());
    const auto order = firing_order(drops, c.pass);
    const std::size_t n = order.size();
    answer_t a{};
    a.node = "stage";
    a.command_id = c.command_id;
    a.expected = std::int64_t(n);
    std::size_t fire = n;
    const bool dies = random.uniform() < crash_probability;
    bool says_nothing = false;
    if (dies) {
      fire = random.below(std::uint32_t(n + 1));
      switch (random.below(4)) {
        case 0:  // the instrument's counter tells exactly
          a.outcome = std::int8_t(fire == n ? Outcome::kDone : Outcome::kNone);
          a.counted = std::int64_t(fire);
          break;
        case 1: {  // only a range is known
          const std::size_t from = random.below(std::uint32_t(fire + 1));
          a.outcome = std::int8_t(Outcome::kUnknown);
          a.counted = std::int64_t(from);
          a.unknown_from = std::int64_t(from);
          a.unknown_to = std::int64_t(fire + random.below(std::uint32_t(n - fire + 1)));
          break;
        }
        case 2:  // it was refused before anything moved
          fire = 0;
          a.outcome = std::int8_t(Outcome::kRefused);
          a.counted = 0;
          break;
        default:  // the driver comes back and knows nothing of it
          says_nothing = true;
      }
    } else {
      a.outcome = std::int8_t(Outcome::kDone);
      a.counted = std::int64_t(n);
    }
    for (std::size_t k = 0; k < fire; ++k) ++fired[{c.layer, c.pass}][order[k]];
    if (!dies) {
      give(channels::answer(NodeId::kStage), a);
      return true;
    }
    if (!says_nothing) {
      late_driver = NodeId::kStage;
      unanswered = a;
    }
    crash();
    return false;
  }

  void send_map() {
    height_map_t m{};
    m.layer = scan.layer;
    m.attempt = scan.attempt;
    m.map_id = ++map_id;
    m.measured_fraction = 1.0;
    set_height(m, HeightMap(experiment.grid, 0.001 * scan.layer));
    m.quality.assign(m.height_mm.size(), 0);
    give(channels::kHeightMap, m);
  }

  void send_plan() {
    const auto metrics = all(channels::kLayerMetrics).back();
    layer_plan_t p{};
    p.layer = metrics.layer + 1;
    p.attempt = metrics.attempt;
    p.map_id = metrics.map_id;
    DropletPattern drops(experiment.grid);
    if (p.layer > layers) {
      p.decision = std::int8_t(PlanDecision::kEnd);
    } else {
      for (std::size_t c = 0; c < drops.size(); ++c) drops.cells[c] = std::uint8_t(random.below(3));
      planned[p.layer] = drops;
    }
    set_drops(p, drops);
    give(channels::kLayerPlan, p);
  }

  // Prints to the end, resuming after every crash. @returns the number of crashes.
  int print(double crash_probability) {
    int incarnation = 0;
    begin(0);
    for (int guard = 0; guard < 20000; ++guard) {
      if (host.finished() == 0 || (!all(channels::kRunEnd).empty() && RunOutcome(last(channels::kRunEnd).outcome) == RunOutcome::kFinished))
        return incarnation;
      if (serve(crash_probability)) continue;
      if (!all(channels::kRunEnd).empty() && RunOutcome(last(channels::kRunEnd).outcome) == RunOutcome::kFinished) return incarnation;
      if (seen < sent.size()) continue;
      if (is_stopped()) {
        begin(++incarnation);
        // Where a driver says nothing, the scheduler waits for its deadline.
        if (seen == sent.size()) wake();
      } else if (!wake()) {
        FAIL("the scheduler waits for nothing");
      }
    }
    FAIL("the print does not end");
    return -1;
  }
  bool is_stopped() const {
    const auto ends = all(channels::kRunEnd);
    return ends.size() > ends_seen && ((void)(ends_seen = ends.size()), true);
  }

  RandomStream random;
  Experiment experiment;
  int layers = 4;
  std::size_t seen = 0;
  mutable std::size_t ends_seen = 0;
  std::int64_t epoch = 0, map_id = 0;
  profiler_command_t scan{};
  std::optional<answer_t> unanswered;
  NodeId late_driver = NodeId::kStage;
  std::map<int, DropletPattern> planned;
  std::map<std::pair<int, int>, std::map<std::uint32_t, int>> fired;  // (layer, pass) -> cell -> triggers
};

TEST_CASE("an undisturbed print fires every planned droplet exactly once, in as many passes as a cell has drops") {
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
      if (s.channel == "STAGE_COMMAND" && StageVerb(test::NodeBench::decode<stage_command_t>(s).verb) == StageVerb::kPass) {
        CAPTURE(seed);
        REQUIRE_FALSE(doubt);
      }
    }
  }
}

TEST_CASE("the open loop stops for the operator when droplets are in doubt, and goes on when they are accepted") {
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
  while (lab.serve(0.0)) {}
  REQUIRE(lab.wake());
  REQUIRE(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kWaitsForOperator);
  REQUIRE(lab.last(channels::kRunEnd).reason.find("--accept-doubt") != std::string::npos);

  const std::size_t passes = lab.all(channels::kDepositionReport).size();
  lab.seen = lab.sent.size();
  lab.begin(2);
  operator_command_t accept{};
  accept.verb = std::int8_t(OperatorVerb::kAcceptDoubt);
  lab.give(channels::kOperatorCommand, accept);
  while (lab.serve(0.0)) {}
  REQUIRE(lab.all(channels::kDepositionReport).size() > passes);
  REQUIRE(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("a map that measures too little is taken again, then stops the print by name") {
  Experiment e = small();
  e.process.max_rescans = 2;
  FakeLab lab(5, e);
  lab.begin(0);
  int maps = 0;
  while (lab.seen < lab.sent.size()) {
    const auto s = lab.sent[lab.seen];
    if (s.channel == "PROFILER_COMMAND" && ProfilerVerb(test::NodeBench::decode<profiler_command_t>(s).verb) == ProfilerVerb::kEnd) {
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
}

TEST_CASE("a command that is not answered in time stops the print and names driver and command") {
  FakeLab lab(5);
  lab.begin(0);
  REQUIRE(lab.wake());
  const fault_t f = lab.last(channels::fault(NodeId::kScheduler));
  REQUIRE(f.text.find("stage has not answered command 1") != std::string::npos);
}

TEST_CASE("a plan for another map is not carried out") {
  FakeLab lab(5);
  lab.begin(0);
  while (lab.all(channels::kLayerMetrics).empty() && lab.serve(0.0)) {}
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
  while (lab.all(channels::kJetCommand).empty() && lab.serve(0.0)) {}
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
}  // namespace firn
