#include "print/live/launcher.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "config/devices.h"
#include "config/experiment.h"
#include "files/exit_codes.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/run_start_t.hpp"
#include "firn/sim_truth_t.hpp"
#include "print/folder/taking_part.h"
#include "print/hosts/run_hosts.h"
#include "print/live/busy_machine.h"
#include "print/live/launch_signals.h"
#include "print/live/run_watch.h"
#include "print/operator/operator_desk.h"
#include "print/own/own_print.h"
#include "print/print_judge.h"
#include "print/process/bus_port.h"
#include "print/process/child_process.h"
#include "print/run_facts.h"
#include "print/simulated/sim_truth.h"
#include "procs/bus/lcm_bus.h"
#include "runs/folder/commit.h"
#include "runs/folder/folder_watch.h"
#include "runs/folder/host_record.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/lab_lock.h"
#include "runs/folder/log_repair.h"
#include "runs/folder/resume_point.h"
#include "runtime/build_info.h"
#include "runtime/precedence.h"
#include "runtime/process_args.h"
#include "runtime/station.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr double kSafeWithinS = 2.0;  // after STOP: drivers have 1 s of their own
constexpr double kRecorderWithinS = 3.0;
constexpr double kWorldWithinS = 10.0;      // saves its state
constexpr double kSchedulerWithinS = 10.0;  // to end the run after a safe stop
constexpr double kTruthWithinS = 2.0;
constexpr double kDeathSeenWithinS = 0.3;  // after a safe stop

// A fault is told as "NODE: TEXT".
bool tells(const std::string& fault, const std::string& reason) {
  const auto text = fault.find(": ");
  return reason.find(text == std::string::npos ? fault : fault.substr(text + 2)) != std::string::npos;
}

double wall_s() { return double(monotonic_us()) * 1e-6; }

class Launch {
 public:
  Launch(const Product& product, const runs::RunFolder& folder, const LaunchOptions& options)
      : product_(product),
        folder_(folder),
        options_(options),
        experiment_(parse_experiment(folder.experiment_toml(), folder.experiment_path().string())),
        place_(folder.path()),
        lock_(folder, experiment_, options.bus_url, runs::LabLock::Heirs::kChildren),
        judge_(product, experiment_, options.tolerance_um),
        resume_(options.resume && runs::ready_to_resume(folder.path())) {}

  LaunchReport run();
  bool resumes() const { return resume_; }

 private:
  void prepare();
  void start_all();
  bool await_ready();
  void begin();
  void watch();
  void end_all(const std::string& cause);
  LaunchReport report();

  /// @returns the number of messages that the log had lost
  std::size_t repair_log(const fs::path& run);
  NodeProcess* child(std::string_view name);
  double node_s() const {
    return RunClock(args_.options.epoch_ns, args_.options.offset_us, args_.options.time_scale)
        .at_ns(monotonic_ns())
        .s();
  }
  /// Waits at most until `until_s` for something to happen and handles it.
  void turn(double until_s);
  void take_lines();
  void find_the_dead();
  void start_own();
  void start_page(const fs::path& program);
  void service_page();
  void ask_truth();
  std::string port_words(const std::string& reason) const;
  void note(const std::string& text) {
    options_.note ? options_.note(text) : void(std::fprintf(stderr, "%s\n", text.c_str()));
    if (desk_) desk_->tell("note " + text);
  }
  /// Publishes the operator's order at once.
  void obey(const OperatorOrder& order, const std::string& from);

