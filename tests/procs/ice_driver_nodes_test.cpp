// The nodes of the path printer's instruments, hosted against the simulated world at byte level.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "config/machine.h"
#include "plant/world/ice_lab.h"
#include "plant/world/world.h"
#include "procs/heater/node.h"
#include "procs/laser_point/node.h"
#include "procs/robot/node.h"
#include "procs/valve/node.h"
#include "runtime/node_host.h"
#include "tests/procs/short_trajectory.h"

using namespace firn;

namespace {

class IceNodeSink final : public WalSink {
 public:
  void append(WalKind, std::span<const std::byte>) override {}
  void sync() override { ++syncs; }
  int syncs = 0;
};

/// Nodes and the world, in one time. The nodes' messages are kept by channel.
class IceNodeRig {
 public:
  IceNodeRig() : world_(config(), nullptr) {
    Experiment e;
    e.lab.kind = "ice";
    e.control.scheme = "smf";
    e.ice.mesh = e.ice.slice = e.ice.machine = "none";
    e.laser_point.sampling_us = 200;
    e.laser_point.averaging = 2;
    const std::string toml = dump(e);
    add(NodeId::kRobot, make_robot(toml, {}));
    add(NodeId::kValveA, make_valve_a(toml, {}));
    add(NodeId::kValveB, make_valve_b(toml, {}));
    add(NodeId::kLaserPoint, make_laser_point(toml, {}));
    add(NodeId::kHeater, make_heater(toml, {}));
    for (auto& [id, h] : hosts_) {
      Event start;
      start.kind = EventKind::kStart;
      give(id, start);
      open(id);
    }
    enable(1);
    run_for(3.0);  // connected and safe
  }

  template <class Message>
  void message(NodeId id, const Channel<Message>& channel, Message m) {
    m.header.run_id = 1;
    m.header.seq = ++seq_;
    m.header.utime_us = now_us;
    std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    Event e;
    e.kind = EventKind::kMessage;
    e.channel = channel.name;
    e.bytes = bytes;
    give(id, e);
  }
  void enable(std::int64_t epoch) {
    enable_t m{};
    m.enable_epoch = epoch;
    m.enabled = 1;
    m.lease_s = 60;
    for (auto& [id, h] : hosts_) message(id, channels::kEnable, m);
  }
  template <class Message>
  std::vector<Message> all(const Channel<Message>& channel) {
    std::vector<Message> out;
    for (const auto& bytes : sent_[std::string(channel.name)]) {
      Message m;
      REQUIRE(m.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()));
      out.push_back(std::move(m));
    }
    return out;
  }
  /// Sends a command with the next id and runs until it is answered.
  template <class Command>
  answer_t command(NodeId id, const Channel<Command>& channel, Command c, double limit_s = 120) {
    enable(1);
    c.command_id = ++command_;
    c.enable_epoch = 1;
    message(id, channel, c);
    const auto answered = [&] {
      const auto answers = all(channels::answer(id));
      return !answers.empty() && answers.back().command_id == command_;
    };
    REQUIRE(run(answered, limit_s));
    return all(channels::answer(id)).back();
  }
  answer_t robot(robot_command_t c) { return command(NodeId::kRobot, channels::kRobotCommand, c); }
  answer_t valve(valve_command_t c) { return command(NodeId::kValveA, channels::kValveACommand, c); }
  answer_t laser(laser_command_t c) { return command(NodeId::kLaserPoint, channels::kLaserCommand, c); }

  template <class Done>
  bool run(Done&& done, double limit_s) {
    const std::int64_t end = now_us + std::int64_t(limit_s * 1e6);
    while (!done()) {
      std::int64_t next = world_.next_event_us();
      NodeId due = NodeId::kRecorder;
      for (auto& [id, h] : hosts_)
        if (const auto timer = h->next_timer(); timer && timer->at.us < next) {
          next = timer->at.us;
          due = id;
        }
      if (next > end) {
        now_us = end;
        return done();
      }
      now_us = std::max(now_us, next);
      if (due != NodeId::kRecorder) {
        const auto timer = hosts_.at(due)->next_timer();
        Event e;
        e.kind = EventKind::kWake;
        e.id = std::uint32_t(timer->timer);
        e.due = timer->at;
        give(due, e);
        continue;
      }
      std::vector<std::pair<std::string, std::string>> arrived;
      world_.advance(now_us, [&](const plant::World::Sent& s) {
        arrived.emplace_back(s.port,
                             std::string(reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size()));
      });
      for (const auto& [port, bytes] : arrived) {
        Event e;
        e.kind = EventKind::kIo;
        e.bytes = std::as_bytes(std::span(bytes.data(), bytes.size()));
        give(find_node(port)->id, e);
      }
    }
    return true;
  }
  void run_for(double s) {
    run([] { return false; }, s);
  }

