#include "procs/relay/near_end.h"

#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "files/command.h"
#include "files/run_paths.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/run_clock.h"

namespace firn::relay {
namespace {

constexpr double kGreetedWithinS = 20.0;  // ssh, and the program there
constexpr std::int64_t kLongestTurnUs = 100'000;
// Before the start and while records are collected nothing is at stake, and the host may be busy: with its
// processes, which all begin at one time, and with the sums of its records.
constexpr double kCalmSilenceS = 20.0;
// Connections beside the first one. With 20 ms and 5 % of loss a lease of 0.3 s comes too late by one
// connection some times an hour, by three in none of the prints that were tried.
constexpr int kLanes = 2;

}  // namespace

NearEnd::NearEnd(HostOrder order, std::string key_line, std::filesystem::path run, LcmBus* bus,
                 ControlLine& control)
    : order_(std::move(order)),
      key_line_(std::move(key_line)),
      run_(std::move(run)),
      bus_(bus),
      control_(control),
      facts_(own_facts()),
      ssh_(order_.address, shell_word(order_.program) + " host"),
      link_(ssh_.take_stream()),
      tunnel_(PortTunnel::Side::kInstruments, RunPaths(run_).ports_path(), order_.simulated, link_),
      source_(run_),
      sink_(run_, [this](std::string_view name) { return is_made_by(order_.nodes, name); }),
      began_ns_(monotonic_ns()),
      collecting_(order_.collect) {}

int NearEnd::run() try {
  const std::string hello = to_json(Hello{facts_, order_, {}, {}});
  link_.send({FrameKind::kHello, {}, 0, 0, std::as_bytes(std::span(hello))});
  link_.say("", key_line_);
  link_.set_files([this](std::vector<std::byte>& frame) { return source_.next(frame); });
  while (!collected_) turn();
  return 0;
} catch (const std::exception& e) {
  const std::string text = "host " + order_.name + " (" + order_.address + ") " + e.what();
  std::fprintf(stderr, "relay: %s\n", text.c_str());
  control_.say((started_ ? "FAULT " : "ERROR ") + text);
  return 1;
}

void NearEnd::turn() {
  link_.rest();
  std::vector<pollfd> fds;
  if (bus_) fds.push_back({bus_->fd(), POLLIN, 0});
  if (!control_.closed()) fds.push_back({control_.fd(), POLLIN, 0});
  link_.add_to(fds);
  tunnel_.add_to(fds);
  ssh_.add_to(fds);
  for (const auto& lane : lanes_) lane->add_to(fds);
  const std::int64_t wait_us = std::min(kLongestTurnUs, link_.due_us() - monotonic_us());
  const timespec timeout = poll_timeout(wait_us);
  ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
  listen_to_launcher();
  ssh_.service();
  for (const auto& lane : lanes_) lane->service();
  tunnel_.service();
  if (bus_)
    bus_->receive_sealed([this](std::string_view channel, std::span<const std::byte> sealed) {
      if (started_) link_.send({FrameKind::kDatagram, channel, 0, 0, sealed});
    });
  link_.service([this](const Frame& f) { take(f); });
  if (!files_told_ && source_.all_sent()) {
    files_told_ = true;
    link_.say_behind_files("FILES");
    if (order_.collect) link_.say_behind_files("COLLECT");
  }
  if (collected_) return;
  if (link_.closed()) {
    ssh_.service();
    throw std::runtime_error(greeted_ ? "has closed the connection" : "cannot be reached: " + ssh_.trouble());
  }
  if (!greeted_ && double(monotonic_ns() - began_ns_) * 1e-9 > kGreetedWithinS)
    throw std::runtime_error("has not answered within " + std::to_string(int(kGreetedWithinS)) + " s");
  if (greeted_ && link_.silent_s() > (begun_ && !collecting_ ? order_.silence_s : kCalmSilenceS)) {
    char text[80];
    std::snprintf(text, sizeof text, "has said nothing for %.1f s", link_.silent_s());
    throw std::runtime_error(text);
  }
}

void NearEnd::take(const Frame& f) {
  if (f.kind == FrameKind::kHello) return take_hello(std::string(f.text()));
  if (f.kind == FrameKind::kLine && f.name.empty() && f.text().starts_with("ERROR "))
    return take_line({}, f.text());
  if (!greeted_) throw std::runtime_error("speaks before its hello");
  if (f.kind == FrameKind::kLine) return take_line(f.name, f.text());
  if (f.kind == FrameKind::kFile) return sink_.take(f);
  if (f.kind == FrameKind::kPort) return tunnel_.take(f);
  if (bus_ && !f.name.empty()) bus_->publish_sealed(f.name, f.bytes);
}

void NearEnd::take_hello(const std::string& text) {
  const Hello hello = hello_from_json(text);
  if (const std::string why = unlike(facts_, hello.facts); !why.empty()) throw std::runtime_error(why);
  for (const std::string& name : hello.wants) {
    if (!order_.files.contains(name))
      throw std::runtime_error("asks for '" + name + "', which is not its own");
    source_.add(name, 0);
  }
  source_.look();
  for (int n = 0; n < kLanes && !order_.collect; ++n) {
    lanes_.push_back(std::make_unique<Ssh>(
        order_.address, shell_word(order_.program) + " host --lane " + shell_word(hello.lane)));
    link_.add_lane(lanes_.back()->take_stream());
  }
  files_told_ = false;
  greeted_ = true;
  facts_file_.open(RunPaths(run_).hosts_path() / (order_.name + ".facts"));
  facts_file_ << "host " << hello.facts.host << "\nplatform " << hello.facts.platform << "\nresults "
              << hello.facts.results << "\n";
}

void NearEnd::take_line(std::string_view node, std::string_view line) {
  if (!node.empty()) return control_.say("FROM " + std::string(node) + " " + std::string(line));
  const std::string_view verb = line.substr(0, line.find(' '));
  const std::string rest(line.substr(std::min(line.size(), verb.size() + 1)));
  if (verb == "ERROR") throw std::runtime_error(rest);
  if (verb == "STARTED") {
    started_ = true;
    const std::size_t pids = std::min(rest.find(' '), rest.size());
    facts_file_ << "bus " << rest.substr(0, pids) << std::endl;
    control_.say("BUS " + rest.substr(0, pids));
    control_.say("PIDS" + rest.substr(pids));
    control_.say("READY");
  } else if (verb == "CLOCK") {
    keep_clock(rest);
  } else if (verb == "RECORDS") {
    take_records(rest);
  } else {
    control_.say(line);
  }
}

void NearEnd::keep_clock(const std::string& numbers) {
  if (!clock_file_.is_open())
    clock_file_.open(RunPaths(run_).hosts_path() / (order_.name + ".clock"), std::ios::app);
  clock_file_ << monotonic_us() << " " << numbers << std::endl;
  control_.say("CLOCK " + numbers);
  std::istringstream in(numbers);
  std::int64_t ahead_ns = 0, bound_ns = 0;
  if (in >> ahead_ns >> bound_ns && double(bound_ns) * 1e-6 > order_.slack_ms) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "has a clock that is known to %.1f ms only, and run.clock_slack_ms is %g",
                  double(bound_ns) * 1e-6, order_.slack_ms);
    throw std::runtime_error(text);
  }
}

// The host has sent all; its files and the copies here must be the same bytes.
void NearEnd::take_records(const std::string& json) {
  for (const auto& [name, state] : files_from_json(json)) {
    if (!is_made_by(order_.nodes, name))
      throw std::runtime_error("names '" + name + "', which is not its own");
    if (state_of(run_ / name) != state) throw std::runtime_error(name + " is not here as it is there");
  }
  collected_ = true;
  control_.say("COLLECTED");
}

void NearEnd::listen_to_launcher() {
  while (const auto line = control_.next()) {
    if (line->starts_with("TO ")) {
      const std::size_t end = line->find(' ', 3);
      const std::string order = line->substr(std::min(line->size(), end + 1));
      begun_ = begun_ || order == "START";
      link_.say(line->substr(3, end - 3), order);
    } else if (line->starts_with("STOP") && !collecting_) {
      collecting_ = true;
      link_.say("", "COLLECT");
    }
  }
  if (control_.closed()) throw std::runtime_error("is left: the launcher is gone");
}

}  // namespace firn::relay
