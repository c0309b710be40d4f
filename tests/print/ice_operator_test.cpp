// Orders of the operator to ice prints in one process.
#include <catch2/catch.hpp>

#include <limits>

#include "files/exit_codes.h"
#include "firn/control_surface_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/pulse_list_t.hpp"
#include "firn/trajectory_t.hpp"
#include "firn/valve_command_t.hpp"
#include "tests/print/ice_runs.h"

using namespace firn;
using namespace firn::test;

namespace {

OperatorOrder order(OperatorVerb verb, const std::string& key = "", const std::string& value = "") {
  return {new_order_id(), verb, key, value};
}

/// The messages of one channel, without their headers, up to a time.
template <class Message>
std::string told(const runs::RunReader& messages, std::string_view channel, std::int64_t until_us) {
  std::string all;
  messages.each<Message>(channel, [&](const Message& said) {
    if (said.header.utime_us >= until_us) return;
    Message m = said;
    m.header = {};
    std::string bytes(std::size_t(m.getEncodedSize()), '\0');
    REQUIRE(m.encode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()));
    all += bytes;
  });
  return all;
}

constexpr std::int64_t kEnd_us = std::numeric_limits<std::int64_t>::max();

/// All that was decided, planned, moved and fired, channel by channel.
std::vector<std::string> story(const std::filesystem::path& run, std::int64_t until_us = kEnd_us) {
  const runs::RunReader messages(run);
  return {told<control_surface_t>(messages, channels::kControlSurface.name, until_us),
          told<path_job_t>(messages, channels::kPathJob.name, until_us),
          told<trajectory_t>(messages, channels::kTrajectory.name, until_us),
          told<pulse_list_t>(messages, channels::kPulseList.name, until_us),
          told<robot_command_t>(messages, channels::kRobotCommand.name, until_us),
          told<valve_command_t>(messages, channels::kValveACommand.name, until_us),
          told<valve_command_t>(messages, channels::kValveBCommand.name, until_us)};
}

std::int64_t first_map_after_us(const std::filesystem::path& run, double node_s) {
  std::int64_t at_us = kEnd_us;
  runs::RunReader(run).each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    if (double(m.header.utime_us) * 1e-6 > node_s) at_us = std::min(at_us, m.header.utime_us);
  });
  return at_us;
}

/// A print that is paused at `at_s` for an hour.
LabRunReport wait_an_hour(IceRun& run, double at_s) {
  return run.go({}, false,
                {{at_s, order(OperatorVerb::kPause)}, {at_s + 3600.0, order(OperatorVerb::kContinue)}});
}

}  // namespace

// In an hour the pressure in a valve's line recovers and debris falls: the surface is another one, so that
// only the open loop, which no map changes, fires the same to the end.
TEST_CASE("an ice print in open loop that waits an hour for the operator goes on with the same bytes") {
  const std::vector<std::string> open{"control.scheme=open_loop"};
  IceRun plain(open);
  const LabRunReport all = plain.go();
  INFO(all.result.reason);
  const std::vector<std::string> wanted = story(plain.path());
  for (std::size_t n = 1; n < wanted.size(); ++n) REQUIRE(wanted[n].size() > 1000);
  for (const double share : {0.03, 0.6}) {
    IceRun paused(open);
    const LabRunReport report = wait_an_hour(paused, share * all.node_seconds);
    INFO("pause at " << share << " of " << all.node_seconds << " s: " << report.result.reason);
    CHECK(report.result.outcome == all.result.outcome);
    CHECK(report.node_seconds > 3600.0 + 0.9 * all.node_seconds);
    const std::vector<std::string> told = story(paused.path());
    for (std::size_t n = 1; n < wanted.size(); ++n) {  // all but the maps
      CAPTURE(n);
      CHECK((told[n] == wanted[n]));
    }
    check_replay(paused.path());
    check_audit(paused.path());
  }
}

TEST_CASE("an ice print under feedback that waits an hour fires the same bytes until it is measured again") {
  IceRun plain;
  const LabRunReport all = plain.go();
  REQUIRE(all.result.status == kOk);
  const double at_s = 0.5 * all.node_seconds;
  IceRun paused;
  REQUIRE(wait_an_hour(paused, at_s).result.status == kOk);
  const std::int64_t measured_us = first_map_after_us(paused.path(), at_s),
                     plain_us = first_map_after_us(plain.path(), at_s);
  REQUIRE(measured_us > std::int64_t((at_s + 3600.0) * 1e6));
  CHECK((story(paused.path(), measured_us) == story(plain.path(), plain_us)));
  check_replay(paused.path());
  check_audit(paused.path());
}

TEST_CASE("an ice print fires and moves nothing while it is paused") {
  IceRun run;
  const double pause_s = 40.0, wait_s = 900.0, slack_s = 60.0;  // a path under way is finished
  REQUIRE(run.go({}, false,
                 {{pause_s, order(OperatorVerb::kPause)}, {pause_s + wait_s, order(OperatorVerb::kContinue)}})
              .result.status == kOk);
  const plant::WorldHistory world = plant::read_history(run.world_record());
  const auto in_pause = [&](std::int64_t us) {
    return us > std::int64_t((pause_s + slack_s) * 1e6) && us < std::int64_t((pause_s + wait_s) * 1e6);
  };
  std::size_t before = 0;
  for (const plant::FiringRecord& f : world.firings) {
    CHECK_FALSE(in_pause(f.last_us));
    before += f.last_us < std::int64_t((pause_s + slack_s) * 1e6);
  }
  CHECK(before > 0);
  CHECK(before < world.firings.size());
  const std::vector<robot_command_t> runs = run.runs(~0);
  for (const robot_command_t& c : runs) CHECK_FALSE(in_pause(c.header.utime_us));
}

TEST_CASE("the operator's stop of an ice print makes the lab safe, and a resume finishes the block") {
  IceRun run;
  const LabRunReport stopped = run.go({}, false, {{120.0, order(OperatorVerb::kStop)}});
  CHECK(stopped.result.status == kSafetyStop);
  CHECK(stopped.result.reason == "stopped by the operator");
  run.check_safe();
  const LabRunReport rest = run.go({}, true);
  INFO(rest.result.reason);
  CHECK(rest.result.status == kOk);
  check_replay(run.path());
  check_audit(run.path());
}

TEST_CASE("finish-layer ends an ice print after a measured interval, and a resume prints the rest") {
  IceRun run;
  const LabRunReport early = run.go({}, false, {{120.0, order(OperatorVerb::kFinishLayer)}});
  INFO(early.result.reason);
  CHECK(early.result.outcome == "ended early");
  CHECK(early.result.layers >= 1);
  CHECK(early.result.layers < 15);
  const LabRunReport rest = run.go({}, true);
  CHECK(rest.result.status == kOk);
  CHECK(rest.result.layers == 15);
  check_replay(run.path());
  check_audit(run.path());
}
