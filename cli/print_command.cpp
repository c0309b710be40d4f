#include "cli/print_command.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "cli/option_set.h"
#include "cli/print_show.h"
#include "config/changes.h"
#include "config/devices.h"
#include "config/include.h"
#include "config/labs.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/bringup/bringup.h"
#include "print/exit_codes.h"
#include "print/folder/folder_watch.h"
#include "print/folder/lab_lock.h"
#include "print/folder/run_pack.h"
#include "print/folder/run_seal.h"
#include "print/folder/running.h"
#include "print/inputs/check_print.h"
#include "print/interrupt.h"
#include "print/labs/print_labs.h"
#include "print/live/bus_port.h"
#include "print/live/detached.h"
#include "print/live/launcher.h"
#include "print/live/row_rehearsal.h"
#include "print/operator/page_token.h"
#include "print/preview/print_preview.h"
#include "print/progress.h"
#include "print/simulated/lab_run.h"

namespace firn {
namespace {

// Orders of the operator that come with --resume.
std::vector<OperatorOrder> orders_of(const PrintOptions& options) {
  std::vector<OperatorOrder> orders;
  if (options.accept_doubt) orders.push_back({new_order_id(), OperatorVerb::kAcceptDoubt, {}, {}});
  if (options.resume.empty()) return orders;
  for (const std::string& assignment : options.overrides)
    orders.push_back(parse_order(std::vector<std::string>{"set", assignment}));
  return orders;
}

// The records of a run take a sixth of the room when they are packed, and nothing needs them plain but a
// resume.
void pack_after(const std::string& folder, const Experiment& e, PrintProgress& progress) try {
  const LabLock held(RunFolder::open(folder), e, "", LabLock::Heirs::kNobody);
  pack_records(folder);
} catch (const std::exception& error) {
  progress.note(std::string("the run folder stays plain: ") + error.what());
}

// The page is there for people: by default where one has a terminal, and its program is built.
bool page_wanted(const PrintOptions& o) {
  if (o.page || o.no_page || o.json) return o.page;
  return ::isatty(STDERR_FILENO) &&
         std::filesystem::exists(std::filesystem::read_symlink("/proc/self/exe").parent_path() / "page");
}

// The token is for who sits at the terminal, and does not go into files.
std::string page_text(const std::string& address, const std::string& token) {
  return "page: " + address +
         (::isatty(STDERR_FILENO) ? "#token=" + token
                                  : " (to watch; firn view RUN gives an address for commands)");
}

PrintSummary carry_out(const RunFolder& run, const Experiment& e, const PrintOptions& options, bool resume) {
  PrintSummary s;
  s.folder = run.path().string();
  s.scheme = e.control.scheme;
  s.words = print_lab(e).words;
  s.tolerance_asked = options.tolerance_um > 0.0;
  s.tolerance_um = s.tolerance_asked ? options.tolerance_um : usual_tolerance_um(e);
  PrintProgress progress(e.control.scheme);
  const auto began = std::chrono::steady_clock::now();
  int last_layer = 0;
  const auto note = [&](const std::string& text) { progress.note(text); };
  progress.note("run folder " + s.folder);
  const auto on_layer = [&](const layer_metrics_t& m) {
    progress.layer(m);
    s.measured = true;
    s.mean_error_um = m.mean_error_mm * 1e3;
    s.rms_um = m.rms_mm * 1e3;
    s.std_um = m.std_mm * 1e3;
    s.rms_inside_um = m.rms_inside_mm * 1e3;
    s.rms_rim_um = m.rms_rim_mm * 1e3;
    s.cells_guessed = m.cells_guessed;
    s.rows_lost += m.rows_lost;
    s.droplets = m.drops_total;
    last_layer = m.layer;
    s.node_s = double(m.header.utime_us) * 1e-6;
  };
  const auto on_warning = [&](const fault_t& f) { progress.note("warning: " + f.node + ": " + f.text); };
  const auto with = [&](auto o) {
    o.resume = resume;
    o.orders = orders_of(options);
    o.note = note;
    o.unsealed = options.unsealed;
    o.faults = parse_lab_faults(options.faults, e);
    o.progress = on_layer;
    o.warned = on_warning;
    return o;
  };
  if (options.bus == "in-process") {
    LabRunOptions o = with(LabRunOptions{});
    const InterruptGuard guard;
    o.interrupted = InterruptGuard::raised;
    const LabRunReport report = run_in_lab(run, o);
    s.result = report.result;
    s.folder = report.folder.string();
  } else {
    LaunchOptions o = with(LaunchOptions{});
    o.bus_url = options.bus;
    o.record = options.record;
    if (page_wanted(options)) o.page_token = new_page_token();
    o.on_page = [&](const std::string& address) { progress.note(page_text(address, o.page_token)); };
    const LaunchReport report = launch(run, o);
    s.result = report.result;
    s.folder = report.folder.string();
  }
  s.deleted = s.folder.empty();
  if (!s.deleted && !options.plain) pack_after(s.folder, e, progress);
  if (s.deleted) s.folder = run.path().string();
  progress.done();
  s.result.layers = std::max(s.result.layers, last_layer);  // a print that was stopped has no end of its own
  s.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return s;
}

// Lease, resend and heartbeat stay in wall time; above ten, an instrument's second is too short for them.
void check_speedup(const PrintOptions& o) {
  constexpr double kMost = 10.0;
  if (o.speedup == 0.0) return;
  if (!o.resume.empty()) throw UsageError("--speedup cannot change a run that has begun; start a new one");
  if (o.bus == "in-process")
    throw UsageError(
        "--speedup: a print in one process has no clock to run ahead of: it goes as fast as it can");
  if (!(o.speedup >= 1.0 && o.speedup <= kMost))
    throw UsageError(
        fmt::format("--speedup {}: a live print can go 1 to {} times as fast as the clock; --bus in-process "
                    "goes as fast as it can",
                    o.speedup, kMost));
}

// Real instruments are brought up before they print: LAB.bringup.json beside a file of the experiment, or in
// the folder of the run that goes on.
std::string bringup_beside(const std::filesystem::path& experiment) {
  std::string found = bringup_file(experiment.string());
  for (const auto& [file, text] : read_with_includes(experiment))
    if (const std::string beside = bringup_file(file); std::filesystem::exists(beside)) found = beside;
  return found;
}

void check_bringup(const Experiment& e, const PrintOptions& options) try {
  const auto state = read_bringup(options.bringup);
  if (const std::string why = bringup_refusal(e, state, options.bringup, options.accept_bringup);
      !why.empty())
    throw UsageError(why);
  const InterruptGuard guard;
  if (const std::string why =
          identity_refusal(e, state.value_or(BringupState{}), options.bringup, options.accept_bringup,
                           [] { return InterruptGuard::raised(); });
      !why.empty())
    throw UsageError(why);
} catch (const std::invalid_argument& damaged) {
  throw UsageError(damaged.what());
}

// The state of the bring-up at the beginning: its rows, and those whose risk was taken.
void keep_bringup(const std::filesystem::path& run, const Experiment& e, const PrintOptions& options) {
  if (real_ports(e).empty()) return;
  nlohmann::ordered_json j{{"accepted", options.accept_bringup}, {"file", options.bringup}};
  std::vector<std::string> nodes;
  for (const auto& [node, address] : real_ports(e)) nodes.push_back(node);
  j["assumptions"] = assumptions_json(e, nodes);
  if (std::filesystem::exists(options.bringup))
    j["result"] = nlohmann::ordered_json::parse(read_file(options.bringup));
  write_file_atomically(run / "bringup.json", j.dump(2) + "\n");
}

void check_all(const Experiment& e, const Blobs& inputs, const PrintOptions& options) {
  check_bus(options.bus);
  check_print(e, options.bus);
  check_inputs(e, inputs);
}

// The process that prints is another one: it goes on when this terminal is closed.
int detach(const std::filesystem::path& run, const PrintOptions& options) {
  std::vector<std::string> words{"print", "--resume", run.string()};
  const auto add = [&](const std::string& name, const std::string& value) {
    words.insert(words.end(), {name, value});
  };
  if (!options.bus.empty()) add("--bus", options.bus);
  for (const std::string& fault : options.faults) add("--fault", fault);
  for (const std::string& assignment : options.overrides) add("--set", assignment);
  if (options.tolerance_um > 0.0) add("--tolerance", fmt::format("{}", options.tolerance_um));
  if (options.accept_doubt) words.push_back("--accept-doubt");
  if (options.plain) words.push_back("--plain");
  if (options.record) words.push_back("--record");
  if (options.page) words.push_back("--page");
  if (options.unsealed) words.push_back("--unsealed");
  const DetachedPrint print = start_detached(run, words);
  if (options.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"run", run.string()}, {"pid", print.pid}}.dump(2));
  else
    fmt::print("run folder {}, pid {}\nto watch it: firn attach {}\n", run.string(), print.pid, run.string());
  return kOk;
}

