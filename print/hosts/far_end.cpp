#include "print/hosts/far_end.h"

#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "files/usage_error.h"
#include "print/process/bus_port.h"
#include "runs/folder/run_folder.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using relay::Frame;
using relay::FrameKind;

constexpr double kClockWithinS = 5.0;    // for the first bound that is small enough
constexpr double kSilentS = 3.0;         // of the relay; the leases of the drivers end long before
constexpr double kUnbegunSilentS = 8.0;  // before the start, when all processes begin and nothing is at stake
constexpr double kCollectSilentS = 20.0;                 // the relay compares the sums of what it got
constexpr double kEndWithinS = 2.0;                      // of the processes, as at the launcher
constexpr std::int64_t kPredecessorNs = 15'000'000'000;  // above kUnbegunSilentS and kEndWithinS
constexpr std::int64_t kLookNs = 50'000'000, kSteerNs = 250'000'000, kTellClockNs = 1'000'000'000;
constexpr std::int64_t kLongestTurnUs = 50'000;

double seconds(std::int64_t ns) { return double(ns) * 1e-9; }

}  // namespace

FarEnd::FarEnd(fs::path runs, fs::path programs)
    : runs_(std::move(runs)), programs_(std::move(programs)), facts_(relay::own_facts()) {}

fs::path FarEnd::default_runs() {
  const char* const state = std::getenv("XDG_STATE_HOME");
  if (state && *state == '/') return fs::path(state) / "firn" / "hosts";
  const char* const home = std::getenv("HOME");
  if (!home || *home != '/') throw UsageError("HOME is not set: there is no place for the runs of this host");
  return fs::path(home) / ".local" / "state" / "firn" / "hosts";
}

int FarEnd::run(int in_fd, int out_fd) {
  link_.emplace(in_fd, out_fd);
  link_->ask_time();
  std::string trouble;
  const auto left = [&] { return link_->closed() || link_->silent_s() > longest_silence_s(); };
  while (!(all_ended() && left())) try {
      turn();
    } catch (const std::exception& e) {
      if (!trouble.empty()) throw;
      trouble = e.what();
      std::fprintf(stderr, "firn host: %s\n", e.what());
      link_->say("", "ERROR " + trouble);
      stop_all(trouble);
    }
  if (!greeted_)
    throw UsageError(
        "no launcher spoke: firn print starts firn host on the computers of [hosts], by ssh; docs/hosts.md");
  return handed_over_ ? 0 : 1;
}

void FarEnd::turn() {
  link_->rest();
  std::vector<pollfd> fds;
  link_->add_to(fds);
  fds.push_back({door_.fd(), POLLIN, 0});
  if (bus_) fds.push_back({bus_->fd(), POLLIN, 0});
  if (tunnel_) tunnel_->add_to(fds);
  for (const auto& c : children_) c->add_to(fds);
  const timespec timeout = poll_timeout(std::min(kLongestTurnUs, link_->due_us() - monotonic_us()));
  ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
  turned_ns_ = monotonic_ns();
  if (bus_)
    bus_->receive_sealed([this](std::string_view channel, std::span<const std::byte> sealed) {
      link_->send({FrameKind::kDatagram, channel, 0, 0, sealed});
    });
  if (tunnel_) tunnel_->service();
  if (const int lane = door_.accept(); lane >= 0) link_->add_lane(lane);
  link_->service([this](const Frame& f) { take(f); });
  service_children();
  if (link_->closed()) stop_all("the launcher's host has closed the connection");
  if (link_->silent_s() > longest_silence_s()) stop_all("no word from the launcher's host");
  if (have_files_ && !started_ && !stopping_ && clock_is_known()) start();
  if (started_) steer_clocks();
  if (source_ && turned_ns_ >= looked_ns_ + kLookNs) {
    looked_ns_ = turned_ns_;
    source_->look();
  }
  if (collecting_ && !handed_over_ && all_ended()) hand_over();
}

void FarEnd::take(const Frame& f) {
  if (f.kind == FrameKind::kHello) return take_hello(std::string(f.text()));
  if (!greeted_) throw std::runtime_error("the relay speaks before its hello");
  if (f.kind == FrameKind::kLine) return take_line(std::string(f.name), std::string(f.text()));
  if (f.kind == FrameKind::kFile) {
    if (have_files_) throw std::runtime_error("a file comes too late: " + std::string(f.name));
    return sink_->take(f);
  }
  if (f.kind == FrameKind::kPort) {
    if (tunnel_) tunnel_->take(f);
    return;
  }
  if (bus_ && !f.name.empty()) bus_->publish_sealed(f.name, f.bytes);
}

