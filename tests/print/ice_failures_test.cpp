// Failures while a whole ice part is printed, through the real drivers and the twins' bytes: the print ends
// safely and names the cause.
#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <optional>

#include "cli/print_command.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "firn/laser_command_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/pulse_list_t.hpp"
#include "print/labs/full_product.h"
#include "tests/print/ice_runs.h"
#include "tests/support/long_cases.h"

using namespace firn;
using namespace firn::test;

namespace {

using Catch::Contains;

struct Fault {
  std::string what, mended, name;
};
/// Of the rest all or one (tests/support/long_cases.h).
std::vector<Fault> stories(std::vector<Fault> some, const std::vector<Fault>& rest) {
  for (const Fault& fault : long_cases(rest, 1)) some.push_back(fault);
  return some;
}

/// Paths with that signal, in a print of which nothing fails.
std::vector<robot_command_t> calm(int signals) {
  static const std::vector<robot_command_t>& all = *new auto([] {
    IceRun run;
    REQUIRE(run.go().result.status == 0);
    return run.runs(kSignalValveA | kSignalValveB | kSignalLaser);
  }());
  std::vector<robot_command_t> some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some),
               [&](const robot_command_t& c) { return (c.signals & signals) != 0; });
  return some;
}

/// When the n-th of them is well under way.
double during(int signals, std::size_t n) { return double(calm(signals).at(n).header.utime_us) * 1e-6 + 2.0; }

std::string at(double s, const std::string& what) { return std::to_string(s) + " " + what; }

/// Stops by name, safely; its record holds.
void check_stopped(IceRun& run, const LabRunReport& report, const std::string& name) {
  INFO(report.result.reason << "\n" << run.faults());
  CHECK(report.result.status == kSafetyStop);
  CHECK_THAT(report.result.reason + run.faults(), Contains(name));
  run.check_safe();
  check_replay(run.path());
  check_audit(run.path());
}

/// And is printed to its end when the cause is gone.
void check_goes_on(IceRun& run, const LabRunReport& stopped, const std::vector<std::string>& mended) {
  std::vector<std::string> faults;
  for (const std::string& m : mended) faults.push_back(at(double(stopped.now_us) * 1e-6, m));
  const LabRunReport report = run.go(faults, true);
  INFO(report.result.reason << "\n" << run.faults());
  CHECK(report.result.status == 0);
  check_replay(run.path());
  CHECK(check_audit(run.path()).finished);
}

}  // namespace

TEST_CASE(
    "A laser that sees nothing: the map is rejected, the surface measured once more, then the print stops by "
    "name") {
  IceRun run;
  const LabRunReport report = run.go({"1 laser_point trip 1"});
  check_stopped(run, report, "the laser has measured 0.0");
  std::set<std::int64_t> scans;
  runs::RunReader(run.path())
      .each<laser_command_t>(channels::kLaserCommand.name,
                             [&](const laser_command_t& c) { scans.insert(c.scan_id); });
  CHECK(scans.size() == 2);
  check_goes_on(run, report, {"laser_point trip 0"});
}

TEST_CASE("A laser that is blind for a third of a map: measured once more, and the print goes on") {
  const double first = double(calm(kSignalLaser).front().header.utime_us) * 1e-6;
  IceRun run;
  const LabRunReport report =
      run.go({at(first, "laser_point trip 1"), at(first + 7.0, "laser_point trip 0")});
  INFO(report.result.reason << "\n" << run.faults());
  CHECK(report.result.status == 0);
  CHECK_THAT(run.faults(), Contains("measuring again"));
  check_replay(run.path());
  CHECK(check_audit(run.path()).finished);
}

TEST_CASE(
    "A nozzle that would scrape: the arm is raised and the surface measured anew once, then the path is "
    "refused by name") {
  IceRun run({"plant.ice.laser_dz_mm=-0.8", "ice.nozzle_gap_mm=0.8",
              "ice.clearance_mm=0.7"});  // the laser has slipped
  const LabRunReport report = run.go();
  CHECK_THAT(run.faults(), Contains("raising and measuring again"));
  check_stopped(run, report, "under the nozzle");
}

TEST_CASE(
    "A path of more pulses than the valve's controller holds is run list by list, and the part is as good") {
  IceRun run({"ice.max_pulses=60"});
  const LabRunReport report = run.go();
  INFO(report.result.reason);
  CHECK(report.result.status == 0);
  int most = 0, lists = 0;
  runs::RunReader(run.path()).each<pulse_list_t>(channels::kPulseList.name, [&](const pulse_list_t& l) {
    most = std::max(most, int(l.n));
    lists = std::max(lists, int(l.lists));
  });
  CHECK(most <= 60);
  CHECK(lists > 1);
  check_replay(run.path());
  const replay::AuditVerdict audit = check_audit(run.path());
  CHECK(audit.finished);
  CHECK(audit.fired == audit.commanded);
}