// A print that finds no room for its inputs has not begun.
RunFolder make_folder(const Experiment& e, const Blobs& inputs, const PrintOptions& options) try {
  RunFolder run = RunFolder::create(options.runs, e, inputs, own_command_line());
  keep_bringup(run.path(), e, options);
  return run;
} catch (const UsageError&) {
  throw;
} catch (const std::runtime_error& error) {
  const std::string storage = storage_trouble(error);
  throw UsageError(storage.empty() ? error.what() : storage);
}

// The speed at which this machine reads every row.
void keep_up(Experiment& e, const PrintOptions& options) {
  const bool keeps_rows = e.laser_profiler.read == drivers::ProfileRead::kMemory;
  if (options.bus == "in-process" || prints_paths(e) || keeps_rows) return;
  const double period_s = row_period_s(e, e.process.scan_speed_mm_s);
  if (const std::string slower = fit_scan_speed(e, slowest_row_s(period_s)); !slower.empty())
    fmt::print(stderr, "{}\n", slower);
}

}  // namespace

PrintSummary print_experiment(const Experiment& asked, const Blobs& inputs, const PrintOptions& options) {
  Experiment e = asked;
  check_all(e, inputs, options);
  keep_up(e, options);
  return carry_out(make_folder(e, inputs, options), e, options, false);
}