  std::int64_t now_us = 0;
  IceNodeSink sink;
  plant::World& world() { return world_; }

 private:
  static plant::WorldConfig config() {
    plant::WorldConfig c;
    c.kind = &plant::kIceWorld;
    return c;
  }
  void add(NodeId id, std::unique_ptr<Node> node) {
    hosts_[id] = std::make_unique<NodeHost>(id, std::move(node), 1, &sink);
  }
  void open(NodeId id) {
    world_.connect(info(id).name, now_us);
    Event e;
    e.kind = EventKind::kLink;
    e.link = LinkState::kOpen;
    give(id, e);
  }
  void give(NodeId id, Event e) {
    e.now = Time{now_us};
    bool reopen = false;
    const Outbox& out = hosts_.at(id)->step(e);
    for (std::size_t n = 0; n < out.size(); ++n) {
      const Output o = out.at(n);
      if (o.kind == OutputKind::kSend)
        sent_[std::string(o.channel)].emplace_back(o.bytes.begin(), o.bytes.end());
      if (o.kind == OutputKind::kWrite) world_.receive(info(id).name, o.bytes, now_us);
      reopen = reopen || o.kind == OutputKind::kReopen;
    }
    if (!reopen) return;
    world_.disconnect(info(id).name, now_us);
    open(id);
  }

  plant::World world_;
  std::map<NodeId, std::unique_ptr<NodeHost>> hosts_;
  std::map<std::string, std::vector<std::vector<std::byte>>> sent_;
  std::int64_t seq_ = 0, command_ = 0;
};

robot_command_t verb(RobotVerb v) {
  robot_command_t c{};
  c.verb = std::int8_t(v);
  return c;
}

}  // namespace

TEST_CASE("a move puts the tool's point over the part's, as the simulated arm truly stands", "[ice]") {
  IceNodeRig rig;
  REQUIRE(rig.robot(verb(RobotVerb::kHome)).outcome == std::int8_t(Outcome::kDone));
  const Machine machine;
  for (const RobotTool tool :
       {RobotTool::kFlange, RobotTool::kNozzleA, RobotTool::kNozzleB, RobotTool::kLaser}) {
    robot_command_t c = verb(RobotVerb::kMove);
    c.tool = std::int8_t(tool);
    c.x_mm = 12.0;
    c.y_mm = -7.0;
    c.z_mm = 40.0;
    c.speed_mm_s = 400.0;
    REQUIRE(rig.robot(c).outcome == std::int8_t(Outcome::kDone));
    rig.run_for(1.0);  // the cantilever rings
    const plant::ArmPose pose = rig.world().ice()->ice_truth().pose;
    const ToolConfig t = tool == RobotTool::kFlange    ? ToolConfig{}
                         : tool == RobotTool::kNozzleA ? machine.water
                         : tool == RobotTool::kNozzleB ? machine.scaffold
                                                       : machine.laser;
    const plant::ArmPose::Point at = pose.tool({t.x_mm, t.y_mm, t.z_mm});
    CHECK(std::abs(at.x_mm - 12.0) < 0.1);
    CHECK(std::abs(at.y_mm + 7.0) < 0.1);
    CHECK(std::abs(at.z_mm - 40.0) < 0.05);
  }
  robot_command_t far = verb(RobotVerb::kMove);
  far.x_mm = 500.0;
  far.speed_mm_s = 100.0;
  const answer_t refused = rig.robot(far);
  CHECK(refused.outcome == std::int8_t(Outcome::kRefused));
  CHECK(refused.code == 8);
  CHECK_FALSE(refused.text.empty());
}

