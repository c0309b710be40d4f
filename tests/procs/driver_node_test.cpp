// The shells of the instruments, with instruments played by the test at byte level.
#include <catch2/catch.hpp>
#include <map>

#include "core/grid/random.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "firn/fault_t.hpp"
#include "procs/jet/node.h"
#include "procs/lamp/node.h"
#include "procs/laser_profiler/node.h"
#include "procs/stage/node.h"
#include "runtime/node_host.h"

using namespace firn;

namespace {

template <class Message>
Message decode(std::span<const std::byte> bytes) {
  Message m;
  REQUIRE(m.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()));
  return m;
}

class Sink final : public WalSink {
 public:
  void append(WalKind, std::span<const std::byte>) override {}
  void sync() override { ++syncs; }
  int syncs = 0;
};

struct TakesRowsAlone {
  void on_measured(drivers::ProfileRow&, Time, Outbox&) {}
};

template <class Driver, class Measurement>
concept Measures = requires(drivers::Effects& fx, Measurement m) {
  fx.measured<Driver>(m);
};

// Hosts one driver node; `answer` maps the node's bytes to the instrument's immediate reply.
struct DriverNodeRig {
  Sink sink;
  NodeHost host;
  std::function<std::string(std::string_view)> answer;
  Time now{0};
  std::string written;  // all bytes that the node has written
  std::map<std::string, std::vector<std::vector<std::byte>>> sent;
  int reopens = 0;
  std::int64_t seq = 0;
  double stall_s = 0.0;           // of the disk, between a step and its bytes
  std::int64_t waiting_stop = 0;  // epoch of a SAFE_STOP that arrives in that time
  std::int64_t first_stall_us = 0;
  std::vector<Time> of_commands;  // when bytes of a command left

  DriverNodeRig(NodeId id, std::unique_ptr<Node> node) : host(id, std::move(node), 1, &sink) {}

  void give(Event e) {
    e.now = now;
    std::string to_node;
    const Outbox& out = host.step(e);
    std::string refusal;
    const std::int64_t stop = now.us >= first_stall_us ? waiting_stop : 0;
    if (now.us >= first_stall_us) now = now.after_s(stall_s);
    for (std::size_t n = 0; n < out.size(); ++n) {
      const Output o = out.at(n);
      if (o.kind == OutputKind::kSend)
        sent[std::string(o.channel)].emplace_back(o.bytes.begin(), o.bytes.end());
      if (o.kind == OutputKind::kReopen) ++reopens;
      if (o.kind != OutputKind::kWrite) continue;
      if (host.writes_need_lease()) {
        refusal = host.lease_refusal(now, stop);
        if (!refusal.empty()) continue;
        of_commands.push_back(now);
      }
      const std::string_view bytes(reinterpret_cast<const char*>(o.bytes.data()), o.bytes.size());
      written += bytes;
      if (answer) to_node += answer(bytes);
    }
    if (!refusal.empty()) {
      Event kept;
      kept.kind = EventKind::kRefused;
      kept.bytes = std::as_bytes(std::span(refusal));
      give(kept);
    }
    if (to_node.empty()) return;
    now.us += 100;
    Event io;
    io.kind = EventKind::kIo;
    io.bytes = std::as_bytes(std::span(to_node.data(), to_node.size()));
    give(io);
  }
  void start(int incarnation) {
    Event e;
    e.kind = EventKind::kStart;
    e.incarnation = incarnation;
    give(e);
    e.kind = EventKind::kLink;
    e.link = LinkState::kOpen;
    give(e);
  }
  void run_until(Time end) {
    while (const auto timer = host.next_timer()) {
      if (timer->at > end) break;
      now = std::max(now, timer->at);
      Event e;
      e.kind = EventKind::kWake;
      e.id = std::uint32_t(timer->timer);
      e.due = timer->at;
      give(e);
    }
    now = end;
  }
  void run_for(double s) { run_until(now.after_s(s)); }
  template <class Message>
  void message(const Channel<Message>& channel, Message m) {
    m.header.run_id = 1;
    if (m.header.seq == 0) m.header.seq = ++seq;
    if (m.header.utime_us == 0) m.header.utime_us = now.us;
    std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    Event e;
    e.kind = EventKind::kMessage;
    e.channel = channel.name;
    e.bytes = bytes;
    give(e);
  }
  void enable(std::int64_t epoch, double lease_s = 60.0) {
    enable_t m{};
    m.enable_epoch = epoch;
    m.enabled = 1;
    m.lease_s = lease_s;
    message(channels::kEnable, m);
  }
  void safe_stop(std::int64_t epoch) {
    safe_stop_t m{};
    m.enable_epoch = epoch;
    m.cause = "test";
    message(channels::kSafeStop, m);
  }
  template <class Message>
  std::vector<Message> all(const Channel<Message>& channel) {
    std::vector<Message> out;
    for (const auto& bytes : sent[std::string(channel.name)]) out.push_back(decode<Message>(bytes));
    return out;
  }
  std::size_t count(std::string_view text) const {
    std::size_t n = 0;
    for (std::size_t at = written.find(text); at != std::string::npos; at = written.find(text, at + 1)) ++n;
    return n;
  }
};