int run_print(const PrintOptions& options) {
  if (options.experiment.empty() == options.resume.empty())
    throw UsageError("give either an experiment file or --resume RUN");
  check_bus(options.bus);
  if (options.record && options.bus == "in-process")
    throw UsageError("--record: --bus in-process has no ports to record");
  if (options.page && options.bus == "in-process")
    throw UsageError("--page: --bus in-process is over before anybody looks; firn view RUN shows it then");
  if (options.page && options.no_page) throw UsageError("--page and --no-page: one of them");
  check_speedup(options);
  std::signal(SIGPIPE, SIG_IGN);  // a reader that has gone does not end the print
  PrintSummary summary;
  if (!options.resume.empty()) {
    refuse_running(options.resume);
    const RunFolder run = RunFolder::open(options.resume);
    const auto result = run.result();
    if (result && !can_go_on(*result) && seal_end(run.path(), result->outcome)) {
      fmt::print(stderr, "{}: the end of this run had no seal; it is sealed as found\n", options.resume);
      return result->status;
    }
    if (result && !can_go_on(*result))
      throw UsageError(options.resume + ": this run has finished (" + result->reason + ")");
    const Experiment e = parse_experiment(run.experiment_toml(), (run.path() / "experiment.toml").string());
    for (const OperatorOrder& o : orders_of(options))
      if (const std::string problem =
              o.verb == OperatorVerb::kSet ? change_problem(e, o.key, o.value) : std::string();
          !problem.empty())
        throw UsageError("--resume --set: " + problem);
    if (options.detach) return detach(run.path(), options);
    summary = carry_out(run, e, options, true);
  } else {
    const std::filesystem::path file = options.experiment;
    std::vector<std::string> overrides = options.overrides;
    if (options.speedup > 0.0) overrides.push_back(fmt::format("run.time_scale={}", options.speedup));
    Experiment e = load_experiment(file, overrides);
    parse_lab_faults(options.faults, e);  // before anything is written
    const Blobs inputs = make_inputs(e, file.parent_path());
    complete_experiment(e, inputs);
    PrintOptions whole = options;
    if (whole.bringup.empty()) whole.bringup = bringup_beside(file);
    if (!real_ports(e).empty()) check_bringup(e, whole);
    const PrintPreview preview = preview_print(e, inputs, file.parent_path());
    std::fputs(preview_text(preview).c_str(), stderr);
    if (options.detach) {
      check_all(e, inputs, options);
      keep_up(e, options);
      PrintOptions again = whole;
      again.overrides.clear();
      return detach(make_folder(e, inputs, options).path(), again);
    }
    summary = print_experiment(e, inputs, whole);
  }
  std::fputs((options.json ? print_json(summary) : print_text(summary)).c_str(), stdout);
  return exit_code(summary);
}

void declare_print(OptionSet& options) {
  auto& o = options.calls(run_print);
  options.option("EXPERIMENT", o.experiment, "experiment file");
  options.option("--resume", o.resume, "go on with the interrupted run in this folder");
  options.option("--bus", o.bus, "in-process, or an LCM URL of loopback; default: a port of the run's own");
  options.override_option(o.overrides);
  options
      .option("--speedup", o.speedup,
              "live: node time runs so many times faster than the clock, 1 to 10; default run.time_scale")
      .above_zero();
  options
      .option("--fault", o.faults,
              "\"SECONDS PORT KIND [COUNT [DELAY_US]]\": what befalls a simulated instrument; docs/ice.md")
      .one_value_each();
  options.option("--runs", o.runs, "where run folders go").show_default();
  options
      .option("--tolerance", o.tolerance_um,
              "UM: exit code 4 if the last map's RMS is above; default: one nominal layer; "
              "docs/commands/print.md")
      .above_zero();
  options.flag("--accept-doubt", o.accept_doubt,
               "with --resume: go on though droplets of the open loop are in doubt");
  options.flag("--plain", o.plain, "leave the run folder's records as they are written; default: packed");
  options.option("--bringup", o.bringup,
                 "result of firn bringup; default: LAB.bringup.json beside the lab's file");
  options
      .option(
          "--accept-bringup", o.accept_bringup,
          "print on real instruments though this row of firn bringup is not done: NODE:ROW, or all; recorded")
      .one_value_each();
  options.flag("--record", o.record,
               "what crosses the ports of the instruments goes onto RUN/cassettes too; firn cassette");
  options.flag(
      "--detach", o.detach,
      "the print goes on in a process of its own, also when the terminal is closed; firn attach RUN");
  options.flag("--page", o.page, "show the print in a browser too; default with a terminal; docs/page.md");
  options.flag("--no-page", o.no_page, "do not");
  options.flag("--unsealed", o.unsealed,
               "with --resume: go on though the run folder is not as it was sealed; the next seal says so");
  options.json_flag(o.json);
}

}  // namespace firn
