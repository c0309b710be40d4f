// Sinks that stall 0.1 to 5 s between a node's step and its bytes, with a SAFE_STOP that arrives meanwhile:
// no instrument gets a byte that makes it deposit, move, heat or shine later than its lease + 5 ms.
#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "plant/world/world.h"
#include "procs/jet/node.h"
#include "procs/lamp/node.h"
#include "procs/robot/node.h"
#include "procs/stage/node.h"
#include "procs/valve/node.h"
#include "runtime/node_host.h"
#include "tests/procs/short_trajectory.h"

using namespace firn;

namespace {

constexpr std::int64_t kLease_us = 300'000, kRenewed_us = 50'000, kGrace_us = 5'000;

struct NoSink final : WalSink {
  void append(WalKind, std::span<const std::byte>) override {}
  void sync() override {}
};

/// One node with its simulated instrument. From `stall_from_us` on, one step's bytes wait `stall_us`, and a
/// SAFE_STOP waits with them.
class Rig {
 public:
  Rig(NodeId id, const char* lab, std::unique_ptr<Node> node)
      : id_(id), host_(id, std::move(node), 1, &sink_), world_(config(lab), nullptr) {
    Event start;
    start.kind = EventKind::kStart;
    give(start);
    open();
    run_for(20.0);
  }
  template <class Message>
  void message(const Channel<Message>& channel, Message m) {
    m.header.run_id = 1;
    m.header.seq = ++seq_;
    m.header.utime_us = now_us;
    std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    Event e;
    e.kind = EventKind::kMessage;
    e.channel = channel.name;
    e.bytes = bytes;
    give(e);
  }
  /// Sends a command and runs until it is answered, or for ten seconds.
  template <class Command>
  void command(const Channel<Command>& channel, Command c) {
    c.command_id = ++command_;
    c.enable_epoch = 1;
    answered_ = false;
    message(channel, c);
    for (int n = 0; n < 100 && !answered_; ++n) run_for(0.1);
  }
  void run_for(double s) {
    const std::int64_t end = now_us + std::int64_t(s * 1e6);
    while (true) {
      const auto timer = host_.next_timer();
      const std::int64_t wake = timer ? timer->at.us : INT64_MAX;
      const std::int64_t renew = stopped_ ? INT64_MAX : lease_us_ - kLease_us + kRenewed_us;
      const std::int64_t next = std::max(now_us, std::min({wake, renew, world_.next_event_us()}));
      if (next > end) break;
      now_us = next;
      if (renew <= now_us) {
        enable_t m{};
        m.enable_epoch = m.enabled = 1;
        m.lease_s = kLease_us * 1e-6;
        lease_us_ = now_us + kLease_us;
        message(channels::kEnable, m);
      } else if (wake <= now_us) {
        Event e;
        e.kind = EventKind::kWake;
        e.id = std::uint32_t(timer->timer);
        e.due = timer->at;
        give(e);
      } else {
        hear();
      }
    }
    now_us = std::max(now_us, end);
  }

  std::int64_t now_us = 0;
  std::int64_t stall_from_us = INT64_MAX, stall_us = 0;
  std::int64_t stopped_at_us = INT64_MAX;  ///< when the SAFE_STOP arrived
  struct Write {
    std::int64_t t_us;
    std::string bytes;
  };
  std::vector<Write> writes;
  std::int64_t allowed_until_us() const { return std::min(lease_us_, stopped_at_us) + kGrace_us; }

