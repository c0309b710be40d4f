#include <catch2/catch.hpp>

#include <cmath>

#include "tests/procs/fake_ice_lab.h"

namespace firn {
namespace {

using test::FakeIceLab;
using test::small_ice;

void check_interlocks(const FakeIceLab& lab) {
  CHECK_FALSE(lab.both_armed);
  CHECK_FALSE(lab.wrong_signal);
  CHECK_FALSE(lab.wrong_valve);
  CHECK_FALSE(lab.unloaded);
}

std::string last_fault(const FakeIceLab& lab) { return lab.last(channels::fault(NodeId::kScheduler)).text; }

TEST_CASE("an undisturbed ice print runs every path once, in order, and measures every interval") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    FakeIceLab lab(seed, small_ice());
    REQUIRE(lab.print(0.0) == 0);
    check_interlocks(lab);
    std::int64_t before = 0;
    for (const path_report_t& r : lab.all(channels::kPathReport)) {
      CHECK(r.path > before);
      before = r.path;
      CHECK(r.pulses_counted == lab.commanded[r.path].pulses);
      CHECK(r.measured_s == Approx(lab.commanded[r.path].duration_s));
    }
    for (const auto& [path, job] : lab.commanded)
      for (int list = 0; list < job.lists; ++list) REQUIRE(lab.runs[{path, list}] == 1);
    const auto metrics = lab.all(channels::kLayerMetrics);
    REQUIRE(metrics.size() == 3);
    CHECK(metrics.back().layer == 6);
    CHECK(metrics.back().rms_mm == Approx(0.0).margin(1e-6));
    CHECK(metrics.back().layers_expected == 6);
  }
}

TEST_CASE("a path that is shorter than a drop is reported and not run") {
  FakeIceLab lab(4, small_ice());
  lab.empty_path = true;
  REQUIRE(lab.print(0.0) == 0);
  int empty = 0;
  for (const path_report_t& r : lab.all(channels::kPathReport)) {
    const path_job_t& job = lab.commanded[r.path];
    if (job.index != 1) continue;
    ++empty;
    CHECK(r.pulses_counted == 0);
    CHECK(lab.runs.count({r.path, 0}) == 0);
  }
  CHECK(empty > 0);
}

TEST_CASE(
    "however often an ice print crashes and resumes, no path is run twice and none is left out but in "
    "doubt") {
  int crashes = 0, doubts = 0;
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    CAPTURE(seed);
    FakeIceLab lab(seed, small_ice());
    lab.refusals = int(seed % 5);
    crashes += lab.print(0.06);
    check_interlocks(lab);
    for (const auto& [where, times] : lab.runs) REQUIRE(times <= 1);
    std::set<std::int64_t> reported, doubtful;
    for (const path_report_t& r : lab.all(channels::kPathReport)) {
      REQUIRE(reported.insert(r.path).second);
      if (Outcome(r.outcome) != Outcome::kDone) doubtful.insert(r.path);
    }
    for (const auto& [path, job] : lab.commanded) {
      CAPTURE(path);
      if (job.kind == 3) continue;
      REQUIRE(reported.count(path) == 1);
      if (doubtful.count(path)) continue;
      for (int list = 0; list < job.lists; ++list) REQUIRE(lab.runs[{path, list}] == 1);
    }
    doubts += int(doubtful.size());
  }
  CHECK(crashes > 200);
  CHECK(doubts > 30);
}

TEST_CASE("a valve that lost its power while it was armed leaves its path in doubt and is not armed again") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    FakeIceLab lab(seed, small_ice());
    lab.reset_while_armed = 0.2;
    const int crashes = lab.print(0.0);
    REQUIRE(crashes == int(lab.lost_lists.size()));
    CHECK_FALSE(lab.loaded_again);
    std::set<std::int64_t> lost;
    for (const auto& [path, list] : lab.lost_lists) lost.insert(path);
    for (const path_report_t& r : lab.all(channels::kPathReport))
      CHECK(Outcome(r.outcome) == (lost.contains(r.path) ? Outcome::kUnknown : Outcome::kDone));
  }
}

TEST_CASE("a valve that fired too little stops the open loop for the operator, and the closed loop goes on") {
  for (const bool open_loop : {true, false}) {
    Experiment e = small_ice();
    if (open_loop) e.control.scheme = "open_loop";
    FakeIceLab lab(7, e);
    lab.fires = 3;
    lab.print(0.0, false);
    CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) ==
          (open_loop ? RunOutcome::kWaitsForOperator : RunOutcome::kFinished));
    CHECK(last_fault(lab).find("fired 3 of 10 pulses") != std::string::npos);
  }
}

