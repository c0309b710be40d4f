#include "cli/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "cli/audit_command.h"
#include "cli/calibrate_command.h"
#include "cli/compare_command.h"
#include "cli/config_command.h"
#include "cli/dataflow_command.h"
#include "cli/decide_command.h"
#include "cli/demo_command.h"
#include "cli/doctor_command.h"
#include "cli/identify_command.h"
#include "cli/log_command.h"
#include "cli/plan_command.h"
#include "cli/print_command.h"
#include "cli/replay_command.h"
#include "cli/report_command.h"
#include "cli/slice_command.h"
#include "cli/spy_command.h"
#include "cli/tune_command.h"
#include "config/fields.h"
#include "files/nearest.h"
#include "files/usage_error.h"
#include "print/exit_codes.h"
#include "runtime/build_info.h"
#include "studies/reproduce/reproduce.h"

namespace firn {
namespace {

using Run = std::function<int()>;

/// A number above 0; CLI11's own says so by writing the largest double out.
CLI::Validator above_zero() {
  return {[](const std::string& text) {
            double number = 0.0;
            const bool read = CLI::detail::lexical_cast(text, number);
            return read && number > 0.0 && std::isfinite(number) ? std::string()
                                                                 : text + " is not a number above 0";
          },
          "above 0"};
}

/// Binds a command's options struct to its parser; the struct lives as long as the call.
template <class Options>
std::shared_ptr<Options> bind(CLI::App& app, Run& run, int (*command)(const Options&)) {
  auto options = std::make_shared<Options>();
  app.final_callback([&run, options, command] { run = [options, command] { return command(*options); }; });
  return options;
}

void json_flag(CLI::App& app, bool& json) { app.add_flag("--json", json, "machine-readable output"); }

void declare_config(CLI::App& app, Run& run) {
  const auto common = [&run](CLI::App& sub, ConfigAction action) {
    auto o = bind(sub, run, run_config);
    o->action = action;
    json_flag(sub, o->json);
    return o;
  };
  const auto with_file = [&](const char* name, const char* help, ConfigAction action) {
    CLI::App& sub = *app.add_subcommand(name, help);
    auto o = common(sub, action);
    sub.add_option("FILE", o->file, "experiment")->required();
    sub.add_option("--set", o->overrides, "KEY=VALUE, after the file")->allow_extra_args(false);
  };
  with_file("check", "names the first mistake of an experiment", ConfigAction::kCheck);
  with_file("dump", "every key of an experiment with its resolved value", ConfigAction::kDump);
  CLI::App& docs =
      *app.add_subcommand("docs", "writes docs/configuration.md, docs/machines.md or docs/slice-settings.md");
  auto o = common(docs, ConfigAction::kDocs);
  docs.add_flag("--machines", o->machines, "the keys of machine files");
  docs.add_flag("--slice", o->slice, "the settings of firn slice");
  docs.add_option("-o,--output", o->output, "file; - = stdout; default: the file in docs/");
  app.require_subcommand(1);
}

void declare_dataflow(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_dataflow);
  app.add_option("-o,--output", o->output, "file; - = stdout")->capture_default_str();
  json_flag(app, o->json);
}

void declare_doctor(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_doctor);
  json_flag(app, o->json);
}

void declare_replay(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_replay);
  app.add_option("RUN", o->run, "run folder")->required();
  app.add_option("--node", o->node, "this node only");
  app.add_option("--tolerance", o->tolerance, "numbers that differ by no more are equal");
  app.add_option("--ignore", o->ignores,
                 "FIELD=reason: may differ; FIELD is LAYER_PLAN.iterations or iterations")
      ->allow_extra_args(false);
  app.add_option("--set", o->overrides, "KEY=VALUE, replays with a changed configuration")
      ->allow_extra_args(false);
  app.add_option("--threads", o->threads, "0 = as many as the machine has")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  json_flag(app, o->json);
}

void declare_audit(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_audit);
  app.add_option("RUN", o->run, "run folder")->required();
  json_flag(app, o->json);
}

