#include <catch2/catch.hpp>

#include <cmath>

#include "config/fields.h"
#include "core/grid/decision.h"
#include "core/grid/device.h"
#include "firn/deposition_report_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/height_model_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/run_start_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "page/event_words.h"
#include "page/run_view.h"
#include "page/web_rules.h"

using namespace firn;
using namespace firn::page;
using Catch::Contains;

namespace {

struct Told {
  Told() : view(facts()) {}
  static ViewFacts facts() {
    ViewFacts f;
    f.time_scale = 2.0;
    f.ports = {{"stage", "tcp:10.0.0.2:8000"}, {"jet", "simulated"}};
    f.real = {"stage"};
    f.limits = {{13, "process.min_measured_fraction 0.8"}};
    return f;
  }
  template <class Message>
  void tell(std::string_view channel, Message m, double t_s) {
    m.header.utime_us = std::int64_t(t_s * 1e6);
    std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    view.take(channel, bytes, now_s);
  }
  void metrics(int layer, double rms_mm, double t_s) {
    layer_metrics_t m{};
    m.layer = layer;
    m.layers_expected = 10;
    m.rms_mm = rms_mm;
    m.min_error_mm = -0.004;
    m.max_error_mm = 0.001;
    m.drops = 50;
    tell(channels::kLayerMetrics.name, m, t_s);
  }
  void fault(Severity severity, int code, const std::string& node, const std::string& text, double t_s,
             const Figure& figure = {}) {
    fault_t m{};
    m.severity = std::int8_t(severity);
    m.code = code;
    m.node = node;
    m.text = text;
    m.figure = to_message(figure);
    tell("FAULT_" + std::string(node == "stage" ? "STAGE" : "SCHEDULER"), m, t_s);
  }
  void order(OperatorVerb verb, double t_s, const std::string& key = "", const std::string& value = "") {
    operator_command_t m{};
    m.verb = std::int8_t(verb);
    m.key = key;
    m.value = value;
    m.text = "page";
    tell(channels::kOperatorCommand.name, m, t_s);
  }
  RunView view;
  double now_s = 100.0;
};

}  // namespace

TEST_CASE("the state says in words what the print does now") {
  Told t;
  t.tell(channels::kRunStart.name, run_start_t{}, 0.1);
  CHECK(t.view.state(100.0).phase == Phase::kStarting);
  stage_command_t pass{};
  pass.verb = std::int8_t(StageVerb::kPass);
  pass.layer = 3;
  pass.pass_index = 1;
  t.tell(channels::kStageCommand.name, pass, 1.0);
  CHECK(t.view.state(100.0).words == "depositing layer 3, pass 2");
  CHECK(t.view.state(100.0).layer == 3);
  pass.verb = std::int8_t(StageVerb::kScan);
  t.tell(channels::kStageCommand.name, pass, 2.0);
  CHECK(t.view.state(100.0).words == "measuring layer 3");
  height_map_t map{};
  map.layer = 3;
  t.tell(channels::kHeightMap.name, map, 3.0);
  CHECK(t.view.state(100.0).words == "deciding layer 4");
  CHECK(t.view.take_new().state);
  CHECK_FALSE(t.view.take_new().state);
}

TEST_CASE("ages are wall time since the datum, and the time goes on between messages") {
  Told t;
  height_map_t map{};
  t.tell(channels::kHeightMap.name, map, 10.0);
  device_state_t state{};
  state.node = "stage";
  t.tell("STATE_STAGE", state, 14.0);  // 2 s of wall time later, at twice the speed
  const StateRow s = t.view.state(100.5);
  CHECK(s.surface_s == Approx(2.5));
  CHECK(s.instruments_s == Approx(0.5));
  CHECK_FALSE(s.controller_s);
  CHECK(s.link_s == Approx(0.5));
  CHECK(s.t_s == Approx(15.0));
  t.view.alive(101.0);
  CHECK(t.view.state(101.0).link_s == Approx(0.0));
}

TEST_CASE("the time to the end follows from the rate of the layers so far") {
  Told t;
  t.metrics(0, 0.1, 10.0);
  CHECK_FALSE(t.view.state(100.0).eta_s);
  t.metrics(4, 0.1, 50.0);  // 10 s of node time a layer: 60 s for six, 30 s of wall time
  CHECK(t.view.state(100.0).eta_s == Approx(30.0));
  CHECK(t.view.state(105.0).eta_s == Approx(25.0));
}