TEST_CASE(
    "with ice.map_table the bare table is measured before anything is deposited, however often the print "
    "crashes") {
  int resumes = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    Experiment e = small_ice(seed % 4 ? "smf" : "open_loop");
    e.ice.map_table = "on";
    FakeIceLab lab(seed, e);
    lab.accept_doubt = true;
    resumes += lab.print(seed % 3 ? 0.06 : 0.0);
    check_interlocks(lab);
    CHECK(lab.table_maps >= 1);
    bool mapped = false;
    for (const auto& s : lab.sent) {
      if (s.channel == "LASER_COMMAND") mapped = true;
      if (s.channel == "VALVE_A_COMMAND" || s.channel == "VALVE_B_COMMAND") REQUIRE(mapped);
    }
    for (const auto& [where, times] : lab.runs) REQUIRE(times <= 1);
    for (const path_report_t& r : lab.all(channels::kPathReport)) CHECK(r.layer > 0);
    const auto metrics = lab.all(channels::kLayerMetrics);
    REQUIRE(metrics.size() >= 3);
    CHECK(metrics.front().layer == 2);
    CHECK(metrics.back().layer == 6);
  }
  CHECK(resumes > 60);
  Experiment e = small_ice();
  e.ice.map_table = "on";
  FakeIceLab dark(1, e);
  dark.dark_maps = 10;
  CHECK(dark.print(0.0, false) == -1);
  CHECK(last_fault(dark).find("height map of layer 0") != std::string::npos);
  CHECK(dark.runs.empty());
}

TEST_CASE(
    "a path in doubt stops the open loop for the operator, whose word lets it go on, and feedback needs no "
    "word") {
  int asked = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    FakeIceLab lab(seed, small_ice("open_loop"));
    lab.accept_doubt = true;
    lab.print(0.06);
    for (const auto& [where, times] : lab.runs) REQUIRE(times <= 1);
    FakeIceLab alone(seed, small_ice("open_loop"));
    std::int32_t incarnation = 0;
    alone.begin(0);
    for (int guard = 0; guard < 3000 && !alone.over() && incarnation < 40; ++guard) {
      if (alone.serve(0.06) || alone.seen < alone.sent.size()) continue;
      if (alone.is_stopped()) {
        if (RunOutcome(alone.last(channels::kRunEnd).outcome) == RunOutcome::kWaitsForOperator) {
          ++asked;
          CHECK(alone.last(channels::kRunEnd).reason.find("--accept-doubt") != std::string::npos);
          break;
        }
        alone.begin(++incarnation);
        if (alone.seen == alone.sent.size()) alone.wake();
      } else {
        REQUIRE(alone.wake());
      }
    }
  }
  CHECK(asked > 10);
}

TEST_CASE(
    "I13: a map of which the laser saw too little is measured once more, then the print stops and says so",
    "[I13]") {
  FakeIceLab once(3, small_ice());
  once.dark_maps = 1;
  REQUIRE(once.print(0.0) == 0);
  CHECK(once.all(channels::fault(NodeId::kScheduler)).size() == 1);
  CHECK(once.all(channels::kLayerMetrics).front().attempt == 1);
  FakeIceLab dark(3, small_ice());
  dark.dark_maps = 1000;
  REQUIRE(dark.print(0.0, false) == -1);
  CHECK(dark.maps == 2);
  CHECK(last_fault(dark).find("the laser has measured 0.5") != std::string::npos);
  CHECK(dark.last(channels::fault(NodeId::kScheduler)).code == 13);
}

TEST_CASE(
    "I6: a nozzle that would scrape is raised and the surface measured anew, and if it still would, the "
    "print stops",
    "[I6]") {
  FakeIceLab debris(5, small_ice());
  debris.high_maps = 1;
  REQUIRE(debris.print(0.0) == 0);
  CHECK(debris.last(channels::fault(NodeId::kScheduler)).code == 6);
  check_interlocks(debris);
  for (const auto& [where, times] : debris.runs) CHECK(times == 1);
  FakeIceLab high(5, small_ice());
  high.high_maps = 1000;
  REQUIRE(high.print(0.0, false) == -1);
  CHECK(last_fault(high).find("under the nozzle") != std::string::npos);
  for (const path_report_t& r : high.all(channels::kPathReport))
    CHECK(r.layer <= 2);  // nothing above the first interval
}

TEST_CASE("I6: in the ice lab too a cell without a height counts as high where the nozzle sweeps", "[I6]") {
  FakeIceLab once(5, small_ice());
  once.blind_maps = 1;
  REQUIRE(once.print(0.0) == 0);
  CHECK_THAT(last_fault(once), Catch::Contains("1 cells of the map have no height"));
  FakeIceLab blind(5, small_ice());
  blind.blind_maps = 1000;
  REQUIRE(blind.print(0.0, false) == -1);
  CHECK(blind.last(channels::fault(NodeId::kScheduler)).code == 6);
  for (const path_report_t& r : blind.all(channels::kPathReport)) CHECK(r.layer <= 2);
}

TEST_CASE("I7: two paths in a row that take longer than planned stop the print", "[I7]") {
  FakeIceLab lab(5, small_ice());
  lab.slip_us = 20'000;
  REQUIRE(lab.print(0.0, false) == -1);
  CHECK(lab.last(channels::fault(NodeId::kScheduler)).code == 7);
  CHECK(lab.runs.size() == 2);
}