double FarEnd::longest_silence_s() const {
  return collecting_ ? kCollectSilentS : begun_ ? kSilentS : kUnbegunSilentS;
}

void FarEnd::take_hello(const std::string& text) {
  const relay::Hello hello = relay::hello_from_json(text);
  order_ = hello.order;
  greeted_ = true;
  greeted_ns_ = monotonic_ns();
  relay::Hello answer{facts_, {}, {}, door_.name()};
  const std::string why = relay::unlike(hello.facts, facts_);
  if (why.empty()) {
    args_ = parse_process_args(order_.arguments);
    launcher_epoch_ns_ = args_.options.epoch_ns;
    enter_folder(hello.facts.boot_id);
    for (const auto& [name, state] : order_.files) {
      if (has(name, state)) continue;
      if (RunPaths::is_wal(name) && relay::state_of(folder_ / name).bytes > 0)
        throw std::runtime_error("has a " + (folder_ / name).string() +
                                 " that does not continue the launcher's");
      if (!order_.collect) answer.wants.push_back(name);
    }
  }
  const std::string said = to_json(answer);
  link_->send({FrameKind::kHello, {}, 0, 0, std::as_bytes(std::span(said))});
}

bool FarEnd::has(const std::string& name, const relay::FileState& state) const {
  return relay::state_of(folder_ / name, state.bytes) == state;
}

// The one before, whose line was cut, makes its instruments safe and ends by itself.
void FarEnd::hold_folder() {
  for (const std::int64_t until = monotonic_ns() + kPredecessorNs;;) try {
      lock_.emplace(folder_, runs::RunUse::kPrint);
      return;
    } catch (const UsageError&) {
      if (monotonic_ns() > until) throw;
      const timespec pause{0, 100'000'000};
      ::nanosleep(&pause, nullptr);
    }
}

void FarEnd::enter_folder(const std::string& launcher_boot_id) {
  const auto plain = [](const std::string& name) {
    return !name.empty() && name[0] != '.' && name.find('/') == std::string::npos;
  };
  if (!plain(order_.name) || !plain(order_.run))
    throw std::runtime_error("'" + order_.run + "' is no name of a run");
  folder_ = runs_ / order_.name / order_.run;
  fs::create_directories(folder_ / RunPaths::kNodes);
  fs::permissions(runs_, fs::perms::owner_all);
  hold_folder();
  if (!order_.collect) reach_simulated(launcher_boot_id);
  sink_.emplace(folder_, [this](std::string_view name) { return order_.files.contains(std::string(name)); });
  source_.emplace(folder_);
  link_->set_files([this](std::vector<std::byte>& frame) { return source_->next(frame); });
}

// On one computer the world's sockets are here, as a real instrument's cable would be.
void FarEnd::reach_simulated(const std::string& launcher_boot_id) {
  if (order_.simulated.empty()) return;
  const RunPaths here(folder_), launchers(order_.place);
  if (facts_.boot_id != launcher_boot_id || !fs::exists(launchers.path())) {
    tunnel_.emplace(relay::PortTunnel::Side::kDrivers, here.ports_path(), order_.simulated, *link_);
    return;
  }
  fs::create_directories(here.ports_path());
  for (const std::string& port : order_.simulated) {
    fs::remove(here.port_path(port));
    fs::create_symlink(launchers.port_path(port), here.port_path(port));
  }
}

void FarEnd::take_line(const std::string& process, const std::string& line) {
  if (!process.empty()) {
    begun_ = begun_ || line == "START";
    for (const auto& c : children_)
      if (c->name() == process) c->say(line);
    return;
  }
  if (line.starts_with("KEY ")) {
    key_line_ = line;
  } else if (line == "FILES") {
    if (!order_.collect)
      for (const auto& [name, state] : order_.files)
        if (!has(name, state))
          throw std::runtime_error((folder_ / name).string() + " did not arrive as it was sent");
    have_files_ = true;
    for (const std::string& node : order_.nodes)
      for (const std::string& name : relay::grown_by(node)) {
        const auto known = order_.files.find(name);
        const bool goes_on = known != order_.files.end() && has(name, known->second);
        source_->add(name, goes_on ? known->second.bytes : 0);
      }
  } else if (line == "COLLECT") {
    collecting_ = true;
    stop_all("the run is over");
  }
}