TEST_CASE("a layer has its errors in um, its prediction before or after, and comes once") {
  Told t;
  t.view.predicted(2, 3.5);
  t.metrics(2, 0.003, 5.0);
  NewRows rows = t.view.take_new();
  REQUIRE(rows.layers.size() == 1);
  const LayerRow& r = rows.layers[0];
  CHECK(r.rms_um == Approx(3.0));
  CHECK(r.max_um == Approx(4.0));
  CHECK(r.droplets == 50);
  CHECK(r.predicted_rms_um == Approx(3.5));
  CHECK(t.view.take_new().layers.empty());
  OutlineStats stats;
  stats.overspill = 0.0125;
  t.view.outline(2, stats);
  rows = t.view.take_new();
  REQUIRE(rows.layers.size() == 1);
  CHECK(rows.layers[0].outline.overspill == 0.0125);
}

TEST_CASE("a stop is told with its cause, the remedy and the manual's row") {
  Told t;
  t.fault(Severity::kStop, 2, "stage", "no answer for 3 s", 7.0);
  safe_stop_t stop{};
  stop.cause = "stage: no answer for 3 s";
  t.tell(channels::kSafeStop.name, stop, 7.1);
  t.tell(channels::kSafeStop.name, stop, 7.2);  // repeated until all are safe
  CHECK(t.view.state(100.0).phase == Phase::kStopping);
  run_end_t end{};
  end.outcome = std::int8_t(RunOutcome::kStoppedSafely);
  end.reason = "stage: no answer for 3 s";
  t.tell(channels::kRunEnd.name, end, 8.0);
  const NewRows rows = t.view.take_new();
  REQUIRE(rows.events.size() == 3);
  CHECK(rows.events[0].weight == Weight::kFault);
  CHECK(rows.events[0].cause == interlock_words(2)->cause);
  CHECK(rows.events[0].manual == "/manual/safety.html#interlock-2");
  REQUIRE(t.view.end());
  CHECK(t.view.end()->outcome == "stopped safely");
  CHECK(t.view.end()->cause == interlock_words(2)->cause);
  CHECK_THAT(t.view.end()->remedy, Contains("firn print --resume"));
  CHECK(rows.ended);
  CHECK(t.view.state(100.0).phase == Phase::kStopped);
  CHECK_FALSE(t.view.state(100.0).link_s);
  CHECK(t.view.instruments().at("stage").faults == 1);
}

TEST_CASE("a safe stop that the operator asks for is no fault, and its end says how to go on") {
  Told t;
  t.order(OperatorVerb::kStop, 7.0);
  safe_stop_t stop{};
  stop.cause = "stopped by the operator";
  t.tell(channels::kSafeStop.name, stop, 7.1);
  t.tell(channels::kSafeStop.name, stop, 7.2);
  run_end_t end{};
  end.outcome = std::int8_t(RunOutcome::kStoppedSafely);
  end.reason = stop.cause;
  t.tell(channels::kRunEnd.name, end, 8.0);
  for (const EventRow& e : t.view.take_new().events) CHECK(e.weight < Weight::kWarning);
  REQUIRE(t.view.end());
  CHECK(t.view.end()->by_operator);
  CHECK(t.view.end()->remedy == "firn print --resume RUN goes on with it");
}

TEST_CASE("a print that has finished shows no stop, though its lab is made safe") {
  Told t;
  run_end_t end{};
  end.outcome = std::int8_t(RunOutcome::kFinished);
  end.reason = "the last layer is printed";
  t.tell(channels::kRunEnd.name, end, 8.0);
  safe_stop_t stop{};
  stop.cause = "the print is over";
  t.tell(channels::kSafeStop.name, stop, 8.1);
  for (const EventRow& e : t.view.take_new().events) CHECK(e.weight == Weight::kInfo);
  CHECK(t.view.state(100.0).phase == Phase::kFinished);
}

TEST_CASE("the end that the run folder holds takes the place of the scheduler's") {
  Told t;
  run_end_t end{};
  end.outcome = std::int8_t(RunOutcome::kFinished);
  end.reason = "the last layer is printed";
  t.tell(channels::kRunEnd.name, end, 8.0);
  t.view.over("out of tolerance", "RMS 80.00 um of the last map, more than 7.60 um");
  REQUIRE(t.view.end());
  CHECK(t.view.end()->outcome == "out of tolerance");
  CHECK(t.view.take_new().events.back().weight == Weight::kWarning);
}

TEST_CASE("a pause shows where it waits, and the print afterwards goes on where it was") {
  Told t;
  stage_command_t pass{};
  pass.verb = std::int8_t(StageVerb::kPass);
  pass.layer = 7;
  t.tell(channels::kStageCommand.name, pass, 1.0);
  t.order(OperatorVerb::kPause, 1.5);
  CHECK(t.view.state(100.0).paused);
  CHECK(t.view.state(100.0).phase == Phase::kDepositing);
  t.fault(Severity::kNotice, 0, "scheduler", "the print waits before layer 7, pass 2, as the operator asked",
          2.0);
  CHECK(t.view.state(100.0).phase == Phase::kPaused);
  t.order(OperatorVerb::kContinue, 3.0);
  t.fault(Severity::kNotice, 0, "scheduler", "the print goes on", 3.1);
  CHECK(t.view.state(100.0).phase == Phase::kDepositing);
  CHECK_FALSE(t.view.state(100.0).paused);
}