TEST_CASE("I8: a path out of reach is refused before anything moves", "[I8]") {
  FakeIceLab lab(5, small_ice());
  lab.refuse_path = true;
  REQUIRE(lab.print(0.0, false) == -1);
  CHECK(last_fault(lab).find("point 3 is out of reach") != std::string::npos);
  CHECK(lab.runs.empty());
}

TEST_CASE("I10: one heater may fail, both may not, nor may the tip be cold", "[I10]") {
  FakeIceLab lab(5, small_ice());
  lab.begin(0);
  for (int n = 0; n < 8; ++n) lab.serve(0.0);
  lab.warm(15.0, 2, 0);
  lab.warm(15.0, 2, 0);
  REQUIRE(lab.all(channels::fault(NodeId::kScheduler)).size() == 1);
  CHECK(last_fault(lab).find("(b) alone") != std::string::npos);
  CHECK(lab.all(channels::kRunEnd).empty());
  const bool both_fail = GENERATE(true, false);
  if (both_fail)
    lab.warm(12.0, 2, 2);
  else
    lab.warm(4.0, 2, 0);  // cold
  CHECK(last_fault(lab).find("valves freeze") != std::string::npos);
  CHECK(lab.last(channels::fault(NodeId::kScheduler)).code == 10);
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kStoppedSafely);
}

TEST_CASE(
    "A material that rose by less than ice.least_rise_share of its interval stops the print by its valve's "
    "name") {
  const auto stopped = [](double share, double rise) {
    Experiment e = small_ice();
    e.ice.least_rise_share = share;
    FakeIceLab lab(6, e);
    lab.rise = rise;
    const bool stop = lab.print(0.0, false) == -1;
    if (stop) {
      CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kWaitsForOperator);
      CHECK_THAT(lab.last(channels::kRunEnd).reason, Catch::Contains("valve_a gives nothing"));
    }
    return stop;
  };
  CHECK(Experiment().ice.least_rise_share == 0.3);
  CHECK(stopped(0.3, 0.29));
  CHECK_FALSE(stopped(0.3, 0.31));
  CHECK(stopped(0.6, 0.59));
  CHECK_FALSE(stopped(0.6, 0.61));
  CHECK_FALSE(stopped(0.0, 0.01));
}

TEST_CASE("a valve that gives too much in two intervals in a row stops the print by its name") {
  const auto ended = [](double rise) {
    FakeIceLab lab(6, small_ice());
    lab.rise = rise;
    lab.print(0.0, false);
    return lab.last(channels::kRunEnd).reason;
  };
  CHECK_THAT(ended(4.2), Catch::Contains("valve_a gives too much"));
  CHECK(ended(1.5).find("too much") == std::string::npos);
}

TEST_CASE("I12: a surface that rises between two measurements with nothing to deposit stops the print",
          "[I12]") {
  const auto ended = [](double creep_mm, double min_share) {
    Experiment e = small_ice();
    e.ice.least_rise_share = min_share;
    FakeIceLab lab(5, e);
    lab.high_maps = 2;  // the first interval seems to scrape: the arm is raised, the surface measured again
    lab.creep_mm = creep_mm;
    CHECK(lab.print(0.0, false) == -1);
    const auto fault = lab.last(channels::fault(NodeId::kScheduler));
    CHECK(fault.severity == std::int8_t(Severity::kStop));
    return std::pair(fault.code, fault.text);
  };
  const auto [code, text] = ended(0.1, 0.3);
  CHECK(code == 12);
  CHECK_THAT(text, Catch::Contains("rise without command") && Catch::Contains("0.1"));
  CHECK(ended(0.05, 0.3).first == 6);
  CHECK(ended(0.1, 0.0).first == 6);
  CHECK(ended(-0.1, 0.3).first == 6);
}

TEST_CASE("I12: a surface that was touched while the print was stopped is no leak", "[I12]") {
  FakeIceLab lab(5, small_ice());
  lab.high_maps = 1000;
  lab.creep_mm = 0.5;
  lab.begin(0);
  const auto raised = [&] {
    const auto faults = lab.all(channels::fault(NodeId::kScheduler));
    return !faults.empty() && faults.back().code == 6;
  };
  while (!raised() && lab.serve(0.0)) {
  }
  REQUIRE(raised());
  lab.crash();
  lab.begin(1);
  while (lab.serve(0.0)) {
  }
  CHECK(lab.last(channels::fault(NodeId::kScheduler)).code == 6);
}

TEST_CASE("a controller that gives up stops the print by its own words") {
  FakeIceLab lab(5, small_ice());
  lab.stop_controller = true;
  REQUIRE(lab.print(0.0, false) == -1);
  CHECK(lab.last(channels::kRunEnd).reason == "saturated in 3 intervals");
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kWaitsForOperator);
}

}  // namespace
}  // namespace firn
