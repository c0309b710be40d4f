#include "print/own/own_print.h"

#include <signal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

#include "files/json.h"
#include "files/usage_error.h"
#include "lcmtypes/utf8.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr double kEndWithin_s = 2.0;  // as Firn's own processes
constexpr std::size_t kLastWords_bytes = 300;
constexpr std::string_view kKey = "key ", kSay = "say ";

double clock_s() { return double(monotonic_us()) * 1e-6; }

// The last line that says something, for the cause of a stop.
std::string last_words(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  in.seekg(0, std::ios::end);
  const std::streamoff size = in.tellg();
  in.seekg(std::max<std::streamoff>(0, size - std::streamoff(kLastWords_bytes)));
  std::string line, last;
  while (std::getline(in, line))
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  return valid_utf8(last);
}

// setpriv (util-linux) ends the program with the launcher, should that be killed.
std::pair<fs::path, std::vector<std::string>> shell_of(const std::string& command) {
  const fs::path setpriv = "/usr/bin/setpriv", shell = "/bin/sh";
  const std::vector<std::string> words{"-c", "exec " + command + " <&" +
                                                 std::to_string(ChildProcess::kControlFd) + " " +
                                                 std::to_string(ChildProcess::kControlFd) + "<&-"};
  if (!fs::exists(setpriv)) return {shell, words};
  std::vector<std::string> guarded{"--pdeathsig", "TERM", shell};
  guarded.insert(guarded.end(), words.begin(), words.end());
  return {setpriv, guarded};
}

}  // namespace

OwnPrint::OwnPrint(const Experiment& experiment, const runs::RunFolder& run, const std::string& bus_url,
                   const std::optional<BusKey>& key, OwnDoor::Take take, OwnDoor::Warn warn,
                   std::function<void(const std::string&)> note)
    : run_(run), note_(std::move(note)), door_(bus_url, key, std::move(take), std::move(warn)) {
  for (const auto& [name, program] : experiment.own_programs)
    programs_.push_back({name, program, nullptr, false});
}

void OwnPrint::start() {
  for (Program& p : programs_) {
    const auto [program, words] = shell_of(p.config.command);
    p.process = std::make_unique<ChildProcess>(p.name, program, words, run_.nodes_path() / (p.name + ".err"),
                                               ChildProcess::Group::kOwn);
    auto told = nlohmann::ordered_json::parse(door_.admission(p.name, run_.run_id()));
    told["run"] = fs::absolute(run_.path()).string();
    told["experiment"] = fs::absolute(run_.experiment_path()).string();
    p.process->say(told.dump());
  }
}

void OwnPrint::begin() {
  began_s_ = clock_s();
  for (const Program& p : programs_) p.process->say("START");
}

void OwnPrint::add_to(std::vector<pollfd>& fds) {
  fds.push_back({door_.fd(), POLLIN, 0});
  for (const Program& p : programs_)
    if (p.process) p.process->add_to(fds);
}

void OwnPrint::service() {
  if (began_s_) door_.service();  // earlier ones wait in the socket
  for (const Program& p : programs_)
    while (p.process && p.process->next()) {
    }  // nothing is wanted on its standard input
}

double OwnPrint::quiet_s(const Program& p) const {
  const auto count = door_.counts().find(p.name);
  return clock_s() -
         std::max(began_s_.value_or(clock_s()), count == door_.counts().end() ? 0.0 : count->second.last_s);
}

std::string OwnPrint::trouble_of(Program& p) {
  if (const auto& ending = p.process->poll_ending()) {
    const fs::path said = run_.nodes_path() / (p.name + ".err");
    const std::string words = last_words(said);
    return p.name + " (" + p.config.command + ") " + to_text(*ending) + (words.empty() ? "" : ": " + words) +
           " (" + said.string() + ")";
  }
  const double longest = p.config.longest_silence_s;
  if (longest <= 0.0 || quiet_s(p) <= longest) return "";
  return p.name + " (" + p.config.command + ") has sent nothing for " +
         std::to_string(std::lround(quiet_s(p))) + " s: nodes." + p.name + ".longest_silence_s";
}

std::string OwnPrint::lost() {
  for (Program& p : programs_) {
    if (!p.process || p.told) continue;
    const std::string trouble = trouble_of(p);
    if (trouble.empty()) continue;
    if (p.config.is_needed()) return trouble;
    p.told = true;
    note_(trouble + "; the print goes on without it");
  }
  return "";
}

std::string OwnPrint::obey(const std::string& order) {
  if (order.starts_with(kKey)) return "ok " + door_.admission(order.substr(kKey.size()), run_.run_id());
  const std::size_t name = kSay.size(), channel = order.find(' ', name),
                    json = channel == order.npos ? channel : order.find(' ', channel + 1);
  if (!order.starts_with(kSay) || json == order.npos)
    throw UsageError("own key NAME, or own say NAME CHANNEL JSON is wanted");
  door_.say(order.substr(name, channel - name), order.substr(channel + 1, json - channel - 1),
            order.substr(json + 1));
  return "ok taken";
}

void OwnPrint::end(const std::string& cause, const std::function<void()>& turn) {
  const auto each_running = [&](const auto& act) {
    bool any = false;
    for (Program& p : programs_)
      if (p.process && p.process->running()) {
        act(*p.process);
        any = true;
      }
    return any;
  };
  const auto wait = [&] {
    for (const double until = clock_s() + kEndWithin_s / 2;
         each_running([](ChildProcess&) {}) && clock_s() < until;)
      turn();
  };
  if (each_running([&](ChildProcess& process) { process.say("STOP " + cause); })) wait();
  if (each_running([](ChildProcess& process) { process.signal(SIGTERM); })) wait();
  for (Program& p : programs_)
    if (p.process && p.process->running()) {
      note_(p.name + " did not end within " + std::to_string(int(kEndWithin_s)) + " s and was killed");
      p.process->kill();
    }
  for (const std::string& line : door_.summary()) note_(line);
}

std::vector<std::pair<std::string, pid_t>> OwnPrint::pids() const {
  std::vector<std::pair<std::string, pid_t>> all;
  for (const Program& p : programs_)
    if (p.process) all.emplace_back(p.name, p.process->pid());
  return all;
}

}  // namespace firn