bool FarEnd::clock_is_known() {
  if (order_.collect) return false;  // nothing starts
  const auto e = link_->peer_clock().at(monotonic_ns());
  if (seconds(monotonic_ns() - greeted_ns_) < 0.5) return false;  // some round trips more
  if (e && double(e->bound_ns) * 1e-6 <= order_.slack_ms) return true;
  if (seconds(monotonic_ns() - greeted_ns_) < kClockWithinS) return false;
  char text[160];
  std::snprintf(text, sizeof text,
                "has a clock that is known to %.1f ms only after %g s, and run.clock_slack_ms is %g",
                e ? double(e->bound_ns) * 1e-6 : 0.0, kClockWithinS, order_.slack_ms);
  throw std::runtime_error(text);
}

void FarEnd::start() {
  started_ = true;
  const auto key = BusKey::from_line(key_line_);
  if (!key) throw std::runtime_error("no key for the bus came");
  args_.bus_url = default_bus_url(free_bus_port(order_.run_id));
  bus_.emplace(args_.bus_url, key);
  bus_->subscribe_all();
  ProcessOptions& o = args_.options;
  o.run_dir = folder_.string();
  o.control_fd = ChildProcess::kControlFd;
  o.epoch_ns = launcher_epoch_ns_ - link_->peer_clock().at(monotonic_ns())->ahead_ns;
  std::string pids;
  for (const std::string& node : order_.nodes) {
    const NodeInfo* const row = find_node(node);
    if (!row) throw std::runtime_error("'" + node + "' is no process of a run");
    o.node = row->id;
    children_.push_back(std::make_unique<ChildProcess>(node, programs_ / node, to_arguments(args_),
                                                       folder_ / RunPaths::kNodes / (node + ".err")));
    children_.back()->say(key_line_);
    pids += " " + node + "=" + std::to_string(children_.back()->pid());
  }
  link_->say("", "STARTED " + args_.bus_url + pids);
}

void FarEnd::service_children() {
  for (const auto& c : children_) {
    while (const auto line = c->next()) link_->say(c->name(), *line);
    const auto& ending = c->poll_ending();
    if (!ending || std::ranges::find(told_ended_, c->name()) != told_ended_.end()) continue;
    told_ended_.push_back(c->name());
    link_->say(
        "", "ENDED " + c->name() + " " + std::to_string(ending->code) + " " + std::to_string(ending->signal));
  }
  if (!stopping_ || turned_ns_ < stopped_ns_ + std::int64_t(kEndWithinS * 1e9)) return;
  for (const auto& c : children_) c->kill();
}

// The processes here follow the launcher's node time, which the round trips bound.
void FarEnd::steer_clocks() {
  const std::int64_t now = monotonic_ns();
  if (now < steered_ns_ + kSteerNs) return;
  steered_ns_ = now;
  const auto e = link_->peer_clock().at(now);
  if (!e) return;
  const ProcessOptions& o = args_.options;
  const Time node = RunClock(launcher_epoch_ns_, o.offset_us, o.time_scale).at_ns(now + e->ahead_ns);
  for (const auto& c : children_)
    if (c->running()) c->say("CLOCK " + std::to_string(now) + " " + std::to_string(node.us));
  if (now < told_clock_ns_ + kTellClockNs) return;
  told_clock_ns_ = now;
  link_->say("", "CLOCK " + std::to_string(e->ahead_ns) + " " + std::to_string(e->bound_ns) + " " +
                     std::to_string(e->quickest_ns));
}

void FarEnd::stop_all(const std::string& cause) {
  if (stopping_) return;
  stopping_ = true;
  stopped_ns_ = monotonic_ns();
  for (const auto& c : children_) c->say("STOP " + cause);
}

bool FarEnd::all_ended() {
  return std::ranges::none_of(children_, [](const auto& c) { return c->running(); });
}

// Records that were sent piece by piece are told whole, with their sums.
void FarEnd::hand_over() {
  if (!std::exchange(sending_last_, true))
    for (const std::string& node : order_.nodes) source_->add(relay::faults_of(node), 0);
  source_->look();
  if (!source_->all_sent()) return;
  std::map<std::string, relay::FileState> records;
  for (const std::string& node : order_.nodes) {
    std::vector<std::string> names = relay::grown_by(node);
    names.push_back(relay::faults_of(node));
    for (const std::string& name : names)
      if (relay::FileState state = relay::state_of(folder_ / name); state.bytes >= 0)
        records[name] = std::move(state);
  }
  link_->say_behind_files("RECORDS " + relay::to_json(records));
  handed_over_ = true;
}

}  // namespace firn
