#include "cli/print_command.h"

#include <fmt/core.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "cli/option_set.h"
#include "cli/print_show.h"
#include "config/changes.h"
#include "config/devices.h"
#include "config/include.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/bringup/bringup.h"
#include "print/exit_codes.h"
#include "print/folder/run_seal.h"
#include "print/folder/running.h"
#include "print/interrupt.h"
#include "print/labs/print_labs.h"
#include "print/live/bus_port.h"
#include "print/live/detached.h"
#include "print/preview/print_preview.h"
#include "print/simulated/lab_fault.h"

namespace firn {
namespace {

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
std::string bringup_state(const Experiment& e, const PrintOptions& options) {
  nlohmann::ordered_json j{{"accepted", options.accept_bringup}, {"file", options.bringup}};
  std::vector<std::string> nodes;
  for (const auto& [node, address] : real_ports(e)) nodes.push_back(node);
  j["assumptions"] = assumptions_json(e, nodes);
  if (std::filesystem::exists(options.bringup))
    j["result"] = nlohmann::ordered_json::parse(read_file(options.bringup));
  return j.dump(2) + "\n";
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

}  // namespace

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
    for (const OperatorOrder& o : orders_with_resume(options))
      if (const std::string problem =
              o.verb == OperatorVerb::kSet ? change_problem(e, o.key, o.value) : std::string();
          !problem.empty())
        throw UsageError("--resume --set: " + problem);
    if (options.detach) return detach(run.path(), options);
    summary = carry_out_print(run, e, options, true);
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
    if (!real_ports(e).empty()) {
      check_bringup(e, whole);
      whole.bringup_state = bringup_state(e, whole);
    }
    const PrintPreview preview = preview_print(e, inputs, file.parent_path());
    std::fputs(preview_text(preview).c_str(), stderr);
    if (options.detach) {
      check_request(e, inputs, whole);
      slow_to_rows(e, whole);
      PrintOptions again = whole;
      again.overrides.clear();
      return detach(make_run_folder(e, inputs, whole).path(), again);
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