// A lamp that burns and is warm, whose shutter is where it was told last.
std::string lamp_answer(std::string_view bytes) {
  static bool open = false;
  std::string out;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = bytes.find('\r', at);
    const std::string_view text = bytes.substr(at, end - at - 2);
    using drivers::omnicure::frame;
    if (text == "CLS" || text == "RUN" || text == "OPN") open = text != "CLS";
    out += frame(text == "CONN"   ? "READY"
                 : text == "GTM"  ? "5"
                 : text == "VEB"  ? "10"
                 : text == "GUS"  ? open ? "22" : "18"
                 : text == "DCON" ? "CLOSED"
                                  : "Received");
    at = end + 1;
  }
  return out;
}

lamp_command_t expose(std::int64_t id, std::int64_t epoch) {
  lamp_command_t c{};
  c.command_id = id;
  c.enable_epoch = epoch;
  c.verb = 1;
  c.exposure_s = 0.5;
  c.iris_percent = 80;
  return c;
}

struct LampRig : DriverNodeRig {
  LampRig() : DriverNodeRig(NodeId::kLamp, std::make_unique<LampNode>(Experiment{})) {
    answer = lamp_answer;
    start(0);
    run_for(1.0);
    REQUIRE(states().back().state == std::int8_t(DeviceState::kSafe));
  }
  std::vector<answer_t> answers() { return all(channels::answer(NodeId::kLamp)); }
  std::vector<device_state_t> states() { return all(channels::device_state(NodeId::kLamp)); }
  std::vector<fault_t> faults() { return all(channels::fault(NodeId::kLamp)); }
};

}  // namespace

TEST_CASE("a measurement that its driver does not list, or that its node does not take, does not compile") {
  CHECK((Measures<drivers::LaserProfiler, drivers::ScanDone>));
  CHECK_FALSE((Measures<drivers::Lamp, drivers::ScanDone>));
  CHECK((TakesMeasurements<LaserProfilerNode, drivers::LaserProfiler>));
  CHECK((TakesMeasurements<TakesRowsAlone, drivers::Lamp>));
  CHECK_FALSE((TakesMeasurements<TakesRowsAlone, drivers::LaserProfiler>));
}

TEST_CASE("a command is executed once, however often it arrives, and each copy is answered alike") {
  LampRig rig;
  rig.enable(1);
  rig.message(channels::kLampCommand, expose(7, 1));
  REQUIRE(rig.answers().empty());
  rig.message(channels::kLampCommand, expose(7, 1));  // while it is being executed
  rig.run_for(2.0);
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].outcome == std::int8_t(Outcome::kDone));
  CHECK(rig.answers()[0].command_id == 7);
  rig.message(channels::kLampCommand, expose(7, 1));
  rig.message(channels::kLampCommand, expose(6, 1));
  rig.run_for(2.0);
  REQUIRE(rig.answers().size() == 2);
  CHECK(rig.answers()[1].outcome == std::int8_t(Outcome::kDone));
  CHECK(rig.count("RUN") == 1);
}