 private:
  static plant::WorldConfig config(const std::string& lab) {
    plant::WorldConfig c;
    if (lab == "ice") c.kind = &plant::kIceWorld;
    return c;
  }
  void open() {
    world_.connect(info(id_).name, now_us);
    Event e;
    e.kind = EventKind::kLink;
    e.link = LinkState::kOpen;
    give(e);
  }
  void hear() {
    std::vector<Event> events;
    std::vector<std::string> bytes;
    world_.advance(now_us, [&](const plant::World::Sent& s) {
      if (s.port != info(id_).name) return;
      Event e;
      e.kind = s.close ? EventKind::kLink : EventKind::kIo;
      e.link = LinkState::kClosed;
      events.push_back(e);
      bytes.emplace_back(reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size());
    });
    for (std::size_t n = 0; n < events.size(); ++n) {
      events[n].bytes = std::as_bytes(std::span(bytes[n].data(), bytes[n].size()));
      give(events[n]);
    }
  }
  void give(Event e) {
    e.now = Time{now_us};
    const Outbox& out = host_.step(e);
    std::vector<std::string> written;
    bool reopen = false;
    for (std::size_t n = 0; n < out.size(); ++n) {
      const Output o = out.at(n);
      const std::string text(reinterpret_cast<const char*>(o.bytes.data()), o.bytes.size());
      if (o.kind == OutputKind::kWrite) written.push_back(text);
      reopen = reopen || o.kind == OutputKind::kReopen;
      answered_ = answered_ || (o.kind == OutputKind::kSend && o.channel.starts_with("ANSWER_"));
    }
    const bool stalls = now_us >= stall_from_us && !stopped_ && !written.empty();
    if (stalls) {
      stopped_ = true;
      stopped_at_us = now_us + stall_us / 2;
      now_us += stall_us;
    }
    std::string refusal;
    for (const std::string& bytes : written) {
      const std::string why =
          host_.writes_need_lease() ? host_.lease_refusal(Time{now_us}, stalls ? 2 : 0) : std::string();
      if (!why.empty()) {
        refusal = why;
        continue;
      }
      writes.push_back({now_us, bytes});
      world_.receive(info(id_).name, std::as_bytes(std::span(bytes)), now_us);
    }
    if (!refusal.empty()) {
      Event kept;
      kept.kind = EventKind::kRefused;
      kept.bytes = std::as_bytes(std::span(refusal));
      give(kept);
    }
    if (reopen) {
      world_.disconnect(info(id_).name, now_us);
      open();
    }
    if (!stalls) return;
    safe_stop_t stop{};
    stop.enable_epoch = 2;
    stop.cause = "test";
    message(channels::kSafeStop, stop);
  }