TEST_CASE("a doubt stays until the surface is measured or the operator accepts it") {
  const auto unknown = [](Told& t) {
    deposition_report_t m{};
    m.layer = 5;
    m.pass_index = 0;
    m.outcome = std::int8_t(Outcome::kUnknown);
    m.unknown_from = 10;
    m.unknown_to = 14;
    t.tell(channels::kDepositionReport.name, m, 1.0);
  };
  Told measured, accepted;
  unknown(measured);
  REQUIRE(measured.view.state(100.0).doubt);
  CHECK_THAT(measured.view.state(100.0).doubt->words, Contains("4 droplets of layer 5, pass 1"));
  height_map_t map{};
  map.layer = 5;
  measured.tell(channels::kHeightMap.name, map, 2.0);
  CHECK_FALSE(measured.view.state(100.0).doubt);
  unknown(accepted);
  accepted.order(OperatorVerb::kAcceptDoubt, 2.0);
  CHECK_FALSE(accepted.view.state(100.0).doubt);
}

TEST_CASE("a changed setting, an estimate and an instrument are rows of their own") {
  Told t;
  t.order(OperatorVerb::kSet, 1.0, "control.max_layers", "40");
  height_model_t model{};
  model.h1_mm = 0.0044;
  model.covariance_mm2[0] = 1e-8;
  t.tell(channels::kHeightModel.name, model, 2.0);
  device_state_t state{};
  state.node = "jet";
  state.state = std::int8_t(DeviceState::kArmed);
  state.identity = "JetDrive III";
  t.tell("STATE_JET", state, 3.0);
  t.view.exchanged("jet", "sent A | received B");
  const NewRows rows = t.view.take_new();
  REQUIRE(rows.settings.size() == 1);
  CHECK(rows.settings[0] == std::pair<std::string, std::string>("control.max_layers", "40"));
  REQUIRE(rows.estimates.size() == 3);
  CHECK(rows.estimates[0].name == "h1");
  CHECK(rows.estimates[0].value == Approx(4.4));
  CHECK(rows.estimates[0].sd == Approx(0.1));
  REQUIRE(rows.instruments.size() == 1);
  CHECK(rows.instruments[0].state == "armed");
  CHECK(rows.instruments[0].last_text == "sent A | received B");
  CHECK_FALSE(rows.instruments[0].real);
  CHECK(t.view.instruments().at("stage").real);
}

TEST_CASE("a print that goes on after its end has no end any more") {
  Told t;
  t.view.over("interrupted", "nobody prints this run now");
  CHECK(t.view.state(100.0).phase == Phase::kInterrupted);
  run_start_t start{};
  start.header.incarnation = 1;
  t.tell(channels::kRunStart.name, start, 5.0);
  CHECK_FALSE(t.view.end());
  CHECK(t.view.events().back().words == "the print goes on");
}

TEST_CASE("the events of a print without end take a bounded room") {
  Told t;
  for (int n = 0; n < 5000; ++n) {
    t.fault(Severity::kNotice, 0, "scheduler", "notice " + std::to_string(n), 1e-3 * n);
    if (n % 100 == 0) t.view.take_new();
  }
  CHECK(t.view.events().size() == 1000);
  CHECK(t.view.events().back().n == 5000);
  CHECK(t.view.events().back().words == "notice 4999");
}

TEST_CASE("every fault says its cause, its limit where a setting sets one, and what to do") {
  Told t;
  t.fault(Severity::kWarning, 13, "scheduler", "0.71 of the map was measured", 1.0);
  t.fault(Severity::kStop, 0, "scheduler", "the queue is full", 2.0);
  const auto rows = t.view.take_new();
  CHECK(rows.events[0].cause ==
        std::string(interlock_words(13)->cause) + "; limits: process.min_measured_fraction 0.8");
  CHECK_FALSE(rows.events[0].value);
  CHECK(rows.events[1].remedy == kResume);
  CHECK(rows.events[1].manual == kStopPage);
}

