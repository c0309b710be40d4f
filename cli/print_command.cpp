#include "cli/print_command.h"

#include <fmt/core.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

#include "cli/commands.h"
#include "cli/notify.h"
#include "cli/option_set.h"
#include "cli/print_show.h"
#include "cli/use_warning.h"
#include "cli/user_config.h"
#include "config/changes.h"
#include "config/devices.h"
#include "config/include.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/bringup/bringup.h"
#include "print/inputs/part_experiment.h"
#include "print/interrupt.h"
#include "print/live/detached.h"
#include "print/preview/print_preview.h"
#include "print/process/bus_port.h"
#include "print/simulated/lab_fault.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/origin.h"
#include "runtime/source_folder.h"

namespace firn {
namespace {

constexpr double kForetellWithin_s = 3.0;

// Lease, resend and heartbeat stay in wall time; above ten, an instrument's second is too short for them.
void check_speedup(const PrintOptions& o) {
  constexpr double kMax = 10.0;
  if (o.speedup == 0.0) return;
  if (!o.resume.empty()) throw UsageError("--speedup cannot change a run that has begun; start a new one");
  if (o.bus == "in-process")
    throw UsageError(
        "--speedup: a print in one process has no clock to run ahead of: it goes as fast as it can");
  if (!(o.speedup >= 1.0 && o.speedup <= kMax))
    throw UsageError(
        fmt::format("--speedup {}: a live print can go 1 to {} times as fast as the clock; --bus in-process "
                    "goes as fast as it can",
                    o.speedup, kMax));
}

// Real instruments are brought up before they print: LAB.bringup.json beside a file of the experiment, or in
// the folder of the run that goes on.
std::string bringup_beside(const std::filesystem::path& experiment) {
  std::string found = bringup_file(experiment.string());
  for (const auto& [file, text] : read_with_includes(experiment))
    if (const std::string beside = bringup_file(file); std::filesystem::exists(beside)) found = beside;
  return found;
}

// A cable that is off is named before anything begins, not when the scheduler has waited for its instrument.
void check_ports(const Experiment& e, const PrintOptions& options) {
  if (options.bus == "in-process") return;
  if (const std::string why = closed_ports(e); !why.empty())
    throw UsageError(why + "; nothing was begun: look at power, cable and devices.NODE.port");
}

void check_bringup(const Product& product, const Experiment& e, const PrintOptions& options) try {
  const auto state = read_bringup(options.bringup);
  if (const std::string why = bringup_refusal(e, state, options.bringup, options.accept_bringup);
      !why.empty())
    throw UsageError(why);
  check_ports(e, options);
  const InterruptGuard guard;
  if (const std::string why = identity_refusal(
          product, e, std::filesystem::path(options.experiment).parent_path(), state.value_or(BringupState{}),
          options.bringup, options.accept_bringup, [] { return InterruptGuard::raised(); });
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

// Writes the experiment file of a picture or a mesh into the working folder, and has it printed in its place.
class PartAsExperiment {
 public:
  explicit PartAsExperiment(PrintOptions& options) {
    if (!names_part(options.experiment)) {
      if (options.height_mm > 0.0 || options.width_mm > 0.0 || !options.lab.empty())
        throw UsageError(
            "--height, --width and --lab are of a picture or a mesh; an experiment file has them as keys, "
            "such as "
            "--set part.height_mm=0.1");
      return;
    }
    const std::filesystem::path part = options.experiment;
    file_ = part.stem().string() + ".toml";
    const std::string lab =
        options.lab.empty() ? (source_folder() / "labs/inkjet-lu2015.toml").string() : options.lab;
    const std::string text = experiment_of_part({part, lab, options.height_mm, options.width_mm}, ".");
    if (!std::filesystem::exists(file_)) {
      write_file_atomically(file_, text);
      is_new_ = true;
    } else if (read_file(file_) != text) {
      throw UsageError(file_.string() +
                       ": is there already, with another content; print it, or move it away");
    }
    options.experiment = file_.string();
  }
  /// The print can begin: the file stays.
  void keep() {
    if (is_new_)
      fmt::print(stderr, "wrote {}: the experiment; change it and print it again as you like\n",
                 file_.string());
    is_new_ = false;
  }
  ~PartAsExperiment() {
    std::error_code ignored;
    if (is_new_) std::filesystem::remove(file_, ignored);
  }
  PartAsExperiment(const PartAsExperiment&) = delete;
  PartAsExperiment& operator=(const PartAsExperiment&) = delete;

 private:
  std::filesystem::path file_;
  bool is_new_ = false;
};

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
  if (options.is_public) words.push_back("--public");
  if (options.unsealed) words.push_back("--unsealed");
  if (options.run_python) words.push_back("--run-python");
  const DetachedPrint print = start_detached(run, words);
  if (options.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"run", run.string()}, {"pid", print.pid}}.dump(2));
  else
    fmt::print("run folder {}, pid {}\nto watch it: firn attach {}\n", run.string(), print.pid, run.string());
  return kOk;
}

}  // namespace

