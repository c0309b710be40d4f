// Orders of the operator to prints in one process, with node time that the test chooses.
#include <catch2/catch.hpp>

#include <poll.h>

#include <cmath>
#include <thread>

#include "cli/replay_command.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "firn/deposition_report_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "print/labs/full_product.h"
#include "print/operator/operator_client.h"
#include "print/operator/operator_desk.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/running.h"
#include "runs/read/run_reader.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn {
namespace {

Experiment tiny(std::uint64_t seed) {
  Experiment e = test::tiny_print("operator");
  e.plant.seed = seed;
  return e;
}

OperatorOrder order(OperatorVerb verb, const std::string& key = "", const std::string& value = "") {
  return {new_order_id(), verb, key, value};
}

struct Print {
  explicit Print(const Experiment& e)
      : run(runs::RunFolder::create(place.path(), e, make_inputs(full_product(), e, ""), {"test"})) {}
  LabRunReport go(std::vector<LabOrder> later = {}, bool resume = false,
                  std::vector<OperatorOrder> at_once = {}) {
    LabRunOptions o;
    o.resume = resume;
    o.orders = std::move(at_once);
    o.later = std::move(later);
    o.note = [&](const std::string& text) { said.push_back(text); };
    return run_in_lab(full_product(), run, o);
  }
  test::TempFolder place;
  runs::RunFolder run;
  std::vector<std::string> said;
};

/// All that was decided, fired and measured, without times.
std::string story(const std::filesystem::path& run) {
  std::string all;
  const runs::RunReader messages(run);
  messages.each<layer_plan_t>(channels::kLayerPlan.name, [&](const layer_plan_t& m) {
    all += "plan " + std::to_string(m.layer) + " " + std::to_string(m.decision) + " " +
           std::string(m.drops.begin(), m.drops.end()) + std::to_string(m.objective_mm) + "\n";
  });
  messages.each<deposition_report_t>(channels::kDepositionReport.name, [&](const deposition_report_t& m) {
    all += "pass " + std::to_string(m.layer) + " " + std::to_string(m.pass_index) + " " +
           std::string(m.drops.begin(), m.drops.end()) + "\n";
  });
  messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    all += "map " + std::to_string(m.layer) + " " +
           std::string(reinterpret_cast<const char*>(m.height_mm.data()),
                       m.height_mm.size() * sizeof m.height_mm[0]) +
           "\n";
  });
  return all;
}

void check_whole(const std::filesystem::path& run) {
  ReplayCommandOptions o;
  o.run = run.string();
  CHECK(replay_verdict(full_product(), o).identical());
  CHECK(replay::audit_run(run).clean());
}

TEST_CASE(
    "a print that waits an hour for the operator goes on with the same bytes as one that did not wait") {
  Experiment e = tiny(3);
  e.plant.drift = 0.0;  // in an hour a nozzle dries and cools: that is nature's, and the next maps show it
  Print plain(e);
  REQUIRE(plain.go().result.status == kOk);
  const std::string wanted = story(plain.run.path());
  for (const double at_s : {0.5, 6.0, 9.0, 12.0}) {
    INFO("pause at " << at_s << " s");
    Print paused(e);
    const LabRunReport report = paused.go({{at_s, order(OperatorVerb::kPause)},
                                           {at_s + 1.0, order(OperatorVerb::kPause)},
                                           {at_s + 3600.0, order(OperatorVerb::kContinue)}});
    CHECK(report.result.status == kOk);
    CHECK(report.node_seconds > 3600.0);
    CHECK((story(paused.run.path()) == wanted));
    REQUIRE(paused.said.size() == 2);
    CHECK_THAT(paused.said[0], Catch::Contains("the print waits before"));
    check_whole(paused.run.path());
  }
}

TEST_CASE("the operator's stop ends a print safely, and a resume finishes it") {
  Print print(tiny(4));
  const LabRunReport report = print.go({{12.0, order(OperatorVerb::kStop)}});
  CHECK(report.result.status == kSafetyStop);
  CHECK(report.result.reason == "stopped by the operator");
  CHECK(print.go({}, true).result.status == kOk);
  check_whole(print.run.path());
}

TEST_CASE("control.max_layers is no dead end: a resume with a higher number finishes the part") {
  Experiment e = tiny(5);
  e.control.max_layers = 1;
  Print print(e);
  CHECK(print.go().result.outcome == "waits for operator");
  CHECK(print.go({}, true).result.outcome == "waits for operator");
  const LabRunReport report = print.go({}, true, {order(OperatorVerb::kSet, "control.max_layers", "60")});
  CHECK(report.result.status == kOk);
  CHECK(report.result.layers > 1);
  check_whole(print.run.path());
}

TEST_CASE(
    "the target's offset, changed while a print runs, raises the part by as much, and replays identical") {
  const auto mean_mm = [](const Print& print) {
    double mean = 0.0;
    const runs::RunReader messages(print.run.path());
    messages.each<layer_metrics_t>(channels::kLayerMetrics.name,
                                   [&](const layer_metrics_t& m) { mean = m.mean_error_mm; });
    return mean;
  };
  Print as_sliced(tiny(8)), raised(tiny(8));
  REQUIRE(as_sliced.go().result.status == kOk);
  const LabRunReport report =
      raised.go({{9.0, order(OperatorVerb::kSet, "control.target_offset_mm", "0.02")}});
  CHECK(report.result.outcome == "out of tolerance");  // 20 um above the target
  CHECK(std::abs(mean_mm(raised) - mean_mm(as_sliced) - 0.02) < 0.003);
  check_whole(raised.run.path());
}