  const Product& product_;
  const runs::RunFolder& folder_;
  const LaunchOptions& options_;
  Experiment experiment_;
  LaunchSignals signals_;
  runs::FolderWatch place_;
  runs::LabLock lock_;
  PrintJudge judge_;
  bool resume_;  // there is something to go on with
  ProcessArgs args_;
  std::optional<BusKey> key_;
  std::optional<LcmBus> bus_;
  std::optional<Station> station_;
  std::optional<RunWatch> watch_;
  std::optional<OperatorDesk> desk_;
  std::vector<operator_command_t> earlier_orders_;  // of before the resume
  bool begun_ = false;                              // START was sent: the nodes can take orders
  std::optional<RunHosts> hosts_;
  std::optional<OwnPrint> own_;
  std::vector<std::unique_ptr<NodeProcess>> children_;
  std::unique_ptr<ChildProcess> page_;               // no part of the print: its death is only told
  std::map<std::string, std::string> said_;          // last ERROR or FAULT line of each
  std::map<std::string, std::string> port_trouble_;  // of an instrument's port that is not open, with address
  std::map<std::string, bool> ready_;
  std::optional<std::pair<int, std::string>> finish_;  // the scheduler's FINISH
  std::string cause_;                                  // cause of an early stop of the lab
  bool stopping_ = false;
  bool truth_asked_ = false;
  std::size_t faults_done_ = 0;
};

LaunchReport Launch::run() {
  prepare();
  if (watch_->end()) return report();
  desk_.emplace(folder_.path(), folder_.run_id(), experiment_,
                [this](const std::string& text) { note(text); });
  for (const operator_command_t& m : earlier_orders_) desk_->remember(to_order(m));
  for (const OperatorOrder& order : options_.orders) desk_->remember(order);
  start_all();
  if (await_ready()) {
    begin();
    watch();
  }
  end_all(cause_.empty() ? "the run is over" : cause_);
  page_.reset();
  if (const std::string dropped = bus_->dropped_text(); !dropped.empty()) note("on the bus: " + dropped);
  LaunchReport over = report();
  desk_->tell("end " + std::to_string(over.result.status) + " " + over.result.outcome);
  return over;
}

void Launch::prepare() {
  ProcessOptions& o = args_.options;
  o.run_dir = folder_.path().string();
  o.run_id = folder_.run_id();
  o.time_scale = experiment_.run.time_scale;
  o.real_ports = outside_ports(experiment_);
  o.record = options_.record;
  note(ports_text(experiment_));
  o.control_fd = ChildProcess::kControlFd;
  const BusConfig& b = experiment_.bus;
  o.faults = {b.loss, b.duplicate, b.reorder, b.delay, b.delay_s, b.seed, 0, 0};
  for (const Blob& blob : folder_.inputs()) args_.blobs.emplace_back(blob.role, blob.sha256);
  runs::ResumePoint point;
  if (resume_) {
    point = runs::read_resume_point(folder_.path(), RunWatch::channels());
    repair_log(folder_.path());
    folder_.clear_result();
    earlier_orders_ = std::move(point.orders);
  }
  o.incarnation = point.incarnation;
  o.offset_us = point.offset_us;
  o.epoch_ns = monotonic_ns();
  args_.bus_url =
      options_.bus_url.empty() ? default_bus_url(free_bus_port(folder_.run_id())) : options_.bus_url;
  if (const std::string warning = receive_buffer_warning(); !warning.empty()) note(warning);

  o.node = NodeId::kLauncher;
  ProcessOptions own = o;
  own.faults = {};
  watch_.emplace(o.incarnation);
  if (bus_is_keyed(args_.bus_url))
    key_ = BusKey::random();
  else
    note("key=none: any program on this host may speak on the bus of this run");
  bus_.emplace(args_.bus_url, key_);
  station_.emplace(own, *bus_, [this](const ChannelInfo& row, std::span<const std::byte> m) {
    watch_->on_message(row, m);
  });
  for (const std::string_view channel : RunWatch::channels()) station_->subscribe(channel);
  for (const auto& [channel, message] : point.newest) {
    if (channel == channels::kRunEnd.name) watch_->on_earlier_end(message);
    if (layer_metrics_t last{};
        channel == channels::kLayerMetrics.name && last.decode(message.data(), 0, int(message.size())) >= 0)
      judge_.take(last);
    station_->restore_received(channel, message);
  }
  station_->join();
}

fs::path programs_of(const LaunchOptions& options) {
  return options.programs.empty() ? fs::read_symlink("/proc/self/exe").parent_path() : options.programs;
}