TEST_CASE(
    "An empty tank or a blocked line stops the print at the next map by name, and it goes on when that is "
    "mended") {
  const auto [fault, mended, name] =
      GENERATE(from_range(stories({{"valve_a trip 1", "valve_a trip 0", "valve_a gives nothing"},
                                   {"valve_b trip 2", "valve_b trip 0", "valve_b gives nothing"}},
                                  {{"valve_a trip 2", "valve_a trip 0", "valve_a gives nothing"},
                                   {"valve_b trip 1", "valve_b trip 0", "valve_b gives nothing"},
                                   {"valve_a trip 3", "valve_a trip 0", "valve_a gives nothing"}})));
  CAPTURE(fault);
  IceRun run;
  const LabRunReport report = run.go({at(1, fault)});
  check_stopped(run, report, name);
  CHECK(report.result.layers == 5);  // not after three saturated intervals
  const LabRunReport resumed = run.go({at(double(report.now_us) * 1e-6, mended)}, true);
  INFO(resumed.result.reason);
  CHECK(resumed.result.layers == 15);
  CHECK(resumed.result.status != kSafetyStop);
  check_replay(run.path());
  check_audit(run.path());
}

TEST_CASE("I12: a valve that stays open stops the print within two intervals, by name", "[I12]") {
  IceRun run;
  const LabRunReport report = run.go({at(during(kSignalValveA, 1), "valve_a trip 6")});
  INFO(report.result.reason << "\n" << run.faults());
  check_stopped(run, report, "stays open");
  CHECK(report.result.layers <= 10);
}

TEST_CASE(
    "A print whose last interval got nothing has run to its end, but is no success and not to be resumed") {
  IceRun run;
  const LabRunReport report =
      run.go({at(during(kSignalValveA, calm(kSignalValveA).size() * 2 / 3 + 1), "valve_a trip 1")});
  INFO(report.result.reason);
  CHECK(report.result.layers == 15);
  CHECK(report.result.status == kOutOfTolerance);
  CHECK(report.result.outcome == "out of tolerance");
  CHECK_THAT(report.result.reason, Contains("the last layer is printed, but"));
  check_replay(run.path());
  CHECK(check_audit(run.path()).finished);
  PrintOptions o;
  o.resume = run.path().string();
  o.bus = "in-process";
  CHECK_THROWS_WITH(run_print(full_product(), o), Contains("this run has finished"));
}

TEST_CASE(
    "Heater (a) fails: (b) alone keeps the valves warm and the print is finished, and both fail: the valves "
    "freeze, named stop") {
  IceRun one;
  const LabRunReport warm = one.go({"60 heater trip 1"});
  INFO(warm.result.reason << "\n" << one.faults());
  CHECK(warm.result.status == 0);
  CHECK_THAT(one.faults(), Contains("(b) alone keeps the valves warm"));
  check_replay(one.path());
  check_audit(one.path());

  IceRun both;
  const LabRunReport cold = both.go({"60 heater trip 1", "61 heater trip 2"});
  check_stopped(both, cold, "the valves freeze");
}

TEST_CASE("A part out of the arm's reach is refused before there is a run, by layer, path and point") {
  const Scratch scratch("ice-reach");
  const SmallIce s = small_ice_part({"ice.origin_x_mm=580"});
  PrintOptions o;
  o.bus = "in-process";
  o.runs = (scratch / "runs").string();
  CHECK_THROWS_AS(print_experiment(full_product(), s.experiment, s.inputs, o), UsageError);
  CHECK_THROWS_WITH(print_experiment(full_product(), s.experiment, s.inputs, o),
                    Contains("out of reach, nothing is printed: layer 1, deposition path"));
  CHECK_FALSE(std::filesystem::exists(scratch / "runs"));
}

TEST_CASE(
    "A robot that faults, is stopped by its button or loses its link in a path: valves shut, named, "
    "resumed") {
  const auto [kind, mended, name] = GENERATE(from_range(stories(
      {{"robot trip 2", "robot trip 0", "motion error"}, {"robot hang", "robot resume", "robot: link lost"}},
      {{"robot trip 1", "robot trip 0", "emergency stop"},
       {"robot close", "robot trip 0", "robot: link lost"},
       {"robot reboot", "robot trip 0", "robot"}})));
  CAPTURE(kind);
  IceRun run;
  const LabRunReport report = run.go({at(during(kSignalValveA, 4), kind)});
  check_stopped(run, report, name);
  check_goes_on(run, report, {mended});
}