void declare_calibrate(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_calibrate);
  std::string names;
  for (const std::string_view name : lab_calibration_names())
    names += (names.empty() ? "" : ", ") + std::string(name);
  app.add_option("RUN", o->run, "run folder of a registration print; or, in the simulated ice lab: " + names)
      ->required();
  app.add_option("LAB", o->lab.lab, "lab or experiment file of the ice lab")->capture_default_str();
  app.add_option("-o,--output", o->output,
                 "proposal for the lab file; default: RUN/jet_b.toml, LAB with .proposed.toml");
  app.add_flag("--write", o->lab.write, "into LAB itself");
  app.add_option("--valve", o->lab.valve, "valve-latency, flow-curve: a (water) or b (scaffold)")
      ->capture_default_str()
      ->check(CLI::IsMember({"a", "b"}));
  app.add_option("--repeats", o->lab.run.repeats,
                 "passes or weighings of each kind; default: the calibration's own")
      ->check(CLI::Range(1, 1000));
  app.add_option("--speeds", o->lab.run.speeds_mm_s, "S,S,... [mm/s] of its passes")
      ->delimiter(',')
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option("--frequencies", o->lab.run.frequencies_hz,
                 "flow-curve: F,F,... [Hz]; default: 20 up to a pulse a tick")
      ->delimiter(',')
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option("--rounds", o->lab.run.rounds, "level-table: so often turned as told and measured again")
      ->capture_default_str()
      ->check(CLI::Range(1, 20));
  app.add_option("--seed", o->lab.run.seed, "of where passes begin and the order of things")
      ->capture_default_str();
  app.add_option("--plot", o->lab.plot, "residuals, SVG");
  app.add_option("--set", o->lab.overrides, "KEY=VALUE, after the file")->allow_extra_args(false);
  json_flag(app, o->json);
}

void declare_report(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_report);
  app.add_option("RUN", o->runs, "run folders")->required();
  app.add_option("-o,--output", o->output, "HTML file")->capture_default_str();
  app.add_flag("--no-replay", o->no_replay,
               "do not replay the runs for a verdict: seconds instead of minutes for long ones");
  json_flag(app, o->json);
}

void declare_reproduce(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_reproduce);
  app.add_option("PAPER", o->paper, "lu, barnett or thompson; default: all");
  app.add_option("--only", o->only, "parts or rows, by id");
  app.add_option("-o,--out", o->out, "folder for pictures and index.html");
  app.add_option("--mesh", o->mesh, "barnett.slicing: a mesh instead of the one made in code");
  app.add_flag("--quick", o->quick, "fewer repeats: minutes become seconds, statistics become coarse");
  app.add_option("--threads", o->threads, "0 = as many as the machine has")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  json_flag(app, o->json);
}

void declare_identify(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_identify);
  app.add_option("RUN", o->runs, "run folder; with --spacing several, each at another spacing of droplets")
      ->required();
  app.add_flag("--spacing", o->spacing, "chooses the spacing of droplets from prints of squares");
  app.add_option("--diameter", o->diameter_mm, "with --spacing: droplet diameter [mm]")
      ->capture_default_str();
  app.add_option("-o,--output", o->output, "picture, SVG");
  json_flag(app, o->json);
}

void declare_tune(CLI::App& app, Run& run) {
  CLI::App& smf =
      *app.add_subcommand("smf", "gains of surface-mapping feedback that make the RMS error least");
  auto o = bind(smf, run, run_tune_smf);
  smf.add_option("RUN", o->run, "run folder whose disturbance is taken; without it, the model below");
  auto& m = o->model;
  m.pulse = 0.5, m.step = 0.2;
  smf.add_option("--intervals", m.intervals, "measurement intervals")->capture_default_str();
  smf.add_option("--pulse", m.pulse, "pulse disturbance d_p [intervals]")->capture_default_str();
  smf.add_option("--pulse-at", m.pulse_at, "its interval k_p")->capture_default_str();
  smf.add_option("--step", m.step, "step disturbance d_s [intervals]")->capture_default_str();
  smf.add_option("--step-at", m.step_at, "its first interval k_s")->capture_default_str();
  smf.add_option("--random", m.random, "random disturbance d_r [intervals]")->capture_default_str();
  smf.add_option("--seed", m.seed, "of the random disturbance")->capture_default_str();
  smf.add_option("--algorithm", o->algorithm, "slsqp, lbfgs or cobyla")->capture_default_str();
  smf.add_option("--start", o->start, "K_p,K_i*,K_d* to start from")->delimiter(',')->capture_default_str();
  smf.add_flag("--derivative-only", o->derivative_only, "K_p and K_i* stay at their start (5.39)");
  smf.add_option("-o,--output", o->output, "picture of error and action, SVG");
  json_flag(smf, o->json);
  app.require_subcommand(1);
}