TEST_CASE("an interlock's event has its value and limit as numbers") {
  Told t;
  t.fault(Severity::kStop, 13, "scheduler", "too little is measured", 1.0,
          {0.45, 0.8, "", "process.min_measured_fraction"});
  t.fault(Severity::kWarning, 12, "scheduler", "a valve leaks", 2.0, {0.31, std::nullopt, "mm"});
  t.fault(Severity::kWarning, 12, "scheduler", "the map measures 0.45 of the grid; 0.8 is needed", 3.0);
  const auto rows = t.view.take_new();
  REQUIRE(rows.events.size() == 3);
  CHECK(rows.events[0].value == 0.45);
  CHECK(rows.events[0].limit == 0.8);
  CHECK(rows.events[0].unit == "");
  CHECK(rows.events[1].value == 0.31);
  CHECK_FALSE(rows.events[1].limit);
  CHECK(rows.events[1].unit == "mm");
  CHECK_FALSE(rows.events[2].value);  // no number is read out of words
  CHECK_FALSE(rows.events[2].limit);
}

TEST_CASE("a lab of lines tells what it prints, and what it learns of flow and shutter") {
  Told t;
  stage_command_t way{};
  way.verb = std::int8_t(StageVerb::kTrace);
  way.layer = 2;
  t.tell(channels::kStageCommand.name, way, 1.0);
  CHECK(t.view.state(t.now_s).words == "printing the lines of layer 2");
  line_plan_t plan{};
  plan.layer = 3;
  plan.flow_share = 0.9;
  plan.sheath_share = 1.2;
  plan.open_delay_s = 0.012;
  plan.start_error_mm = 0.03;
  plan.end_error_mm = std::nan("");
  t.tell(channels::kLinePlan.name, plan, 2.0);
  const auto rows = t.view.take_new();
  std::map<std::string, double> learned;
  for (const EstimateRow& e : rows.estimates) learned[e.name] = e.value;
  CHECK(learned == std::map<std::string, double>{{"flow", 0.9},
                                                 {"sheath_gas", 1.2},
                                                 {"shutter_opens_late_by", 12.0},
                                                 {"shutter_closes_late_by", 0.0},
                                                 {"lines_start_late_by", 0.03}});
  CHECK(rows.events.empty());
  plan.decision = std::int8_t(PlanDecision::kStop);
  plan.reason = "no flow";
  t.tell(channels::kLinePlan.name, plan, 3.0);
  const auto last = t.view.take_new();
  CHECK(last.events.at(0).cause == "no flow");
  REQUIRE(last.estimates.size() == 1);  // no layer follows: shutter and flow of the one before stand
  CHECK(last.estimates[0].name == "lines_start_late_by");
}

TEST_CASE("Verdict and facts of a result come with the end, once, and none before it") {
  Told t;
  t.view.judged("within tolerance", true, "part: disc\n");
  CHECK_FALSE(t.view.end());
  t.view.over("finished", "done");
  t.view.take_new();
  t.view.judged("within tolerance: RMS 3 um", true, "part: disc\naudit: clean\n");
  CHECK(t.view.take_new().ended);
  CHECK(t.view.end()->verdict == "within tolerance: RMS 3 um");
  CHECK(t.view.end()->within == true);
  t.view.judged("within tolerance: RMS 3 um", true, "part: disc\naudit: clean\n");
  CHECK_FALSE(t.view.take_new().ended);
}

TEST_CASE("A recorded sentence with six decimals is shown with three digits") {
  Told t;
  fault_t fault{};
  fault.node = "stage";
  fault.text = "no answer within 60.000126 s";
  fault.severity = std::int8_t(Severity::kWarning);
  t.tell(channels::fault(NodeId::kStage).name, fault, 1.0);
  CHECK(t.view.take_new().events.at(0).words == "no answer within 60 s");
}

TEST_CASE("every interlock of the safety manual has its words") {
  for (int code = 1; code <= 16; ++code) {
    INFO(code);
    CHECK(interlock_words(code) != nullptr);
  }
}

TEST_CASE("the limits of the interlocks are settings") {
  Experiment e;
  std::set<std::string> keys;
  for (const Field& f : fields(e)) keys.insert(f.key);
  for (const InterlockWords& row : interlocks())
    for (const std::string_view key : list_words(row.limits)) {
      INFO(key);
      CHECK(keys.contains(std::string(key)));
    }
}

TEST_CASE(
    "the lamp tells how long this print has opened it, in one row whatever its driver tells meanwhile") {
  Told t;
  lamp_command_t m{};
  m.exposure_s = 18.0;
  device_state_t state{};
  state.node = "lamp";
  state.identity = "OmniCure S2000";
  for (int n = 0; n < 10; ++n) {
    t.tell("STATE_LAMP", state, n);
    t.tell(channels::kLampCommand.name, m, n);
  }
  using Row = std::tuple<std::string, std::string, std::string>;
  const auto& details = t.view.instruments().at("lamp").details;
  REQUIRE(details.size() == 3);
  CHECK(details[0] == Row("open in this print", "0.0500", "h"));
  CHECK(details[1] == Row("exposures in this print", "10", ""));
  CHECK(details[2] == Row("identity", "OmniCure S2000", ""));
}