TEST_CASE("the command of a pass stands on the disk before anything leaves, and moves need not") {
  DriverNodeRig rig(NodeId::kStage, std::make_unique<StageNode>(Experiment{}));
  rig.start(0);
  rig.enable(1);
  stage_command_t c{};
  c.command_id = 1;
  c.enable_epoch = 1;
  c.verb = std::int8_t(StageVerb::kMove);
  c.speed_mm_s = 10.0;
  rig.message(channels::kStageCommand, c);
  CHECK(rig.sink.syncs == 0);
  c.command_id = 2;
  c.verb = std::int8_t(StageVerb::kPass);
  c.grid.nx = c.grid.ny = 2;
  c.grid.pitch_x_mm = c.grid.pitch_y_mm = 0.25;
  c.n = 4;
  c.fires.assign(4, 1);
  rig.message(channels::kStageCommand, c);
  CHECK(rig.sink.syncs == 1);
}

TEST_CASE("a command without a lease, of an older or of an unknown epoch is refused and nothing is sent") {
  LampRig rig;
  const std::size_t before = rig.written.size();
  rig.message(channels::kLampCommand, expose(1, 0));
  rig.enable(2);
  rig.message(channels::kLampCommand, expose(2, 1));
  rig.message(channels::kLampCommand, expose(3, 3));
  REQUIRE(rig.answers().size() == 3);
  for (const answer_t& a : rig.answers()) CHECK(a.outcome == std::int8_t(Outcome::kRefused));
  CHECK(rig.answers()[1].text.find("older") != std::string::npos);
  CHECK(rig.written.size() == before);
}

TEST_CASE("a second command while one is in progress is refused and does not disturb it") {
  LampRig rig;
  rig.enable(1);
  rig.message(channels::kLampCommand, expose(1, 1));
  rig.message(channels::kLampCommand, expose(2, 1));
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].command_id == 2);
  CHECK(rig.answers()[0].outcome == std::int8_t(Outcome::kRefused));
  rig.run_for(2.0);
  CHECK(rig.answers().back().command_id == 1);
  CHECK(rig.answers().back().outcome == std::int8_t(Outcome::kDone));
}

TEST_CASE("a lease that ends during an exposure closes the shutter by itself") {
  LampRig rig;
  rig.enable(1, 0.3);
  rig.message(channels::kLampCommand, expose(1, 1));
  rig.run_for(0.31);
  CHECK(rig.count("CLS3A\r") == 2);  // once at the connection, once now
  REQUIRE(!rig.faults().empty());
  CHECK(rig.faults().back().severity == std::int8_t(Severity::kStop));
  rig.enable(1);  // the same epoch does not bring the lease back
  rig.message(channels::kLampCommand, expose(2, 1));
  CHECK(rig.answers().back().outcome == std::int8_t(Outcome::kRefused));
}

TEST_CASE(
    "SAFE is told for the new epoch only when the shutter has answered, and told again when it is asked "
    "again") {
  LampRig rig;
  rig.enable(1);
  rig.message(channels::kLampCommand, expose(1, 1));
  rig.answer = nullptr;
  rig.safe_stop(2);
  CHECK(rig.written.ends_with("CLS3A\r"));
  for (const device_state_t& s : rig.states()) CHECK(s.enable_epoch < 2);
  rig.answer = lamp_answer;
  const std::string received = lamp_answer("CLS3A\r");
  Event e;
  e.kind = EventKind::kIo;
  e.bytes = std::as_bytes(std::span(received.data(), received.size()));
  rig.give(e);
  REQUIRE(rig.states().back().enable_epoch == 2);
  CHECK(rig.states().back().state == std::int8_t(DeviceState::kSafe));
  const std::size_t told = rig.states().size();
  rig.safe_stop(2);
  CHECK(rig.states().size() == told + 1);
  CHECK(rig.states().back().enable_epoch == 2);
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].outcome != std::int8_t(Outcome::kDone));
}

TEST_CASE("after a resume the unfinished exposure is answered under its own id, and it is not begun again") {
  LampRig rig;
  rig.enable(1);
  rig.message(channels::kLampCommand, expose(5, 1));
  rig.run_for(0.1);
  rig.start(1);  // the process died and its write-ahead file was replayed
  rig.run_for(3.0);
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].command_id == 5);
  CHECK(rig.answers()[0].outcome == std::int8_t(Outcome::kUnknown));
  CHECK(rig.count("RUN") == 1);
  for (const fault_t& f : rig.faults()) CHECK(f.severity < std::int8_t(Severity::kStop));
}

