// Orders of the operator, as scheduler, safety and controller obey them.
#include <catch2/catch.hpp>

#include "firn/enable_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "procs/controller/node.h"
#include "procs/safety/node.h"
#include "tests/procs/fake_lab.h"

namespace firn {
namespace {

using test::FakeLab;
using test::small;

operator_command_t order(OperatorVerb verb, std::int64_t id, const std::string& key = "",
                         const std::string& value = "") {
  operator_command_t c{};
  c.command_id = id;
  c.verb = std::int8_t(verb);
  c.key = key;
  c.value = value;
  return c;
}

void give(FakeLab& lab, const operator_command_t& c) { lab.give(channels::kOperatorCommand, c); }

/// Commands that move or fire something, without their times.
std::vector<std::string> acts(const FakeLab& lab) {
  std::vector<std::string> all;
  for (const auto& s : lab.sent)
    if (s.channel == "STAGE_COMMAND") {
      const auto c = FakeLab::decode<stage_command_t>(s);
      all.push_back("stage " + std::to_string(c.verb) + " layer " + std::to_string(c.layer) + " pass " +
                    std::to_string(c.pass_index) + " " + std::string(c.fires.begin(), c.fires.end()));
    } else if (s.channel.ends_with("_COMMAND")) {
      all.push_back(s.channel);
    }
  return all;
}

void serve_all(FakeLab& lab) {
  while (lab.serve(0.0)) {
  }
}

TEST_CASE("a paused print sends no command for an hour, and then the commands that it would have sent") {
  FakeLab plain(3);
  plain.print(0.0);
  const std::vector<std::string> wanted = acts(plain);
  for (const std::size_t after : {1u, 4u, 9u, 15u, 23u, 40u}) {
    INFO("pause after " << after << " acts");
    FakeLab lab(3);
    lab.begin(0);
    while (acts(lab).size() < after && lab.serve(0.0)) {
    }
    give(lab, order(OperatorVerb::kPause, 7));
    serve_all(lab);
    const std::size_t held_at = acts(lab).size();
    REQUIRE(held_at < wanted.size());
    CHECK_FALSE(lab.host.next_timer());  // nothing is overdue, however long the pause is
    lab.now = lab.now.after_s(3600.0);
    give(lab, order(OperatorVerb::kContinue, 8));
    CHECK(acts(lab).size() == held_at + 1);
    serve_all(lab);
    CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
    CHECK(acts(lab) == wanted);
    for (const auto& m : lab.all(channels::kLayerMetrics))
      CHECK(m.deposit_s + m.cure_s + m.scan_s + m.decide_s < 60.0);  // the pause is in no layer's time
  }
}

TEST_CASE("a print is never held while an instrument is armed or droplets are wet") {
  for (std::size_t after = 1; after < 60; ++after) {
    FakeLab lab(5);
    lab.begin(0);
    while (acts(lab).size() < after && lab.serve(0.0)) {
    }
    give(lab, order(OperatorVerb::kPause, 7));
    serve_all(lab);
    if (!lab.all(channels::kRunEnd).empty()) return;
    CHECK(lab.armed == Material::kNone);
    CHECK(lab.wet.empty());
  }
}

TEST_CASE("an order that arrives a second time has no effect") {
  FakeLab lab(3);
  lab.begin(0);
  give(lab, order(OperatorVerb::kPause, 7));
  give(lab, order(OperatorVerb::kContinue, 8));
  give(lab, order(OperatorVerb::kPause, 7));
  serve_all(lab);
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("a print that is stopped while it is paused goes on when it is resumed") {
  FakeLab lab(3);
  lab.begin(0);
  while (acts(lab).size() < 9 && lab.serve(0.0)) {
  }
  give(lab, order(OperatorVerb::kPause, 7));
  serve_all(lab);
  lab.crash();
  lab.seen = lab.sent.size();
  lab.begin(1);
  lab.give_of(0, channels::kOperatorCommand, order(OperatorVerb::kPause, 9));  // sent before the resume
  serve_all(lab);
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("finish-layer ends the print when the layer is measured, and a resume prints the rest") {
  FakeLab lab(3);
  lab.begin(0);
  while (lab.all(channels::kLayerMetrics).size() < 2 && lab.serve(0.0)) {
  }
  serve_all(lab);
  FakeLab early(3);
  early.begin(0);
  while (early.all(channels::kLayerMetrics).size() < 2 && early.serve(0.0)) {
  }
  give(early, order(OperatorVerb::kPause, 6));
  give(early, order(OperatorVerb::kFinishLayer, 7));  // a print that waits goes on for it
  serve_all(early);
  const run_end_t end = early.last(channels::kRunEnd);
  CHECK(RunOutcome(end.outcome) == RunOutcome::kEndedEarly);
  CHECK(end.layers == early.all(channels::kLayerMetrics).back().layer);
  CHECK(end.layers >= 1);
  CHECK(end.layers < 4);
  CHECK(early.wet.empty());
  early.seen = early.sent.size();
  early.begin(1);
  serve_all(early);
  CHECK(RunOutcome(early.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("control.max_layers can be raised while the print runs") {
  Experiment e = small();
  e.control.max_layers = 2;
  FakeLab stopped(3, e);
  stopped.begin(0);
  serve_all(stopped);
  REQUIRE(RunOutcome(stopped.last(channels::kRunEnd).outcome) == RunOutcome::kWaitsForOperator);

  FakeLab lab(3, e);
  lab.begin(0);
  give(lab, order(OperatorVerb::kSet, 7, "control.max_layers", "40"));
  serve_all(lab);
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);

  stopped.seen = stopped.sent.size();
  stopped.begin(1);  // or by the resume
  give(stopped, order(OperatorVerb::kSet, 8, "control.max_layers", "40"));
  serve_all(stopped);
  CHECK(RunOutcome(stopped.last(channels::kRunEnd).outcome) == RunOutcome::kFinished);
}

TEST_CASE("an option that may not change while a print runs is refused by name") {
  FakeLab lab(3);
  lab.begin(0);
  give(lab, order(OperatorVerb::kSet, 7, "process.park_x_mm", "3"));
  const auto faults = lab.all(channels::fault(NodeId::kScheduler));
  REQUIRE(faults.size() == 1);
  CHECK_THAT(faults[0].text, Catch::Contains("process.park_x_mm") && Catch::Contains("control.max_layers"));
}

TEST_CASE("the operator's stop raises the epoch in the same step, and only in its own incarnation") {
  test::NodeBench b(NodeId::kSafety, std::make_unique<Safety>(Experiment{}));
  b.start();
  const std::int64_t before = b.last(channels::kEnable).enable_epoch;
  b.give(channels::kOperatorCommand, order(OperatorVerb::kPause, 6));
  CHECK(b.all(channels::kSafeStop).empty());
  b.give(channels::kOperatorCommand, order(OperatorVerb::kStop, 7));
  REQUIRE(b.all(channels::kSafeStop).size() == 1);
  CHECK(b.last(channels::kSafeStop).enable_epoch == before + 1);
  CHECK(b.last(channels::kSafeStop).cause == "stopped by the operator");
  b.give(channels::kOperatorCommand, order(OperatorVerb::kStop, 7));
  CHECK(b.last(channels::kSafeStop).enable_epoch == before + 1);

  test::NodeBench later(NodeId::kSafety, std::make_unique<Safety>(Experiment{}));
  later.start(1);
  later.give_of(0, channels::kOperatorCommand, order(OperatorVerb::kStop, 7));
  CHECK(later.all(channels::kSafeStop).empty());
}

TEST_CASE("a changed gain holds from the next decision on, and the memory of the scheme stays") {
  Experiment e = small();
  e.control.scheme = "smf";
  const auto plan = [&](test::NodeBench& b, int layer) {
    height_map_t m{};
    m.layer = layer;
    m.map_id = layer + 1;
    m.measured_fraction = 1.0;
    HeightMap h(e.grid, 0.0076 * layer - 0.002);
    h.cells[3] -= 0.003;
    set_height(m, h);
    m.quality.assign(m.height_mm.size(), 0);
    b.give(channels::kHeightMap, m);
    return b.last(channels::kLayerPlan).drops;
  };
  const auto node = [&](const Experiment& of) {
    return std::make_unique<ControllerNode>(of, HeightMap(e.grid, 0.08), Mask(e.grid, 1));
  };
  test::NodeBench plain(NodeId::kController, node(e)), changed(NodeId::kController, node(e));
  plain.start();
  changed.start();
  Experiment high = e;
  high.control.smf.kp = 3.0;
  test::NodeBench gain(NodeId::kController, node(high));
  gain.start();
  bool differs = false;
  for (int layer = 0; layer < 6; ++layer) {
    if (layer == 3)
      changed.give(channels::kOperatorCommand, order(OperatorVerb::kSet, 7, "control.smf.kp", "3"));
    const auto as_planned = plan(plain, layer), as_changed = plan(changed, layer);
    plan(gain, layer);
    if (layer < 3) CHECK(as_planned == as_changed);
    differs = differs || as_planned != as_changed;
  }
  CHECK(differs);
}

}  // namespace
}  // namespace firn