void declare_log(CLI::App& app, Run& run) {
  const auto sub = [&](const char* name, const char* help, LogAction action) {
    CLI::App& s = *app.add_subcommand(name, help);
    auto o = bind(s, run, run_log);
    o->action = action;
    s.add_option("LOG", o->file, "log.lcm, nodes/<node>.wal or world.rec")->required();
    if (action != LogAction::kCat) json_flag(s, o->json);
    return std::pair(&s, o);
  };
  sub("verify", "checksums, gaps and limits; exit 1 if anything is damaged", LogAction::kVerify);
  auto [cat, c] = sub("cat", "one JSON object per event or record", LogAction::kCat);
  cat->add_option("-c,--channel", c->channels, "only this channel; may be repeated")->allow_extra_args(false);
  cat->add_option("--from", c->from_s, "first node time [s]");
  cat->add_option("--to", c->to_s, "last node time [s]");
  cat->add_option("-n,--count", c->count, "at most so many lines");
  cat->add_flag("--full", c->full, "whole arrays");
  auto [repair, r] = sub("repair", "fills gaps from the write-ahead files", LogAction::kRepair);
  repair->add_option("--sources", r->sources, "folder of write-ahead files; default: nodes/ beside the log");
  app.require_subcommand(1);
}

void declare_print(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_print);
  app.add_option("EXPERIMENT", o->experiment, "experiment file");
  app.add_option("--resume", o->resume, "go on with the interrupted run in this folder");
  app.add_option("--bus", o->bus, "in-process, or an LCM URL; default: loopback, a port of the run's own");
  app.add_option("--set", o->overrides, "KEY=VALUE, after the file")->allow_extra_args(false);
  app.add_option("--speedup", o->speedup,
                 "live: node time runs so many times faster than the clock, 1 to 10; default run.time_scale")
      ->check(above_zero());
  app.add_option("--fault", o->faults,
                 "\"SECONDS PORT KIND [COUNT [DELAY_US]]\": what befalls a simulated instrument; docs/ice.md")
      ->allow_extra_args(false);
  app.add_option("--runs", o->runs, "where run folders go")->capture_default_str();
  app.add_option("--tolerance", o->tolerance_um,
                 "UM: exit code 1 if the last map's RMS is above; default: one nominal layer, told and not "
                 "decisive; docs/print.md")
      ->check(above_zero());
  app.add_flag("--accept-doubt", o->accept_doubt,
               "with --resume: go on though droplets of the open loop are in doubt");
  json_flag(app, o->json);
}

void declare_plan(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_plan);
  app.add_option("PATHS", o->paths, "*.csv, *.json or *.paths; docs/plan.md")->required();
  app.add_option("-o,--output", o->output, "trajectory file");
  app.add_option("--machine", o->machine, "machine file, as labs/cobra600.toml")->required();
  app.add_option("--origin", o->origin_mm, "X,Y [mm]: where the paths' frame stands in the machine's")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--method", o->method, "certified, optimal, thesis, constant or default")
      ->capture_default_str();
  app.add_option("--fill-speed", o->fill_mm_s, "of straight fill with method constant [mm/s]: 100 or 125")
      ->capture_default_str();
  app.add_option("--tolerance", o->tolerance_mm,
                 "corners may be rolled within so many mm; default 0, of an aerosol machine 0.05");
  app.add_option("--ramp", o->curvature_ramp_mm, "every jump of curvature is ramped over so many mm")
      ->capture_default_str();
  app.add_option("--corner", o->corner, "of an aerosol machine: paper, loop (default) or hybrid");
  app.add_option("--csv", o->csv, "t_s,x_mm,y_mm,joint_1,joint_2 at the tick");
  app.add_option("--pulses", o->pulses, "valve pulses of each path: path,list,start_s,tick");
  app.add_option("--plot", o->plot, "SVG: speed, acceleration, jerk, joints, the path coloured by speed");
  app.add_option("--plot-path", o->plot_path, "number of the path to draw")->capture_default_str();
  app.add_option("--threads", o->threads, "0 = as many as the machine has")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  json_flag(app, o->json);
}