void Launch::start_all() {
  const fs::path programs = programs_of(options_);
  const auto start = [&](const std::string& name) {
    args_.options.node = name == "world" ? NodeId::kLauncher : find_node(name)->id;
    children_.push_back(std::make_unique<ChildProcess>(name, programs / name, to_arguments(args_),
                                                       folder_.nodes_path() / (name + ".err")));
    if (key_ && name != "world") children_.back()->say(key_->line());  // the world is not on the bus
  };
  if (!simulated_ports(experiment_).empty()) start("world");
  start("recorder");
  std::vector<std::string> nodes;
  for (const NamedMaker& n : taking_part(product_, experiment_)) nodes.emplace_back(info(n.id).name);
  hosts_.emplace(experiment_, folder_, nodes);
  for (auto& process : hosts_->start(programs, args_, key_ ? key_->line() : ""))
    children_.push_back(std::move(process));
  for (const std::string& node : nodes)
    if (!hosts_->has(node)) start(node);
  if (!options_.page_token.empty()) start_page(programs / "page");
  start_own();
  const ProcessOptions& o = args_.options;
  std::ofstream(folder_.clocks_path(), std::ios::app)
      << o.incarnation << " " << o.epoch_ns << " " << o.offset_us << " " << o.time_scale << " "
      << args_.bus_url << "\n";
  std::ofstream pids(folder_.path() / "pids");
  pids << "launcher " << ::getpid() << "\n";
  for (const auto& c : children_)
    if (!hosts_->has(c->name())) pids << c->name() << " " << c->pid() << "\n";
  for (const auto& [name, pid] : hosts_->pids()) pids << name << " " << pid << "\n";
  for (const auto& [name, pid] : own_->pids()) pids << name << " " << pid << "\n";
  if (page_) pids << page_->name() << " " << page_->pid() << "\n";
}

void Launch::start_own() {
  const auto publish = [this](OwnMessage&& m) {
    std::visit([this](auto& one) { station_->send(channel_of(one), std::move(one)); }, m);
  };
  const auto warn = [this](const std::string& text) {
    fault_t fault{};
    fault.severity = std::int8_t(Severity::kWarning);
    fault.node = "launcher";
    fault.text = text;
    station_->send(channels::fault(NodeId::kLauncher), fault);
    if (options_.warned) options_.warned(fault);
  };
  own_.emplace(experiment_, folder_, args_.bus_url, key_, publish, warn,
               [this](const std::string& text) { note(text); });
  own_->start();
  desk_->take_own([this](const std::string& order) { return own_->obey(order); });
}

// The page reads the files of the run and speaks to the desk, as firn ctl does: nothing of the print waits
// for it. Its errors stand beside the files of the run, not among them.
void Launch::start_page(const fs::path& program) try {
  const std::vector<std::string> words{"--run", folder_.path().string(), "--control-fd",
                                       std::to_string(ChildProcess::kControlFd)};
  page_ = std::make_unique<ChildProcess>("page", program, words, folder_.path() / "page.err");
  if (options_.page_is_public) page_->say("PUBLIC");
  if (!options_.page_people.empty()) page_->say("PEOPLE " + fs::absolute(options_.page_people).string());
  page_->say("TOKEN " + options_.page_token);
} catch (const std::exception& e) {
  note(std::string("no page: ") + e.what());
}

void Launch::service_page() {
  if (!page_) return;
  while (const auto line = page_->next())
    if (line->starts_with("PAGE ") && options_.on_page) options_.on_page(line->substr(5));
  if (page_->running()) return;
  note("the page " + to_text(*page_->poll_ending()) + "; the print goes on, firn view " +
       folder_.path().string() + " shows it again");
  page_.reset();
}