TEST_CASE("the end of an earlier incarnation, delivered only after the resume, does not release the lamp") {
  LampRig rig;
  rig.start(1);
  rig.run_for(3.0);
  run_end_t old{};
  old.outcome = 2;
  rig.message(channels::kRunEnd, old);  // its header says incarnation 0
  rig.enable(2);
  rig.message(channels::kLampCommand, expose(1, 2));
  rig.run_for(2.0);
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].outcome == std::int8_t(Outcome::kDone));
  CHECK(rig.count("DCON") == 0);
}

TEST_CASE("the second jet is the same node with its own port, commands and waveform") {
  Experiment e;
  const JetNode a(NodeId::kJet, e), b(NodeId::kJetB, e);
  CHECK(a.ports() == std::vector<std::string>{"jet"});
  CHECK(b.ports() == std::vector<std::string>{"jet_b"});
  const auto listens = [](const JetNode& n, std::string_view channel) {
    return std::ranges::any_of(n.routes(), [&](const Node::Route& r) { return r.channel == channel; });
  };
  CHECK(listens(a, "JET_COMMAND"));
  CHECK_FALSE(listens(a, "JET_B_COMMAND"));
  CHECK(listens(b, "JET_B_COMMAND"));
  CHECK_FALSE(listens(b, "JET_COMMAND"));
  e.jet_b.drive.dwell_v = 20.5;
  CHECK_NOTHROW(JetNode(NodeId::kJet, e));
  CHECK_THROWS_WITH(JetNode(NodeId::kJetB, e), Catch::Contains("jet_b.dwell_v"));
}

TEST_CASE(
    "bytes that a stalled disk holds back beyond the lease do not leave, and the command is answered none") {
  LampRig rig;
  rig.enable(1, 0.3);
  rig.stall_s = 1.2;
  rig.message(channels::kLampCommand, expose(7, 1));
  rig.stall_s = 0.0;
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].command_id == 7);
  CHECK(rig.answers()[0].outcome == std::int8_t(Outcome::kNone));
  CHECK(rig.answers()[0].counted == 0);
  CHECK(rig.answers()[0].text.find("lease") != std::string::npos);
  REQUIRE(!rig.faults().empty());
  CHECK(rig.faults().back().severity == std::int8_t(Severity::kStop));
  rig.run_for(10.0);
  CHECK(rig.count("RUN") == 0);
  CHECK(rig.answers().size() == 1);
  CHECK(rig.states().back().state == std::int8_t(DeviceState::kSafe));
}

TEST_CASE("a SAFE_STOP that waits while the disk is slow keeps the command's bytes back") {
  LampRig rig;
  rig.enable(1, 60.0);
  rig.stall_s = 0.05;
  rig.waiting_stop = 2;
  rig.message(channels::kLampCommand, expose(7, 1));
  rig.stall_s = 0.0;
  rig.waiting_stop = 0;
  rig.safe_stop(2);
  rig.run_for(10.0);
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].outcome == std::int8_t(Outcome::kNone));
  CHECK(rig.count("RUN") == 0);
  CHECK(rig.states().back().state == std::int8_t(DeviceState::kSafe));
  CHECK(rig.states().back().enable_epoch == 2);
}

TEST_CASE("whenever the disk stalls and for however long, no byte of a command is later than lease + 5 ms") {
  RandomStream random(4242, Purpose::kTest);
  int kept = 0, left = 0;
  for (int n = 0; n < 200; ++n) {
    LampRig rig;
    const double lease_s = 0.1 + 0.4 * random.uniform();
    rig.enable(1, lease_s);
    const Time end = rig.now.after_s(lease_s);
    rig.of_commands.clear();
    rig.first_stall_us = rig.now.after_s(random.below(2) ? 0.0 : 0.3 * random.uniform()).us;
    rig.stall_s = 0.1 + 4.9 * random.uniform();
    rig.message(channels::kLampCommand, expose(7, 1));
    rig.run_for(0.2);
    rig.stall_s = 0.0;
    rig.run_for(20.0);
    for (const Time t : rig.of_commands) REQUIRE(t <= end.after_s(0.005));
    REQUIRE(rig.answers().size() == 1);
    const auto outcome = Outcome(rig.answers()[0].outcome);
    REQUIRE(outcome != Outcome::kRefused);
    if (rig.count("RUN") == 0) REQUIRE(outcome != Outcome::kDone);
    if (outcome == Outcome::kNone) REQUIRE(rig.count("RUN") == 0);
    const bool link_given_up = rig.reopens > 0;  // answers came too late for the driver's timeouts
    REQUIRE((rig.states().back().state == std::int8_t(DeviceState::kSafe) || link_given_up));
    ++(rig.count("RUN") == 0 ? kept : left);
  }
  CHECK(kept > 20);
  CHECK(left > 20);
}