TEST_CASE("finish-layer ends a print after a measured layer, and a resume prints the rest") {
  Print print(tiny(6));
  const LabRunReport report = print.go({{9.0, order(OperatorVerb::kFinishLayer)}});
  CHECK(report.result.outcome == "ended early");
  CHECK(report.result.layers >= 1);
  CHECK(print.go({}, true).result.status == kOk);
  check_whole(print.run.path());
}

TEST_CASE("a client of the socket pauses, sets, continues and stops a running print, each order once") {
  Print print(tiny(7));
  const std::filesystem::path run = print.run.path();
  std::optional<LabRunReport> report;
  std::jthread printing([&] {
    report = print.go(
        {{1.0, order(OperatorVerb::kPause)}, {1.0 + 3600.0 * 24 * 20, order(OperatorVerb::kContinue)}});
  });
  while (!OperatorClient::answers(run)) ::poll(nullptr, 0, 2);
  CHECK(runs::printing_process(run) == ::getpid());
  CHECK_THROWS_WITH(runs::RunLock(run, runs::RunUse::kRead),
                    Catch::Contains("is running (pid " + std::to_string(::getpid()) + ")"));
  OperatorClient client(run);
  const OperatorOrder pause = order(OperatorVerb::kPause);
  client.send(pause);
  CHECK_THAT(client.next(30.0).value_or(""), Catch::Contains("ok pause"));
  client.send(pause);
  CHECK_THAT(client.next(30.0).value_or(""), Catch::Contains("was taken before"));
  client.send(order(OperatorVerb::kSet, "grid.nx", "7"));
  CHECK_THAT(client.next(30.0).value_or(""), Catch::StartsWith("refused grid.nx"));
  client.send(order(OperatorVerb::kSet, "control.max_layers", "77"));
  CHECK_THAT(client.next(30.0).value_or(""), Catch::StartsWith("ok set control.max_layers=77"));
  client.say("7 dance");
  CHECK_THAT(client.next(30.0).value_or(""), Catch::StartsWith("refused 'dance'"));
  client.send(order(OperatorVerb::kStop));
  CHECK_THAT(client.next(30.0).value_or(""), Catch::StartsWith("ok stop"));
  printing.join();
  REQUIRE(report);
  CHECK(report->result.reason == "stopped by the operator");
  CHECK_FALSE(runs::printing_process(run));
  CHECK_THROWS_WITH(OperatorClient(run), Catch::Contains("is not running"));
  CHECK(print.go({}, true).result.status == kOk);
  check_whole(run);
}

TEST_CASE("an order's number of before a resume is refused to another word, and to one that ended with it") {
  Print print(tiny(9));
  const OperatorOrder set = order(OperatorVerb::kSet, "control.max_layers", "77");
  const OperatorOrder pause = order(OperatorVerb::kPause), stop = order(OperatorVerb::kStop);
  REQUIRE(print.go({{1.0, set}, {2.0, pause}, {3.0, order(OperatorVerb::kContinue)}, {12.0, stop}})
              .result.status == kSafetyStop);
  const OperatorOrder accept = order(OperatorVerb::kAcceptDoubt);
  std::optional<LabRunReport> report;
  std::jthread printing([&] {
    report =
        print.go({{1.0, order(OperatorVerb::kPause)}, {3600.0 * 24 * 20, order(OperatorVerb::kContinue)}},
                 true, {accept});
  });
  while (!OperatorClient::answers(print.run.path())) ::poll(nullptr, 0, 2);
  OperatorClient client(print.run.path());
  const auto answer = [&](OperatorOrder given, const OperatorOrder& number_of) {
    given.id = number_of.id;
    client.send(given);
    return client.next(30.0).value_or("");
  };
  const auto refused = [](const OperatorOrder& given, const std::string& more) {
    return "refused order " + std::to_string(given.id) + " was '" + to_text(given) + "' " + more +
           ": without --id it gets a number of its own";
  };
  CHECK(answer(order(OperatorVerb::kContinue), pause) == refused(pause, "and is no 'continue'"));
  CHECK(answer(order(OperatorVerb::kPause), set) == refused(set, "and is no 'pause'"));
  CHECK(answer(order(OperatorVerb::kPause), accept) == refused(accept, "and is no 'pause'"));
  const std::string ended = "before the print was resumed, which ended its effect";
  CHECK(answer(pause, pause) == refused(pause, ended));
  CHECK(answer(stop, stop) == refused(stop, ended));
  CHECK_THAT(answer(set, set), Catch::Contains("was taken before"));
  client.send(order(OperatorVerb::kStop));
  CHECK_THAT(client.next(30.0).value_or(""), Catch::StartsWith("ok stop"));
  printing.join();
  REQUIRE(report);
  CHECK(print.go({}, true).result.status == kOk);
  check_whole(print.run.path());
}

}  // namespace
}  // namespace firn