TEST_CASE(
    "An emergency stop holds until the button is out and the operator resumes: neither alone clears it, and "
    "no valve opens before",
    "[I1]") {
  IceRun run;
  const double pressed_s = during(kSignalValveA, 4);
  const LabRunReport report = run.go({at(pressed_s, "robot trip 1"), at(pressed_s + 1.0, "robot trip 0")});
  check_stopped(run, report, "emergency stop");
  const auto fired = [&] { return plant::read_history(run.world_record()).firings.size(); };
  const std::size_t before = fired();

  const LabRunReport held = run.go({at(double(report.now_us) * 1e-6, "robot trip 1")}, true);
  check_stopped(run, held, "the emergency stop is still pressed");
  CHECK(fired() == before);

  check_goes_on(run, held, {"robot trip 0"});
  CHECK(fired() > before);
}

TEST_CASE("A valve that loses its link or its list in a path: closed, the arm braked, named, resumed") {
  const auto [kind, mended, name] = GENERATE(from_range(stories(
      {{"valve_a hang", "valve_a resume", "valve_a"}},
      {{"valve_a close", "valve_a trip 0", "valve_a"}, {"valve_a reboot", "valve_a trip 0", "valve_a"}})));
  CAPTURE(kind);
  IceRun run;
  const LabRunReport report = run.go({at(during(kSignalValveA, 4), kind)});
  check_stopped(run, report, name);
  check_goes_on(run, report, {mended});
}

TEST_CASE("A stop in a path closes the valves before the arm halts, then raises the arm by 10 mm") {
  // A relay that sticks: too hot, a good while later. The first of these that stops the arm in a path whose
  // list is not used up, and not on the way to one.
  std::optional<IceRun> last;
  plant::WorldHistory world;
  const auto& robot = world.devices;
  const auto stop = [&] {
    return std::find_if(robot.begin(), robot.end(),
                        [](const auto& d) { return d.event == plant::DeviceEvent::kRobotBraked; });
  };
  for (const char* from_s :
       {"60", "61", "62.5", "64", "67", "60.4", "61.8", "63.2", "65", "66", "68.1", "69.3"}) {
    last.emplace();
    last->go({std::string(from_s) + " heater trip 7"});
    world = plant::read_history(last->world_record());
    if (stop() != robot.end() && stop()->value > 0 && world.firings.back().end != plant::FiringEnd::kThrough)
      break;
  }
  IceRun& run = *last;
  INFO(run.faults());
  const auto braked = stop();
  REQUIRE(braked != robot.end());
  REQUIRE(braked->value > 0);
  CHECK(world.firings.back().end != plant::FiringEnd::kThrough);
  CHECK(world.firings.back().end_us <= braked->t_us);
  const auto raise = std::find_if(braked, robot.end(),
                                  [](const auto& d) { return d.event == plant::DeviceEvent::kRobotMotion; });
  REQUIRE(raise != robot.end());
  CHECK(raise->value == 0);
  CHECK(raise->t_us > braked->t_us);
  double path_z_mm = 0.0;
  runs::RunReader(run.path()).each<path_job_t>(channels::kPathJob.name, [&](const path_job_t& j) {
    if (j.path == braked->value) path_z_mm = j.z_mm;
  });
  CHECK(run.world_at_end().ice()->ice_truth().pose.z_mm == Approx(path_z_mm + 10.0).margin(0.1));
  run.check_safe();
  check_replay(run.path());
  check_audit(run.path());
}

TEST_CASE("firn print refuses a speedup above ten with the hint, and a fault that is none") {
  PrintOptions o;
  o.experiment = std::string(FIRN_SOURCE_DIR) + "/experiments/ice-small.toml";
  o.speedup = 11.0;
  CHECK_THROWS_WITH(run_print(full_product(), o),
                    Contains("1 to 10 times as fast as the clock") && Contains("--bus in-process"));
  o.speedup = 0.0;
  o.bus = "in-process";
  for (const char* fault : {"valve_a trip", "10 valve_c trip 1", "10 valve_a melt", "10 valve_a trip one",
                            "10 valve_a trip 1 2 3"}) {
    o.faults = {fault};
    CHECK_THROWS_WITH(run_print(full_product(), o), Contains("--fault") && Contains(fault));
  }
}
