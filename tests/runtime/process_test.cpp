#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <thread>

#include "core/grid/random.h"
#include "files/digest.h"
#include "firn/journal_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "runtime/control_line.h"
#include "runtime/process.h"
#include "runtime/process_args.h"
#include "runtime/transport_wire.h"
#include "runtime/wal_file.h"
#include "tests/runtime/process_nodes.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::test;

namespace {

// The largest `now` of all events in a write-ahead file.
Time last_now(const std::filesystem::path& path) {
  const record::MappedFile mapped(path);
  record::RecordReader reader(mapped.bytes());
  Time last{-1};
  while (const auto record = reader.next())
    if (!record->damaged && record->kind == std::uint16_t(WalKind::kEvent))
      last = std::max(last, decode_event(record->payload).event.now);
  return last;
}

ProcessOptions options(const RunDir& dir, NodeId node, int control_fd, std::int32_t incarnation = 0) {
  ProcessOptions o;
  o.node = node;
  o.run_dir = dir.path;
  o.run_id = 5;
  o.incarnation = incarnation;
  o.epoch_ns = monotonic_ns();
  o.control_fd = control_fd;
  o.head = {std::string(info(node).name), 5, incarnation, "commit", "platform", "", "", {}};
  if (incarnation > 0) o.offset_us = last_now(dir.path / "nodes" / (o.head.node + ".wal")).us + 1;
  return o;
}

struct Pair {
  int fd[2];
  Pair() { REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fd) == 0); }
};

/// Waits for a line that starts with `start`; fails the test after a minute.
std::string await(ControlLine& control, const std::string& start) {
  for (int n = 0; n < 6000; ++n) {
    while (const auto line = control.next())
      if (line->starts_with(start)) return *line;
    pollfd p{control.fd(), POLLIN, 0};
    ::poll(&p, 1, 10);
  }
  FAIL("no line " << start);
  return {};
}

/// Sends all received bytes back, like an instrument; breaks the line after `most` bytes, once.
struct Instrument {
  explicit Instrument(const std::filesystem::path& path, int most) {
    listener = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un a{};
    a.sun_family = AF_UNIX;
    path.string().copy(a.sun_path, sizeof a.sun_path - 1);
    REQUIRE(::bind(listener, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0);
    REQUIRE(::listen(listener, 4) == 0);
    thread = std::thread([this, most] {
      int left = most;
      for (int fd; (fd = ::accept(listener, nullptr, nullptr)) >= 0; ::close(fd)) {
        ++connections;
        std::byte b[64];
        for (ssize_t got; (got = ::recv(fd, b, left > 0 ? std::size_t(std::min(left, 64)) : 64, 0)) > 0;) {
          if (::send(fd, b, std::size_t(got), MSG_NOSIGNAL) < 0) break;
          if (left > 0 && (left -= int(got)) == 0) break;
        }
      }
    });
  }
  ~Instrument() {
    ::shutdown(listener, SHUT_RDWR);
    thread.join();
    ::close(listener);
  }
  int listener;
  std::atomic<int> connections{0};
  std::thread thread;
};

LossyOptions bad_network() { return {0.1, 0.1, 0.1, 0.1, 0.005, 3, 0, 0}; }

}  // namespace

