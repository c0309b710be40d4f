#include <sys/socket.h>

#include <catch2/catch.hpp>
#include <thread>

#include "firn/fault_t.hpp"
#include "procs/recorder/recorder.h"
#include "runs/folder/log_repair.h"
#include "runtime/control_line.h"
#include "runtime/transport_wire.h"
#include "tests/runtime/process_nodes.h"

using namespace firn;
using namespace firn::test;

namespace {

ProcessOptions options(const RunDir& dir, NodeId node) {
  ProcessOptions o;
  o.node = node;
  o.run_dir = dir.path;
  o.run_id = 5;
  o.epoch_ns = monotonic_ns();
  return o;
}

std::vector<std::int64_t> logged(const RunDir& dir, std::string_view channel) {
  const record::EventLogFile file(dir.path / "log.lcm");
  auto reader = file.reader();
  std::vector<std::int64_t> seqs;
  while (const auto event = reader.next())
    if (event->channel == channel) seqs.push_back(wire::read_header(event->data)->seq);
  CHECK(reader.damage().count() == 0);
  return seqs;
}

/// A write-ahead file of a node that has sent `n` commands.
void write_commands(const RunDir& dir, int n) {
  WalFile file(dir.path / "nodes" / "scheduler.wal", false);
  std::vector<std::byte> head;
  encode_head({"scheduler", 5, 0, "commit", "", "[run]", "", {}}, head);
  file.append(WalKind::kHead, head);
  NodeHost host(NodeId::kScheduler, std::make_unique<Commander>(n), 5, &file);
  Event e;
  e.kind = EventKind::kStart;
  host.step(e);
  for (int k = 0; k < n; ++k) {
    e.kind = EventKind::kWake;
    e.now = host.next_timer()->at;
    e.due = e.now;
    host.step(e);
  }
}

/// Returns the number of messages that the log had lost.
std::size_t repaired(const RunDir& dir) {
  const record::RepairReport report = runs::repair_from_write_ahead(dir.path / "log.lcm", dir.path / "nodes");
  return report.inserted + report.replaced;
}

}  // namespace

TEST_CASE("a log that lacks everything is filled from the write-ahead files, once") {
  RunDir dir;
  write_commands(dir, 20);
  CHECK(repaired(dir) == 21);  // the commands and CONFIG_SCHEDULER
  std::vector<std::int64_t> all;
  for (std::int64_t seq = 1; seq <= 20; ++seq) all.push_back(seq);
  CHECK(logged(dir, "JET_COMMAND") == all);
  CHECK(logged(dir, "CONFIG_SCHEDULER") == std::vector<std::int64_t>{1});
  CHECK(repaired(dir) == 0);
}

TEST_CASE("the recorder writes what a sender publishes over a bad network, each message once and in order") {
  RunDir dir;
  Hub hub;
  int pair[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) == 0);
  ControlLine control(pair[0]);
  std::thread recorder([&] {
    Hub::Member bus(hub);
    ProcessOptions o = options(dir, NodeId::kRecorder);
    o.control_fd = pair[1];
    o.faults = {0.2, 0.1, 0.2, 0.1, 0.005, 4, 0, 0};
    CHECK(Recorder(o, bus).run() == 0);
  });
  while (!control.next()) std::this_thread::yield();
  {
    Hub::Member bus(hub);
    Station station(options(dir, NodeId::kLauncher), bus,
                    [](const ChannelInfo&, std::span<const std::byte>) {});
    station.join();
    for (int n = 0; n < 300; ++n) {
      fault_t f{};
      f.text.assign(n % 50 == 0 ? 100'000 : 100, 'x');  // some go as tiles
      station.send(channels::fault(NodeId::kLauncher), f);
      station.service();
    }
    for (const std::int64_t until = monotonic_us() + 1'500'000; monotonic_us() < until; ::usleep(200))
      station.service();
  }
  control.say("STOP");
  recorder.join();
  std::vector<std::int64_t> all;
  for (std::int64_t seq = 1; seq <= 300; ++seq) all.push_back(seq);
  CHECK(logged(dir, "FAULT_LAUNCHER") == all);
  CHECK(repaired(dir) == 0);
}

TEST_CASE("a station that comes back goes on numbering where it was") {
  RunDir dir;
  Hub hub;
  for (std::int32_t incarnation = 0; incarnation < 3; ++incarnation) {
    Hub::Member bus(hub);
    ProcessOptions o = options(dir, NodeId::kLauncher);
    o.incarnation = incarnation;
    o.offset_us = incarnation * 1'000'000;  // as the launcher does: behind all earlier times
    Station station(o, bus, [](const ChannelInfo&, std::span<const std::byte>) {});
    station.send(channels::fault(NodeId::kLauncher), fault_t{});
    const auto last = station.transport().last_sent();
    REQUIRE(last.size() == 1);
    CHECK(last[0].seq == incarnation + 1);
  }
  CHECK(repaired(dir) == 3);
  CHECK(logged(dir, "FAULT_LAUNCHER") == std::vector<std::int64_t>{1, 2, 3});
}