void declare_slice(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_slice);
  app.add_option("MESH", o->meshes, "*.stl, *.ply, *.obj or *.3mf; each is a part")->required();
  app.add_option("-o,--output", o->output, "path file, for firn plan: docs/path-format.md");
  app.add_option("-c,--config", o->config, "settings: docs/slice-settings.md");
  app.add_option("--set", o->overrides, "KEY=VALUE, after the file")->allow_extra_args(false);
  app.add_option("--support", o->support, "full, none, or overhang ANGLE [deg from the vertical]");
  app.add_option("--tolerance", o->tolerance_mm,
                 "no path leaves its exact place by more [mm]; 0 keeps every point");
  app.add_option("--gcode", o->gcode, "for other printers and viewers");
  app.add_option("--layer", o->layers, "to be pictured; several make a contact sheet: 10,50,100")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--svg", o->svg, "picture of --layer");
  app.add_option("--png", o->png, "the same");
  app.add_option("--png-width", o->png_width, "pixels")->capture_default_str();
  app.add_option("--layer-json", o->layer_json, "the paths of --layer, as firn plan reads them");
  app.add_option("--threads", o->threads, "0 = as many as the machine has; the bytes do not depend on it")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  json_flag(app, o->json);
}

void declare_demo(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_demo);
  app.add_option("--bus", o->bus, "in-process, or an LCM URL; default: loopback, a port for each run");
  app.add_option("--set", o->overrides, "KEY=VALUE, for every scheme")->allow_extra_args(false);
  app.add_option("--runs", o->runs, "where run folders go")->capture_default_str();
  app.add_option("-o,--output", o->output, "report; default: report.html in the last run's folder");
  json_flag(app, o->json);
}

void declare_spy(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_spy);
  app.add_option("RUN", o->run, "folder of a live print; default: the newest that goes on");
  app.add_option("--runs", o->runs, "where run folders are")->capture_default_str();
  app.add_option("--bus", o->bus, "LCM URL instead of a run");
  app.add_option("--screenshot", o->screenshot, "PNG of the screen, then the end; needs no display");
  app.add_option("--layers", o->layers, "seen before the screenshot")->capture_default_str();
}

void declare_compare(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_compare);
  app.add_option("STUDY", o->study, "study file")->required();
  app.add_option("-o,--output", o->output, "study folder; default: runs/study-NAME");
  app.add_option("--seeds", o->seeds, "seeds 1..N instead of the study's")->check(CLI::Range(1, 1000000));
  app.add_option("--set", o->overrides, "KEY=VALUE, for every print")->allow_extra_args(false);
  app.add_option("--threads", o->threads, "0 = as many as the machine has")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  json_flag(app, o->json);
}

void declare_decide(CLI::App& app, Run& run) {
  auto o = bind(app, run, run_decide);
  app.add_option("--height", o->height, "NPY of the surface [mm], rows along x")->required();
  app.add_option("--target", o->target, "NPY of the wanted heights [mm]")->required();
  app.add_option("--mask", o->mask, "NPY, 1 = the part; default: every cell");
  app.add_option("--model", o->model,
                 "TOML with [model], and [control] if wanted; default: Lu's Table I, mpc");
  app.add_option("--set", o->overrides, "KEY=VALUE, after the file")->allow_extra_args(false);
  app.add_option("--alpha", o->alpha, "weight of the mean error, (0, 1]");
  app.add_option("--horizon", o->horizon, "N");
  app.add_option("--method", o->method, "greedy, descent, strip-dp or certified");
  app.add_flag("--bound", o->bound, "prove how much better any layer could be (N = 1)");
  app.add_option("--bound-rows", o->bound_rows, "rows per strip, 1..4: tighter and dearer")
      ->capture_default_str();
  app.add_option("--bound-sweeps", o->bound_sweeps, "down or up, at most")->capture_default_str();
  app.add_option("--certificate", o->certificate, "NPY of the bound's multipliers, written");
  app.add_option("--check-certificate", o->check_certificate,
                 "NPY of multipliers: prints the bound that they prove, nothing else");
  app.add_option("-o,--output", o->output, "NPY of the droplets");
  app.add_option("--threads", o->threads, "0 = as many as the machine has; the same bytes for any number")
      ->capture_default_str();
  json_flag(app, o->json);
}