TEST_CASE("two processes and an instrument finish their work over a bad network, and both files replay") {
  RunDir dir;
  Instrument instrument(dir.path / "io" / "jet", 20);  // the line breaks once: the driver opens it again
  Hub hub;
  Pair a, b;
  ControlLine commander(a.fd[0]), echo(b.fd[0]);
  const auto work = [&](NodeId node, int fd, std::unique_ptr<Node> n) {
    Hub::Member bus(hub);
    ProcessOptions o = options(dir, node, fd);
    o.faults = bad_network();
    o.faults.node = std::uint32_t(node);
    return run_process(o, std::move(n), bus);
  };
  int ended_one = -1, ended_two = -1;  // Catch may be called by one thread only
  std::thread one([&] { ended_one = work(NodeId::kScheduler, a.fd[1], std::make_unique<Commander>(200)); });
  std::thread two([&] { ended_two = work(NodeId::kJet, b.fd[1], std::make_unique<Echo>()); });
  await(commander, "READY");
  await(echo, "READY");
  commander.say("START");
  echo.say("START");
  CHECK(await(commander, "FINISH") == "FINISH 0 all answered");
  commander.say("STOP done");
  one.join();
  { const ControlLine gone(std::move(echo)); }  // the launcher dies: a local stop
  two.join();
  CHECK(ended_one == 0);
  CHECK(ended_two == 0);
  CHECK(instrument.connections == 2);

  for (const NodeId id : {NodeId::kScheduler, NodeId::kJet}) {
    const std::string name(info(id).name);
    std::unique_ptr<Node> node;
    if (id == NodeId::kJet)
      node = std::make_unique<Echo>();
    else
      node = std::make_unique<Commander>(200);
    WalFile file(dir.path / "nodes" / (name + ".wal"), true);
    NodeHost host(id, std::move(node), 5, nullptr);
    std::map<std::string, std::int64_t> last;
    std::string stop_text;
    restore(host, 5, file,
            {[](const WalHead&) {},
             [&](std::string_view c, std::span<const std::byte> m) {
               if (find_channel(c)->delivery == Delivery::kReliable)
                 CHECK(wire::read_header(m)->seq == ++last[std::string(c)]);
             },
             [&](std::string_view c, std::span<const std::byte> m) {
               device_state_t s{};
               if (c == "STATE_JET" && s.decode(m.data(), 0, int(m.size())) > 0) stop_text = s.text;
             },
             [](std::string_view, std::span<const std::byte>) { FAIL("nothing was left unsent"); }});
    CHECK(last[id == NodeId::kJet ? "JET_COMMAND" : "ANSWER_JET"] == 200);
    if (id == NodeId::kJet) CHECK(stop_text == "the launcher is gone");
    std::ifstream faults(dir.path / "nodes" / (name + ".faults"));
    std::string text;
    std::getline(faults, text);
    CHECK(parse_lossy_counts(text).injected() > 0);
  }
}

TEST_CASE("a running process tells on its journal channel which step it handled last") {
  RunDir dir;
  Hub hub;
  Hub::Member watcher(hub);
  watcher.subscribe("JOURNAL_SCHEDULER");
  Pair a;
  ControlLine control(a.fd[0]);
  std::thread one([&] {
    Hub::Member bus(hub);
    CHECK(run_process(options(dir, NodeId::kScheduler, a.fd[1]), std::make_unique<Commander>(3), bus) == 0);
  });
  await(control, "READY");
  control.say("START");
  journal_t last{};
  for (int n = 0; n < 500 && last.step == 0; ++n) {
    ::usleep(10'000);
    watcher.receive(
        [&](std::string_view, std::span<const std::byte> b) { last.decode(b.data(), 0, int(b.size())); });
  }
  control.say("STOP done");
  one.join();
  CHECK(last.step > 0);
  CHECK_FALSE(last.event.empty());
}

TEST_CASE("killed at any moment, a process comes back where it was and repeats nothing") {
  constexpr int kMessages = 3000;
  RandomStream random(11, Purpose::kKill);
  RunDir dir;
  std::int32_t incarnation = 0;
  bool finished = false;
  for (; !finished && incarnation < 60; ++incarnation) {
    Pair pair;
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(pair.fd[0]);
      Hub hub;
      Hub::Member bus(hub);
      ::_exit(run_process(options(dir, NodeId::kScheduler, pair.fd[1], incarnation),
                          std::make_unique<Commander>(kMessages), bus));
    }
    ::close(pair.fd[1]);
    ControlLine control(pair.fd[0]);
    await(control, "READY");
    control.say("START");
    ::usleep(random.below(80'000));
    ::kill(child, SIGKILL);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));

    std::int64_t seq = 0;
    WalFile file(dir.path / "nodes" / "scheduler.wal", true);
    NodeHost host(NodeId::kScheduler, std::make_unique<Commander>(kMessages), 5, nullptr);
    const auto in_order = [&](std::string_view, std::span<const std::byte> m) {
      REQUIRE(wire::read_header(m)->seq == ++seq);
    };
    restore(host, 5, file,
            {[](const WalHead&) {}, [](std::string_view, std::span<const std::byte>) {}, in_order, in_order});
    finished = seq == kMessages;
    std::vector<std::byte> found;
    if (seq > 0) CHECK(find_sent(file.path(), "JET_COMMAND", seq, found));
    CHECK_FALSE(find_sent(file.path(), "JET_COMMAND", seq + 1, found));
  }
  CHECK(incarnation > 3);
}