  NodeId id_;
  NoSink sink_;
  NodeHost host_;
  plant::World world_;
  std::int64_t seq_ = 0, command_ = 0, lease_us_ = 0;
  bool stopped_ = false, answered_ = false;
};

stage_command_t stage(StageVerb verb) {
  stage_command_t c{};
  c.verb = std::int8_t(verb);
  c.speed_mm_s = 50.0;
  c.x_mm = c.y_mm = 4.0;
  c.z_mm = 1.0;
  if (verb != StageVerb::kPass) return c;
  c.grid.nx = c.grid.ny = 4;
  c.grid.pitch_x_mm = c.grid.pitch_y_mm = 0.25;
  c.n = 16;
  c.fires.assign(16, 1);
  return c;
}

void work_stage(Rig& rig) {
  rig.command(channels::kStageCommand, stage(StageVerb::kMove));
  rig.command(channels::kStageCommand, stage(StageVerb::kPass));
  rig.command(channels::kStageCommand, stage(StageVerb::kHome));
}

void work_jet(Rig& rig) {
  for (int n = 0; n < 3; ++n)
    for (const JetVerb verb : {JetVerb::kArm, JetVerb::kDisarm}) {
      jet_command_t c{};
      c.verb = std::int8_t(verb);
      c.expected = 16;
      rig.command(channels::kJetCommand, c);
    }
}

void work_lamp(Rig& rig) {
  for (int n = 0; n < 3; ++n) {
    lamp_command_t c{};
    c.verb = std::int8_t(LampVerb::kExpose);
    c.exposure_s = 0.5;
    c.iris_percent = 80;
    rig.command(channels::kLampCommand, c);
  }
}

void work_valve(Rig& rig) {
  for (int path = 1; path <= 3; ++path) {
    pulse_list_t list{};
    list.path = path;
    list.lists = 1;
    list.valve = std::int8_t(ValveId::kA);
    list.tick_s = 0.002;
    list.pulse_s = 0.00125;
    for (int k = 0; k < 50; ++k) list.tick.push_back(4 * k);
    list.n = 50;
    rig.message(channels::kPulseList, list);
    for (const ValveVerb verb : {ValveVerb::kLoad, ValveVerb::kArm, ValveVerb::kDisarm}) {
      valve_command_t c{};
      c.verb = std::int8_t(verb);
      c.path = path;
      c.expected = 50;
      rig.command(channels::kValveACommand, c);
    }
  }
}

void work_robot(Rig& rig) {
  rig.message(channels::kTrajectory, test::short_trajectory(7, 60));
  for (const RobotVerb verb : {RobotVerb::kHome, RobotVerb::kMove, RobotVerb::kLoad, RobotVerb::kRun}) {
    robot_command_t c{};
    c.verb = std::int8_t(verb);
    c.path = 7;
    c.x_mm = 12.0;
    c.z_mm = 40.0;
    c.speed_mm_s = 200.0;
    c.signals = verb == RobotVerb::kRun ? kSignalValveA : 0;
    rig.command(channels::kRobotCommand, c);
  }
}

/// An instrument, the work that is interrupted, and the beginnings of its causes.
struct Row {
  NodeId id;
  const char* lab;
  std::unique_ptr<Node> (*make)(const std::string&, const Blobs&);
  void (*work)(Rig&);
  std::vector<std::string> acting;
};

std::vector<Row> instruments() {
  using namespace std::string_literals;
  return {
      {NodeId::kStage, "inkjet", make_stage, work_stage, {"LINEAR", "HOME", " ARM"}},
      {NodeId::kJet, "inkjet", make_jet, work_jet, {"\x53\x03\x08\x01"s}},
      {NodeId::kLamp, "inkjet", make_lamp, work_lamp, {"OPN", "RUN"}},
      {NodeId::kRobot, "ice", make_robot, work_robot, {"POWER ON", "CAL", "MOVE", "PATH RUN"}},
      {NodeId::kValveA, "ice", make_valve_a, work_valve, {"\xA5\x5A\x05"s}},
  };
}

Experiment experiment_of(const std::string& lab) {
  Experiment e;
  if (lab != "ice") return e;
  e.lab.kind = "ice";
  e.control.scheme = "smf";
  e.ice.mesh = e.ice.slice = e.ice.machine = "none";
  return e;
}

bool acts(const Row& row, const std::string& bytes) {
  return std::any_of(row.acting.begin(), row.acting.end(),
                     [&](const std::string& a) { return bytes.find(a) != std::string::npos; });
}

}  // namespace

TEST_CASE("whatever instrument a sink stalls for, nothing that makes it act leaves later than lease + 5 ms") {
  for (const Row& row : instruments()) {
    const std::string toml = dump(experiment_of(row.lab));
    const auto rig_of = [&] { return Rig(row.id, row.lab, row.make(toml, {})); };
    std::int64_t from_us = 0, to_us = 0;
    std::vector<std::int64_t> acting;
    {
      Rig rig = rig_of();
      from_us = rig.now_us;
      row.work(rig);
      to_us = rig.now_us;
      for (const Rig::Write& w : rig.writes)
        if (w.t_us >= from_us && acts(row, w.bytes)) acting.push_back(w.t_us);
    }
    CAPTURE(info(row.id).name);
    REQUIRE(!acting.empty());  // undisturbed, it acts
    RandomStream random(31, Purpose::kTest, std::uint32_t(row.id));
    for (int round = 0; round < 40; ++round) {
      Rig rig = rig_of();
      const std::size_t n = random.below(std::uint32_t(acting.size()));
      rig.stall_from_us = round % 2 == 0 ? acting[n]  // the very step
                                         : from_us + std::int64_t(random.uniform() * double(to_us - from_us));
      rig.stall_us = std::int64_t(random.uniform(0.1, 5.0) * 1e6);
      row.work(rig);
      rig.run_for(20.0);
      CAPTURE(rig.stall_from_us, rig.stall_us);
      for (const Rig::Write& w : rig.writes)
        if (acts(row, w.bytes) && w.t_us >= from_us) {
          CAPTURE(w.bytes);
          CHECK(w.t_us <= rig.allowed_until_us());
        }
    }
  }
}