TEST_CASE(
    "a deposition run: list and trajectory go ahead, the run stands on the disk first, the counts come back",
    "[ice]") {
  IceNodeRig rig;
  REQUIRE(rig.robot(verb(RobotVerb::kHome)).outcome == std::int8_t(Outcome::kDone));
  pulse_list_t list{};
  list.path = 7;
  list.lists = 1;
  list.valve = std::int8_t(ValveId::kA);
  list.tick_s = 0.002;
  list.pulse_s = 0.00125;
  for (int k = 0; k < 300; ++k) list.tick.push_back(4 * k);
  list.n = 300;
  rig.message(NodeId::kValveA, channels::kPulseList, list);
  rig.message(NodeId::kValveB, channels::kPulseList, list);
  rig.message(NodeId::kRobot, channels::kTrajectory, test::short_trajectory(7, 300));
  rig.run_for(2.0);
  valve_command_t v{};
  v.path = 7;
  v.expected = 300;
  v.verb = std::int8_t(ValveVerb::kLoad);
  CHECK(rig.valve(v).outcome == std::int8_t(Outcome::kDone));
  CHECK(rig.command(NodeId::kValveB, channels::kValveBCommand, v).outcome ==
        std::int8_t(Outcome::kRefused));  // not its list
  v.verb = std::int8_t(ValveVerb::kArm);
  const int before = rig.sink.syncs;
  CHECK(rig.valve(v).outcome == std::int8_t(Outcome::kReady));
  CHECK(rig.sink.syncs == before + 1);
  robot_command_t run = verb(RobotVerb::kRun);
  run.path = 7;
  run.signals = kSignalValveA;
  const answer_t ran = rig.robot(run);
  CHECK(rig.sink.syncs == before + 2);
  CHECK(ran.outcome == std::int8_t(Outcome::kDone));
  CHECK(ran.expected == 299 * 16'000);
  CHECK(std::abs(ran.counted - ran.expected) <= 1000);
  v.verb = std::int8_t(ValveVerb::kDisarm);
  const answer_t counted = rig.valve(v);
  CHECK(counted.outcome == std::int8_t(Outcome::kDone));
  CHECK(counted.counted == 300);
  CHECK(rig.world().ice()->ice_truth().pulses[0] == 300);
  CHECK(rig.robot(run).outcome == std::int8_t(Outcome::kRefused));
}

TEST_CASE("laser samples carry path, scan and material of the command that armed the storage", "[ice]") {
  IceNodeRig rig;
  REQUIRE(rig.robot(verb(RobotVerb::kHome)).outcome == std::int8_t(Outcome::kDone));
  rig.message(NodeId::kRobot, channels::kTrajectory, test::short_trajectory(9, 500));
  laser_command_t c{};
  c.verb = std::int8_t(LaserVerb::kArm);
  c.layer = 5;
  c.scan_id = 3;
  c.path = 9;
  c.index = 1;
  c.count = 4;
  c.material = 1;
  c.samples = 800;
  c.period_s = 0.01;
  CHECK(rig.laser(c).outcome == std::int8_t(Outcome::kReady));
  robot_command_t run = verb(RobotVerb::kRun);
  run.path = 9;
  run.signals = kSignalLaser;
  CHECK(rig.robot(run).outcome == std::int8_t(Outcome::kDone));
  laser_command_t collect{};
  collect.verb = std::int8_t(LaserVerb::kCollect);
  CHECK(rig.laser(collect).outcome == std::int8_t(Outcome::kDone));
  const std::vector<laser_samples_t> samples = rig.all(channels::kLaserSamples);
  REQUIRE(samples.size() == 1);
  CHECK(samples[0].path == 9);
  CHECK(samples[0].scan_id == 3);
  CHECK(samples[0].layer == 5);
  CHECK(samples[0].index == 1);
  CHECK(samples[0].count == 4);
  CHECK(samples[0].material == 1);
  CHECK(samples[0].period_s == 0.01);
  CHECK(std::abs(samples[0].n - 798) <= 3);
  CHECK(samples[0].distance_mm.size() == std::size_t(samples[0].n));
}

TEST_CASE("temperatures are told once a second with set points and faults", "[ice]") {
  IceNodeRig rig;
  heater_command_t c{};
  c.verb = std::int8_t(HeaterVerb::kSet);
  c.set_degC[0] = 20;
  c.set_degC[1] = 22;
  c.set_degC[2] = -100;
  CHECK(rig.command(NodeId::kHeater, channels::kHeaterCommand, c).outcome == std::int8_t(Outcome::kDone));
  rig.run_for(60.0);
  const std::vector<temperature_t> all = rig.all(channels::kTemperature);
  CHECK(all.size() >= 55);
  CHECK(all.size() <= 66);
  CHECK(all.back().set_degC[1] == 22.0);
  CHECK(std::isfinite(all.back().degC[0]));
  CHECK(all.back().fault[0] == 0);
}