TEST_CASE("an event that crashes the node is named, and named again when the resume meets it") {
  RunDir dir;
  Hub hub;
  Pair pair;
  ControlLine control(pair.fd[0]);
  int code = -1;
  std::thread process([&] {
    Hub::Member bus(hub);
    code = run_process(options(dir, NodeId::kScheduler, pair.fd[1]), std::make_unique<Commander>(1000), bus);
  });
  await(control, "READY");
  control.say("START");
  Hub::Member jet(hub);
  Outbox out(NodeId::kJet, 5);
  out.begin(Time{1}, 0);
  answer_t a{};
  a.text = "throw";
  out.send(channels::answer(NodeId::kJet), a);
  jet.publish("ANSWER_JET", out.at(0).bytes);
  const std::string fault = await(control, "FAULT");
  CHECK_THAT(fault, Catch::Contains("ANSWER_JET seq 1") && Catch::Contains("the commander cannot take this"));
  process.join();
  CHECK(code == kExitHandler);

  Pair again;
  ControlLine second(again.fd[0]);
  Hub::Member bus(hub);
  CHECK(run_process(options(dir, NodeId::kScheduler, again.fd[1], 1), std::make_unique<Commander>(1000),
                    bus) == kExitResume);
  CHECK_THAT(await(second, "ERROR"),
             Catch::Contains("(ANSWER_JET seq 1) crashes the node again: the commander cannot take this"));
}

TEST_CASE("a node that would answer otherwise than its file says does not come back") {
  RunDir dir;
  const auto path = dir.path / "nodes" / "scheduler.wal";
  {
    WalFile file(path, false);
    NodeHost host(NodeId::kScheduler, std::make_unique<Commander>(5), 5, &file);
    Event e;
    e.kind = EventKind::kStart;
    host.step(e);
  }
  const auto nothing = [](std::string_view, std::span<const std::byte>) {};
  {
    WalFile file(path, true);
    NodeHost host(NodeId::kScheduler, std::make_unique<Echo>(), 5, nullptr);
    CHECK_THROWS_WITH(
        restore(host, 5, file, {[](const WalHead&) {}, nothing, nothing, nothing}),
        Catch::Contains(
            "scheduler.wal: step 0 (start of incarnation 0): the outputs differ from the record"));
  }
  {
    WalFile file(path, true);
    std::vector<std::byte> head;
    encode_head({"jet", 5, 0, "", "", "", "", {}}, head);
    file.append(WalKind::kHead, head);
    NodeHost host(NodeId::kScheduler, std::make_unique<Commander>(5), 5, nullptr);
    CHECK_THROWS_WITH(restore(host, 5, file, {[](const WalHead&) {}, nothing, nothing, nothing}),
                      Catch::Contains("is of node jet in run 5, not scheduler in run 5"));
  }
}

/// A driver whose step takes long: its bytes need a lease of `lease_s` after the command.
class Slow : public Node {
 public:
  Slow(double lease_s, int step_ms) : lease_s_(lease_s), step_ms_(step_ms) {
    subscribe(channels::kJetCommand, this);
    subscribe(channels::kSafeStop, this);
  }
  std::vector<std::string> ports() const override { return {"jet"}; }
  bool writes_need_lease() const override { return true; }
  std::string lease_refusal(Time now, std::int64_t stop_epoch) const override {
    return stop_epoch > 0 ? "a stop waits" : now > until_ ? "too late" : "";
  }
  void on(const jet_command_t&, Time now, Outbox& out) {
    until_ = now.after_s(lease_s_);
    std::this_thread::sleep_for(std::chrono::milliseconds(step_ms_));
    const std::byte fire{'F'};
    out.write(PortId{0}, {&fire, 1});
  }
  void on(const safe_stop_t&, Time, Outbox&) {}
  void on_io(PortId, std::span<const std::byte>, Time, Outbox& out) override { out.finish(0, "fired"); }
  void on_refused(PortId, std::string_view cause, Time, Outbox& out) override { out.finish(3, cause); }

 private:
  double lease_s_;
  int step_ms_;
  Time until_;
};