bool Launch::await_ready() {
  const double until = wall_s() + options_.ready_within_s;
  const auto all_ready = [&] {
    return hosts_->ready() &&
           std::all_of(children_.begin(), children_.end(), [&](const auto& c) { return ready_[c->name()]; });
  };
  while (!all_ready()) {
    turn(until);
    std::string trouble = hosts_->lost();
    if (trouble.empty()) trouble = own_->lost();
    for (const auto& c : children_) {
      const auto& ending = c->poll_ending();
      if (ending && !(ending->code < 0 && ending->signal == 0))
        trouble += (trouble.empty() ? "" : "; ") + c->name() + " " + to_text(*ending) +
                   " before it was ready" + (said_[c->name()].empty() ? "" : ": " + said_[c->name()]);
    }
    if (trouble.empty() && wall_s() >= until) {
      for (const auto& c : children_)
        if (!ready_[c->name()])
          trouble +=
              (trouble.empty() ? "not ready after " + std::to_string(int(options_.ready_within_s)) + " s: "
                               : ", ") +
              c->name();
    }
    if (signals_.interrupted()) trouble = "interrupted before the start";
    if (trouble.empty()) continue;
    cause_ = trouble;
    return false;
  }
  return true;
}

void Launch::begin() {
  station_->set_state(Heartbeat::kRunning);
  for (const auto& c : children_) c->say("START");
  own_->begin();
  run_start_t start{};
  start.name = experiment_.run.name;
  start.commit = build_commit();
  start.scheme = experiment_.control.scheme;
  station_->send(channels::kRunStart, start);
  for (const OperatorOrder& order : options_.orders)
    station_->send(channels::kOperatorCommand, to_message(order, "firn print --resume"));
  begun_ = true;
  if (options_.on_start) {
    std::map<std::string, int> pids;
    for (const auto& c : children_) pids[c->name()] = int(c->pid());
    pids.merge(hosts_->pids());
    for (const auto& [name, pid] : own_->pids()) pids[name] = int(pid);
    options_.on_start(pids);
  }
}

void Launch::watch() {
  const Precedence precedence;  // an operator's orders wait for no other work
  double stop_seen_s = -1.0;
  while (cause_.empty() && !(watch_->end() && finish_)) {
    turn(wall_s() + 0.2);
    for (const std::string& notice : watch_->take_notices()) note(notice);
    for (; faults_done_ < options_.faults.size() && node_s() >= options_.faults[faults_done_].node_s;
         ++faults_done_)
      if (NodeProcess* const world = child("world"))
        world->say(simfault_line(options_.faults[faults_done_].fault));
    for (const fault_t& fault : watch_->take_warnings())
      if (options_.warned) options_.warned(fault);
    if (auto metrics = watch_->take_metrics()) {
      judge_.take(*metrics);
      if (options_.progress) options_.progress(*metrics);
      desk_->tell(*metrics);
      ask_truth();
    }
    if (const std::string moved = place_.trouble(); !moved.empty() && cause_.empty())
      cause_ = moved + " " + watch_->place();
    find_the_dead();
    if (signals_.interrupted() && cause_.empty()) cause_ = "interrupted by the operator " + watch_->place();
    const bool ending = watch_->safe_stop() || watch_->end() || finish_;
    if (ending && stop_seen_s < 0.0) stop_seen_s = wall_s();
    if (ending && wall_s() > stop_seen_s + kSchedulerWithinS && cause_.empty()) {
      if (watch_->end() || finish_) break;
      cause_ = watch_->fault() + "; the scheduler did not end the run";
    }
  }
  // A dying process closes its connections before it can be seen as dead: its end is the cause of the stop
  // that they led to.
  if (cause_.empty() && watch_->safe_stop())
    for (const double until = wall_s() + kDeathSeenWithinS; cause_.empty() && wall_s() < until;) {
      turn(until);
      find_the_dead();
    }
  if (!cause_.empty()) return;
  ask_truth();  // the finished part
  for (const double until = wall_s() + kTruthWithinS;
       truth_asked_ && wall_s() < until && child("world")->running();)
    turn(until);
}

void Launch::find_the_dead() {
  for (const std::string& lost : {hosts_->lost(), own_->lost()})
    if (!lost.empty() && cause_.empty()) cause_ = lost + " " + watch_->place();
  for (const auto& c : children_) {
    const auto& ending = c->poll_ending();
    if (!ending || !cause_.empty()) continue;
    cause_ = c->name() + " " + to_text(*ending) + " " + watch_->place();
    if (!said_[c->name()].empty()) cause_ += ": " + said_[c->name()];
  }
}