TEST_CASE("a waveform that the jet cannot take is refused before anything runs", "[I11]") {
  Experiment e;
  e.jet.dwell_v = 20.5;
  CHECK_THROWS_WITH(JetNode(NodeId::kJet, e), Catch::Contains("whole volts"));
  e.jet.dwell_v = 2000.0;
  CHECK_THROWS_WITH(JetNode(NodeId::kJet, e), Catch::Contains("dwell_v = 2000 is outside [-100, 100]"));
}

TEST_CASE("I9: nothing is exposed while the stage moves, and an exposure ends when it begins to", "[I9]") {
  LampRig rig;
  rig.enable(1);
  const auto stage = [&](DeviceState state, std::int32_t incarnation = 0) {
    device_state_t s{};
    s.header.incarnation = incarnation;
    s.node = "stage";
    s.state = std::int8_t(state);
    rig.message(channels::device_state(NodeId::kStage), s);
  };
  stage(DeviceState::kActive);
  rig.message(channels::kLampCommand, expose(1, 1));
  REQUIRE(rig.answers().size() == 1);
  CHECK(rig.answers()[0].outcome == std::int8_t(Outcome::kRefused));
  CHECK(rig.answers()[0].code == 9);
  CHECK_THAT(rig.answers()[0].text, Catch::Contains("the stage is not at the cure pose"));
  CHECK(rig.count("RUN") + rig.count("OPN") == 0);
  stage(DeviceState::kSafe);
  rig.message(channels::kLampCommand, expose(2, 1));
  rig.run_for(2.0);
  CHECK(rig.answers().back().outcome == std::int8_t(Outcome::kDone));
  CHECK(rig.faults().empty());

  rig.message(channels::kLampCommand, expose(3, 1));
  rig.run_for(0.1);
  REQUIRE(rig.count("RUN") == 2);
  const std::size_t closed = rig.count("CLS");
  stage(DeviceState::kSuspect);  // a late reply at rest is no motion
  CHECK(rig.count("CLS") == closed);
  stage(DeviceState::kActive);
  CHECK(rig.count("CLS") == closed + 1);
  rig.run_for(2.0);
  CHECK(rig.answers().back().outcome == std::int8_t(Outcome::kFailed));
  REQUIRE(!rig.faults().empty());
  CHECK(rig.faults().back().code == 9);
  CHECK(rig.faults().back().severity == std::int8_t(Severity::kStop));
}

TEST_CASE("I9: a motion whose end was told in a lost or overtaken message holds up no later exposure",
          "[I9]") {
  LampRig rig;
  rig.enable(1);
  const auto stage = [&](DeviceState state, std::int64_t seq, std::int64_t utime_us) {
    device_state_t s{};
    s.header.seq = seq;
    s.header.utime_us = utime_us;
    s.node = "stage";
    s.state = std::int8_t(state);
    rig.message(channels::device_state(NodeId::kStage), s);
  };
  const auto exposed = [&](std::int64_t id, std::int64_t utime_us) {
    lamp_command_t c = expose(id, 1);
    c.header.utime_us = utime_us;
    rig.message(channels::kLampCommand, c);
    rig.run_for(0.1);
  };
  stage(DeviceState::kActive, 1, 1000);
  exposed(1, 2000);  // the state between was lost: the scheduler knows from the stage's answer
  CHECK(rig.count("RUN") == 1);
  stage(DeviceState::kSafe, 4, 2500);
  stage(DeviceState::kActive, 3, 2600);  // overtaken
  rig.run_for(2.0);
  CHECK(rig.answers().back().outcome == std::int8_t(Outcome::kDone));
  exposed(2, 3000);
  stage(DeviceState::kActive, 5, 3001);
  rig.run_for(2.0);
  CHECK(rig.answers().back().outcome == std::int8_t(Outcome::kFailed));
}
