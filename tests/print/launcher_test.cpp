#include <unistd.h>

#include <catch2/catch.hpp>
#include <set>

#include "drivers/link/driver_event.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/stage_command_t.hpp"
#include "plant/world/serve.h"
#include "plant/world/world.h"
#include "print/live/busy_machine.h"
#include "print/live/run_watch.h"
#include "print/process/bus_port.h"
#include "print/process/child_process.h"
#include "print/simulated/sim_truth.h"

using namespace firn;

namespace {

template <class Message>
void show(RunWatch& watch, const Channel<Message>& channel, const Message& m) {
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  watch.on_message(*find_channel(channel.name), bytes);
}

}  // namespace

TEST_CASE("the launcher reads the world's truth as the world writes it, and no broken line") {
  plant::Truth truth;
  truth.exposures = 3;
  truth.droplets_fired = 1234;
  truth.volume_mm3 = 0.1;
  truth.height.spec = {3, 2, 0.263256, 0.25, -0.1, 0.2};
  truth.height.cells = {0.0, 0.001, -0.002, 1e-9, 0.4, 0.1};
  const std::string line = plant::truth_line(truth);
  const auto t = parse_truth_line(line);
  REQUIRE(t);
  CHECK(t->layer == 3);
  CHECK(t->droplets_fired == 1234);
  CHECK(t->volume_mm3 == 0.1);
  CHECK(t->grid.pitch_x_mm == 0.263256);
  CHECK(t->grid.origin_y_mm == 0.2);
  REQUIRE(t->n == 6);
  for (std::size_t n = 0; n < 6; ++n) CHECK(t->height_mm[n] == float(truth.height.cells[n]));
  for (std::size_t cut = 0; cut < line.size(); cut += 7)
    if (const auto part = parse_truth_line(line.substr(0, cut))) CHECK(part->n == 6);
  CHECK_FALSE(parse_truth_line("TRUTH 1 2 3 99999999 99999999 1 1 0 0 1"));
  CHECK_FALSE(parse_truth_line("TRUTH 1 2 nan 1 1 1 1 0 0 1"));
  CHECK_FALSE(parse_truth_line("OK"));
}

TEST_CASE("two runs get two ports, and a port in use is passed over") {
  std::set<int> ports;
  for (std::int64_t run = 1'790'000'000'000'000; run < 1'790'000'000'000'020; ++run) {
    const int port = free_bus_port(run);
    CHECK(port >= kFirstBusPort);
    CHECK(port < kFirstBusPort + kBusPorts);
    ports.insert(port);
  }
  CHECK(ports.size() > 15);
}

TEST_CASE("the watch names the place and the first stop, and ignores what an earlier incarnation said") {
  RunWatch watch(1);
  CHECK(watch.place() == "before the first layer");
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kPass);
  c.layer = 7;
  c.pass_index = 0;
  show(watch, channels::kStageCommand, c);
  CHECK(watch.place() == "during layer 7, pass 1");
  fault_t f{};
  f.severity = 2;
  f.node = "stage";
  f.code = drivers::kStall;
  f.text = "following error";
  show(watch, channels::fault(NodeId::kStage), f);
  CHECK(watch.fault().empty());
  CHECK(watch.fault_code() == drivers::kNoCode);
  f.header.incarnation = 1;
  show(watch, channels::fault(NodeId::kStage), f);
  CHECK(watch.fault() == "stage: following error");
  CHECK(watch.fault_code() == drivers::kStall);
  run_end_t end{};
  show(watch, channels::kRunEnd, end);
  CHECK_FALSE(watch.end());
  end.header.incarnation = 1;
  show(watch, channels::kRunEnd, end);
  CHECK(watch.end());
}

TEST_CASE("the watch names layer and path of the ice printer, and its scans") {
  RunWatch watch(0);
  path_job_t job{};
  job.path = 12;
  job.layer = 7;
  show(watch, channels::kPathJob, job);
  CHECK(watch.place() == "before the first layer");
  robot_command_t run{};
  run.verb = 1;  // home, of no path
  show(watch, channels::kRobotCommand, run);
  CHECK(watch.place() == "before the first layer");
  run.verb = 3;
  run.path = 12;
  show(watch, channels::kRobotCommand, run);
  CHECK(watch.place() == "during layer 7, path 12");
  job.path = 13;
  job.kind = 3;
  show(watch, channels::kPathJob, job);
  run.path = 13;
  show(watch, channels::kRobotCommand, run);
  CHECK(watch.place() == "during the scan of layer 7, path 13");
  run.path = 14;
  show(watch, channels::kRobotCommand, run);
  CHECK(watch.place() == "during path 14");
}

TEST_CASE(
    "A stop because somebody came too late blames a busy computer, and what helps, no other stop does") {
  for (const char* late : {"safety: jet has sent no heartbeat for 5 periods", "the lease ended at 12.5 s",
                           "controller has been busy with one step for 31 s"}) {
    CHECK_THAT(busy_words(late, 0, 9.42, 2), Catch::Contains("busy (load 9.42 on 2 cores)") &&
                                                 Catch::Contains("rtprio") && Catch::Contains("limits.conf"));
    CHECK(busy_words(late, 0, 1.9, 2).empty());
  }
  for (const int time_limit :
       {drivers::kLinkLost, drivers::kValveLost, drivers::kTimeSlip, drivers::kLampOn}) {
    CHECK_THAT(busy_words("lamp: the shutter does not open", time_limit, 9.42, 2),
               Catch::Contains("busy (load 9.42 on 2 cores)"));
    CHECK(busy_words("lamp: the shutter does not open", time_limit, 1.9, 2).empty());
  }
  for (const char* other : {"stage: following error", "interrupted by the operator", ""})
    CHECK(busy_words(other, drivers::kStall, 9.42, 2).empty());
}

TEST_CASE("a child process that cannot start is named, and one that ends says how") {
  CHECK_THROWS_WITH(ChildProcess("x", "/nowhere/x", {}, "/dev/null"),
                    Catch::Contains("/nowhere/x: cannot be started"));
  ChildProcess three("sh", "/bin/sh", {"-c", "echo READY >&3; read line <&3; exit 3"}, "/dev/null");
  while (!three.control().next()) ::usleep(1000);
  CHECK(three.running());
  three.control().say("STOP");
  while (three.running()) ::usleep(1000);
  CHECK(to_text(*three.poll_ending()) == "exited with code 3");
  ChildProcess sleeper("sh", "/bin/sh", {"-c", "sleep 100"}, "/dev/null");
  sleeper.kill();
  while (sleeper.running()) ::usleep(1000);
  CHECK(to_text(*sleeper.poll_ending()) == "was killed by signal 9");
}