void Launch::end_all(const std::string& cause) {
  stopping_ = true;
  if (!cause_.empty()) {
    note(cause_ + "; making the lab safe");
    fault_t fault{};
    fault.severity = std::int8_t(Severity::kStop);
    fault.node = "launcher";
    fault.text = cause_;
    station_->send(channels::fault(NodeId::kLauncher), fault);
  }
  const auto stop = [&](auto concerned, double within_s) {
    std::vector<NodeProcess*> some;
    for (const auto& c : children_)
      if (concerned(c->name())) some.push_back(c.get());
    for (NodeProcess* c : some) c->say("STOP " + cause);
    const auto gone = [&] { return std::ranges::none_of(some, [](NodeProcess* c) { return c->running(); }); };
    for (const double until = wall_s() + within_s; !gone() && wall_s() < until;) turn(until);
    for (NodeProcess* c : some)
      if (c->running()) {
        note(c->name() + " did not end within " + std::to_string(int(within_s)) + " s and was killed");
        c->kill();
      }
  };
  stop([](const std::string& name) { return name != "world" && name != "recorder"; }, kSafeWithinS);
  hosts_->collect([&] {
    turn(wall_s() + 0.2);
    return signals_.interrupted() < 2;  // the second time it means this wait
  });
  if (own_) own_->end(cause, [&] { turn(wall_s() + 0.2); });
  stop([](const std::string& name) { return name == "recorder"; }, kRecorderWithinS);
  stop([](const std::string& name) { return name == "world"; }, kWorldWithinS);
  std::error_code ignored;
  fs::remove(place_.now() / "pids", ignored);
}

// The port of an instrument that the reason names, and what this computer said of it: nodes do not know it.
std::string Launch::port_words(const std::string& reason) const {
  for (const auto& [node, trouble] : port_trouble_)
    if (!trouble.empty() && reason.find(node) != std::string::npos) return "; " + node + " at " + trouble;
  return "";
}

LaunchReport Launch::report() {
  LaunchReport report;
  report.folder = place_.now();
  runs::RunResult& r = report.result;
  std::string log_trouble;
  try {
    if (!report.folder.empty()) report.log_repaired = repair_log(report.folder);
  } catch (const std::exception& e) {  // the resume repairs, or `firn log repair`
    const std::string storage = runs::storage_trouble(e);
    log_trouble = "log.lcm is not whole: " + (storage.empty() ? e.what() : storage);
    note(log_trouble);
  }
  const std::string incomplete = report.folder.empty() ? "" : runs::incomplete_text(report.folder);
  const std::string lost = hosts_ ? hosts_->lost() : "";
  if (!incomplete.empty())
    note(incomplete + (lost.empty() ? "" : ": " + lost) + "; firn runs collect " + report.folder.string() +
         " fetches the rest");
  if (!cause_.empty() || !watch_->end()) {
    r.outcome = signals_.interrupted() ? "interrupted" : "stopped safely";
    r.status = signals_.interrupted() ? kInterrupted : kSafetyStop;
    r.reason = !cause_.empty() ? cause_ : finish_ ? finish_->second : "the scheduler said nothing";
    r.reason += port_words(r.reason) + busy_words(r.reason, watch_->fault_code());
    return report;
  }
  const run_end_t& end = *watch_->end();
  r = runs::result_of(end.outcome, end.layers, end.reason);
  if (finish_ && RunOutcome(end.outcome) != RunOutcome::kOutOfTolerance) r.status = finish_->first;
  if ((RunOutcome(end.outcome) == RunOutcome::kStoppedSafely ||
       RunOutcome(end.outcome) == RunOutcome::kWaitsForOperator) &&
      !watch_->fault().empty() && !tells(watch_->fault(), r.reason))
    r.reason += " (" + watch_->fault() + ")";
  if (runs::can_go_on(r)) r.reason += port_words(r.reason) + busy_words(r.reason, watch_->fault_code());
  if (const auto last = watch_->take_metrics()) judge_.take(*last);
  judge_.judge(r);
  try {
    if (!log_trouble.empty() && !runs::can_go_on(r)) throw std::runtime_error(log_trouble);
    add_facts(folder_, experiment_, r);
    folder_.write_result(r);
    report.ended = true;
  } catch (const std::exception& e) {
    r = {"stopped safely", kSafetyStop, r.layers, "the print is over (" + r.outcome + "), but " + e.what()};
  }
  return report;
}