/// Runs a Slow driver that gets one command, and a SAFE_STOP during its step when wanted. @returns its FINISH
std::string run_slow(double lease_s, bool stop) {
  RunDir dir;
  Hub hub;
  Instrument instrument(dir.path / "io" / "jet", 0);
  Hub::Member bus(hub), sender(hub);
  Pair line;
  ControlLine control(line.fd[0]);
  std::thread process([&] {
    run_process(options(dir, NodeId::kJet, line.fd[1]), std::make_unique<Slow>(lease_s, 150), bus);
  });
  const auto send = [&]<class Message>(const Channel<Message>& channel, Message m) {
    m.header.run_id = 5;
    m.header.seq = 1;
    std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    sender.publish(channel.name, bytes);
  };
  await(control, "READY");
  control.say("START");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // until the port is open
  jet_command_t arm{};
  arm.command_id = 1;
  arm.verb = std::int8_t(JetVerb::kArm);
  send(channels::kJetCommand, arm);
  if (stop) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    safe_stop_t m{};
    m.enable_epoch = 1;
    send(channels::kSafeStop, m);
  }
  const std::string finish = await(control, "FINISH");
  control.say("STOP");
  process.join();
  // The file leads a new node to the same place.
  WalFile file(dir.path / "nodes" / "jet.wal", true);
  NodeHost again(NodeId::kJet, std::make_unique<Slow>(lease_s, 0), 5, nullptr);
  const auto ignore = [](auto&&...) {};
  restore(again, 5, file, {ignore, ignore, ignore, ignore});
  CHECK(again.finished() == std::optional<int>(finish.starts_with("FINISH 0") ? 0 : 3));
  return finish;
}

TEST_CASE(
    "bytes leave after a slow step under its lease, and are kept back after the lease or for a stop that "
    "waits") {
  CHECK(run_slow(60.0, false) == "FINISH 0 fired");
  CHECK(run_slow(0.05, false) == "FINISH 3 too late");
  CHECK(run_slow(60.0, true) == "FINISH 3 a stop waits");
}

TEST_CASE("a process refuses an input that does not have the digest of its name") {
  const test::TempFolder run;
  const std::string bytes = "a target";
  const std::string digest = sha256_hex(std::as_bytes(std::span(bytes)));
  ProcessArgs args;
  args.options.run_dir = run.path().string();
  args.blobs = {{"target", digest}};
  run.file("inputs/" + digest, bytes);
  CHECK(read_blobs(args).at(0).bytes.size() == bytes.size());
  run.file("inputs/" + digest, "a tarqet");
  CHECK_THROWS_WITH(read_blobs(args), Catch::Contains("(input 'target' was changed)"));
}

TEST_CASE("arguments of a process survive the way through the command line, bad ones are named") {
  ProcessArgs a;
  a.options.node = NodeId::kLamp;
  a.options.run_dir = "/tmp/run x";
  a.options.run_id = 123456789012345;
  a.options.incarnation = 2;
  a.options.epoch_ns = 99;
  a.options.offset_us = 7;
  a.options.time_scale = 0.1;
  a.options.control_fd = 4;
  a.options.faults = {0.01, 0.02, 0.03, 0.04, 0.005, 77, 0, 0};
  a.bus_url = "udpm://239.255.76.67:7000?ttl=0";
  a.blobs = {{"target", "abc"}, {"mask", "def"}};
  const auto args = to_arguments(a);
  const ProcessArgs b = parse_process_args(args);
  CHECK(to_arguments(b) == args);
  CHECK(b.options.faults.seed == 77);
  CHECK(b.options.faults.node == std::uint32_t(NodeId::kLamp));
  CHECK(b.options.faults.incarnation == 2);
  CHECK(b.options.time_scale == 0.1);
  CHECK_THROWS_WITH(parse_process_args({"--run", "x", "--node", "jett"}), Catch::Contains("--node 'jett'"));
  CHECK_THROWS_WITH(parse_process_args({"--run", "x", "--node", "jet", "--epoch-ns", "3x"}),
                    Catch::Contains("--epoch-ns '3x': must be a number"));
  CHECK_THROWS_WITH(parse_process_args({"--node", "jet"}), Catch::Contains("--run"));
  CHECK_THROWS_WITH(parse_process_args({"--run", "x", "--node", "jet", "--faults", "1,0,0,0,0,0"}),
                    Catch::Contains("in [0, 1)"));
  CHECK_THROWS_WITH(parse_process_args({"--run"}), Catch::Contains("--run"));
}