PrintEnd carry_out(const Product& product, const PrintOptions& given) {
  PrintOptions options = given;
  const UserConfig user = read_user_config();
  if (options.experiment.empty() == options.resume.empty())
    throw UsageError("give either an experiment file or --resume RUN");
  check_bus(options.bus);
  if (options.record && options.bus == "in-process")
    throw UsageError("--record: --bus in-process has no ports to record");
  if (options.page && options.bus == "in-process")
    throw UsageError("--page: --bus in-process is over before anybody looks; firn view RUN shows it then");
  if (!options.resume.empty() && !options.meta.empty())
    throw UsageError("--meta: the run has begun with its own; firn runs note " + options.resume +
                     " \"...\" adds to it");
  if (options.page && options.no_page) throw UsageError("--page and --no-page: one of them");
  check_speedup(options);
  std::signal(SIGPIPE, SIG_IGN);  // a reader that has gone does not end the print
  PrintSummary summary;
  if (!options.resume.empty()) {
    runs::require_run(options.resume);
    std::optional<runs::RunLock> lock(std::in_place, options.resume, runs::RunUse::kPrint);
    const runs::RunFolder run = runs::RunFolder::open(options.resume);
    runs::require_own_resume(options.resume, options.run_python);
    const auto result = run.result();
    if (result && !runs::can_go_on(*result) && runs::seal_end(run.path(), result->outcome)) {
      fmt::print(stderr, "{}: the end of this run had no seal; it is sealed as found\n", options.resume);
      return {result->status, options.resume, ""};
    }
    if (result && !runs::can_go_on(*result))
      throw UsageError(options.resume + ": this run has finished (" + for_people(result->reason) + ")");
    const Experiment e = parse_experiment(run.experiment_toml(), run.experiment_path().string());
    for (const OperatorOrder& o : orders_with_resume(options))
      if (const std::string problem =
              o.verb == OperatorVerb::kSet ? change_problem(e, o.key, o.value) : std::string();
          !problem.empty())
        throw UsageError("--resume --set: " + problem);
    check_ports(e, options);
    if (options.detach) {
      lock.reset();  // the print takes it, and looks again
      return {detach(run.path(), options), options.resume, ""};
    }
    summary = carry_out_print(product, run, e, options, true, *lock);
  } else {
    PartAsExperiment part(options);
    const std::filesystem::path file = options.experiment;
    std::vector<std::string> overrides = options.overrides;
    if (options.speedup > 0.0) overrides.push_back(fmt::format("run.time_scale={}", options.speedup));
    for (const std::string& assignment : options.meta) overrides.push_back("meta." + assignment);
    name_operator(file, overrides);
    Experiment e = load_experiment(file, overrides);
    const PrintMeta meta = load_meta(file, overrides);
    require_meta(meta);
    options.meta_values = meta.values;
    parse_lab_faults(options.faults, e);  // before anything is written
    const Blobs inputs = make_inputs(product, e, file.parent_path());
    complete_experiment(product, e, inputs);
    PrintOptions whole = options;
    if (whole.bringup.empty()) whole.bringup = bringup_beside(file);
    if (!real_ports(e).empty()) {
      check_bringup(product, e, whole);
      whole.bringup_state = bringup_state(e, whole);
    }
    part.keep();
    warn_of_use(meta.use, meta.values, e, options.runs);
    PrintPreview preview = preview_print(e, inputs, file.parent_path());
    if (const auto foretold = foretell(product, e, inputs, kForetellWithin_s)) {
      take_foretold(*foretold, e, preview);
      whole.foretold_layer_s = foretold->layer_s;
    }
    std::fputs(preview_text(preview).c_str(), stderr);
    if (options.detach) {
      check_request(product, e, inputs, whole);
      slow_to_rows(e, whole);
      PrintOptions again = whole;
      again.overrides.clear();
      again.meta.clear();
      const std::filesystem::path run = make_run_folder(e, inputs, whole).path();
      return {detach(run, again), run.string(), ""};
    }
    summary = print_experiment(product, e, inputs, whole);
  }
  std::fputs((options.json ? print_json(summary) : print_text(summary)).c_str(), stdout);
  std::fflush(stdout);
  if (!user.notify.empty()) send_notice(user.notify, notice_of(summary));
  pack_print(summary, options);
  return {summary.result.status, summary.folder, last_line(summary.result, summary.words, summary.folder)};
}

int run_print(const Product& product, const PrintOptions& options) {
  return carry_out(product, options).code;
}

void declare_print(OptionSet& options) {
  auto& o = options.calls(run_print);
  options.option("EXPERIMENT", o.experiment, "experiment file; or a grey PNG or a mesh, with --height");
  options
      .option("--height", o.height_mm,
              "MM: of a picture's white, or of a mesh; ice: layers above are left out")
      .above_zero();
  options
      .option("--width", o.width_mm,
              "MM: of a picture or a mesh along x; default: as large as the grid allows")
      .above_zero();
  options.option("--lab", o.lab, "lab that prints a picture or a mesh; default: labs/inkjet-lu2015.toml");
  options.option("--resume", o.resume, "go on with the interrupted run in this folder");
  options.option("--bus", o.bus, "in-process, or an LCM URL of loopback; default: a port of the run's own");
  options.override_option(o.overrides);
  options
      .option("--meta", o.meta,
              "KEY=VALUE: what is printed, operator, project, sample, substrate, ink, batch or a key of your "
              "own; docs/commands/print.md")
      .one_value_each();
  options
      .option("--speedup", o.speedup,
              "live: node time runs so many times faster than the clock, 1 to 10; default run.time_scale")
      .above_zero();
  options
      .option("--fault", o.faults,
              "\"SECONDS PORT KIND [COUNT [DELAY_US]]\": what befalls a simulated instrument; docs/ice.md")
      .one_value_each();
  options.runs_option(o.runs, "where run folders go");
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
  options.flag("--public", o.is_public, "of the page: who reaches it may read without the token");
  options.flag("--page", o.page, "show the print in a browser too; default with a terminal; docs/page.md");
  options.flag("--no-page", o.no_page, "do not");
  options.flag("--unsealed", o.unsealed,
               "with --resume: go on though the run folder is not as it was sealed; the next seal says so");
  options.flag(
      "--run-python", o.run_python,
      "with --resume: run the code in a run of another user or host: Python, commands, what is on its hosts; "
      "docs/security.md");
  options.json_flag(o.json);
}

}  // namespace firn