struct Command {
  const char* name;
  const char* help;
  void (*declare)(CLI::App&, Run&);
};

// In the reader's order; a new command is one row, one declare_ function and its cli/<name>_command.{h,cpp}.
constexpr Command kCommands[] = {
    {"demo", "prints a cylinder under each scheme, replays the runs, writes a report", declare_demo},
    {"print", "prints an experiment, live or in one process; resumes", declare_print},
    {"slice", "slices meshes into deposition paths with scaffold, fills and G-code", declare_slice},
    {"plan", "plans certified minimum-time trajectories along paths", declare_plan},
    {"replay", "replays a run bit for bit, or names the first divergence", declare_replay},
    {"spy", "watches a live print: lcm-spy with Firn's types, height map and layer error", declare_spy},
    {"doctor", "what this machine lacks for live prints, and the mend", declare_doctor},
    {"calibrate", "measures where tools stand, when they act and what valves give; levels the table",
     declare_calibrate},
    {"audit", "checks a run's droplets against the world's own record", declare_audit},
    {"identify", "h1, h2, h3 with intervals from a run; the spacing of droplets from prints of squares",
     declare_identify},
    {"tune", "tunes gains for a disturbance, given or found in a run", declare_tune},
    {"report", "writes one self-contained page for any number of runs", declare_report},
    {"reproduce", "sets every table and figure of the papers beside ours", declare_reproduce},
    {"decide", "decides one layer on any surface, with a proof of how good it is", declare_decide},
    {"compare", "compares schemes over parts and seeds: which is better, by how much, how sure",
     declare_compare},
    {"log", "verifies, prints and repairs logs and write-ahead files", declare_log},
    {"config", "checks, resolves and documents experiment files", declare_config},
    {"dataflow", "writes docs/dataflow.md: who sends what to whom", declare_dataflow},
};

std::vector<std::string_view> command_names() {
  std::vector<std::string_view> names;
  for (const Command& c : kCommands) names.push_back(c.name);
  return names;
}

Call printed(const std::string& text) {
  return {"", [text] {
            std::fputs(text.c_str(), stdout);
            return int(kOk);
          }};
}

Call refused(const CLI::App& app, const std::string& command, std::string problem) {
  for (char& c : problem)
    if (c == '\n') c = ' ';
  const std::string help =
      "\n(" + app.get_name() + (command.empty() ? "" : " " + command) + " --help lists what there is)";
  return {command, [problem, help]() -> int { throw UsageError(problem + help); }};
}

}  // namespace

Call parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Closed-loop additive manufacturing: print, measure, decide, record, replay.", "firn");
  app.set_version_flag("--version", std::string("firn ") + build_commit());
  app.require_subcommand(1);
  Run run;
  for (const Command& c : kCommands) c.declare(*app.add_subcommand(c.name, c.help), run);

  std::string command;
  const auto chosen = [&] {
    command.clear();
    for (const CLI::App* a = &app; !a->get_subcommands().empty();) {
      a = a->get_subcommands().front();
      command += (command.empty() ? "" : " ") + a->get_name();
    }
  };
  const std::vector<std::string_view> names = command_names();
  if (const std::string word = argc > 1 ? argv[1] : "";
      !word.empty() && word[0] != '-' && std::find(names.begin(), names.end(), word) == names.end()) {
    const std::string near = nearest(word, names);
    return refused(
        app, "",
        "unknown command '" + word + "'" + (near.empty() ? "" : "; the nearest known one is " + near));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return printed(app.help());
  } catch (const CLI::CallForVersion&) {
    return printed(app.version() + "\n");
  } catch (const CLI::ParseError& e) {
    chosen();
    return refused(app, command, e.what());
  }
  chosen();
  return {command, run};
}

}  // namespace firn