std::size_t Launch::repair_log(const fs::path& run) {
  const record::RepairReport repair =
      runs::repair_from_write_ahead(RunPaths(run).log_path(), RunPaths(run).nodes_path());
  const std::size_t lost = repair.inserted + repair.replaced;
  if (repair.gaps.size() <= 3)
    for (const std::string& line : describe(repair)) note(line);
  else
    note("recording gap, repaired: " + std::to_string(lost) + " messages of " +
         std::to_string(repair.gaps.size()) + " channels");
  return lost;
}

NodeProcess* Launch::child(std::string_view name) {
  for (const auto& c : children_)
    if (c->name() == name) return c.get();
  return nullptr;
}

void Launch::turn(double until_s) {
  const std::int64_t now = monotonic_us();
  const std::int64_t until = std::min(std::int64_t(until_s * 1e6), station_->due_us());
  const int left_ms = int(std::clamp<std::int64_t>((until - now + 999) / 1000, 0, 200));
  std::vector<pollfd> fds{{station_->fd(), POLLIN, 0}};
  for (const auto& c : children_) c->add_to(fds);
  if (hosts_) hosts_->add_to(fds);
  if (own_) own_->add_to(fds);
  if (page_) page_->add_to(fds);
  if (begun_) desk_->add_to(fds);
  ::poll(fds.data(), nfds_t(fds.size()), left_ms);
  if (begun_)
    desk_->service([this](const OperatorOrder& order, const std::string& from) { obey(order, from); });
  station_->service();
  if (own_) own_->service();
  if (desk_ && watch_->safe_stop()) desk_->on_safe_stop();
  take_lines();
  service_page();
}

void Launch::obey(const OperatorOrder& order, const std::string& from) {
  station_->send(channels::kOperatorCommand, to_message(order, from));
  station_->service();
  note("the operator: " + to_text(order));
}

void Launch::take_lines() {
  for (const auto& c : children_)
    while (const auto line = c->next()) {
      std::istringstream words(*line);
      std::string verb, rest;
      words >> verb;
      if (verb == "READY") ready_[c->name()] = true;
      if (verb == "FINISH" && c->name() == "scheduler") {
        int status = 1;
        words >> status >> std::ws;
        std::getline(words, rest);
        finish_ = {status, rest};
      }
      if (verb == "PORT") port_trouble_[c->name()] = line->substr(verb.size() + 1);
      if (verb == "ERROR" || verb == "FAULT")
        said_[c->name()] = line->substr(std::min(line->size(), verb.size() + 1));
      if (verb == "TRUTH") {
        truth_asked_ = false;
        if (const auto truth = parse_truth_line(*line)) station_->send(channels::kSimTruth, *truth);
      }
    }
}

void Launch::ask_truth() {
  if (truth_asked_ || !args_.options.real_ports.empty()) return;  // it knows no droplet of a real jet
  child("world")->say("TRUTH");
  truth_asked_ = true;
}

}  // namespace

LaunchReport launch(const Product& product, const runs::RunFolder& folder, const LaunchOptions& options) try {
  std::optional<runs::RunLock> held;
  if (!options.lock) held.emplace(folder.path(), runs::RunUse::kPrint);
  if (options.resume)
    collect_records(folder, programs_of(options), [&](const std::string& text) {
      options.note ? options.note(text) : void(std::fprintf(stderr, "%s\n", text.c_str()));
    });
  Launch print(product, folder, options);  // holds the lab from here on
  runs::SealedIncarnation seal(folder.path(), folder.run_id(), print.resumes(), options.unsealed);
  LaunchReport report = print.run();
  seal.ended(report.result);
  return report;
} catch (const std::exception& e) {
  const std::string storage = runs::storage_trouble(e);
  if (storage.empty()) throw;
  LaunchReport report;
  report.result = {"stopped safely", kSafetyStop, 0, storage};
  report.folder = folder.path();
  return report;
}

}  // namespace firn
