// run_demo prints a cylinder under each scheme, replays every run and writes one report.
#include "cli/commands.h"

#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/print_run.h"
#include "cli/replay_command.h"
#include "cli/report_command.h"
#include "cli/side_by_side.h"
#include "config/include.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "print/live/bus_check.h"
#include "replay/print_verdict.h"
#include "runtime/source_folder.h"

namespace firn {
namespace {

struct DemoOptions {
  std::string bus;  ///< as PrintOptions
  std::string runs = "runs";
  std::string output;                  ///< of the report; "" = report.html in the last run's folder
  std::vector<std::string> overrides;  ///< --set KEY=VALUE, for every scheme
  bool json = false;
};

constexpr const char* kSchemes[] = {"mpc", "open_loop", "smf"};
constexpr double kLayerNodeS =
    12.0;  // node time that a layer of the demo takes: budget, docs/measurements.md

// Announces the prints and their duration.
void announce(const Experiment& e, const std::string& bus) {
  const ModelConfig& h = e.model;
  const int layers = int(std::ceil(e.part.shape.height_mm / (h.h1_mm + 4 * h.h2_mm + 4 * h.h3_mm)));
  if (bus == "in-process") {
    fmt::print(
        stderr,
        "firn demo: a {} of {} layers or a few more under {} schemes, in one process and in simulated time\n",
        e.part.shape.kind, layers, std::size(kSchemes));
    return;
  }
  const double layer_s = kLayerNodeS / e.run.time_scale;
  fmt::print(stderr,
             "firn demo: a {} of {} layers or a few more under {} schemes, live{}; at {:g} times node time a "
             "layer takes about "
             "{:.1f} s, all together about {:.0f} s\n",
             e.part.shape.kind, layers, std::size(kSchemes), bus.empty() ? " and at once" : "",
             e.run.time_scale, layer_s, layer_s * layers * 1.2 * (bus.empty() ? 1.0 : std::size(kSchemes)));
}

struct Printed {
  PrintSummary print;
  replay::RunVerdict replay;
};

// Each live print has a bus and a lab of its own and waits for its instruments most of the time: all go at
// once.
std::vector<PrintSummary> carry_out(const std::vector<LivePrint>& prints, const std::string& bus) {
  if (bus.empty()) return print_side_by_side(prints);
  std::vector<PrintSummary> done;
  for (const LivePrint& print : prints) {
    done.push_back(print.carry_out());
    if (runs::can_go_on(done.back().result)) break;
  }
  return done;
}

void show(const std::vector<Printed>& all) {
  fmt::print("{:<10} {:>7} {:>9} {:>12} {:>10} {:>10} {:>9}  {:<10} end\n", "scheme", "layers", "droplets",
             "mean [um]", "RMS [um]", "std [um]", "wall [s]", "replay");
  for (const Printed& p : all) {
    const runs::MapError error = p.print.result.error.value_or(runs::MapError{});
    fmt::print("{:<10} {:>7} {:>9} {:>+12.2f} {:>10.2f} {:>10.2f} {:>9.1f}  {:<10} {}\n", p.print.scheme,
               p.print.result.layers, p.print.droplets, error.mean_um, error.rms_um, error.std_um,
               p.print.wall_s, p.replay.identical() ? "identical" : "DIFFERS", p.print.result.outcome);
  }
}

/// @returns 0 if every print finished and every run replays identical, 1 if one does not, 3 after a safety
/// stop
int run_demo(const Product& product, const DemoOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  const std::filesystem::path file = source_folder() / "experiments/demo.toml";
  PrintOptions print;
  print.bus = options.bus;
  print.runs = options.runs;
  if (print.bus.empty()) {
    if (const std::string why = check_multicast(); !why.empty()) {
      fmt::print(stderr, "firn demo: no live bus on this machine, so the demo runs in one process: {}\n",
                 why);
      print.bus = "in-process";
    }
  }
  announce(load_experiment(file, options.overrides), print.bus);
  std::vector<LivePrint> prints;
  for (const char* scheme : kSchemes) {
    std::vector<std::string> overrides = options.overrides;
    overrides.push_back(std::string("control.scheme=") + scheme);
    prints.push_back({std::string("firn demo: ") + scheme,
                      [&product, &print, &file, e = load_experiment(file, overrides)] {
                        return print_experiment(product, e, make_inputs(product, e, file.parent_path()),
                                                print);
                      }});
  }
  std::vector<Printed> all;
  std::vector<std::string> folders;
  int status = kOk;
  for (PrintSummary& p : carry_out(prints, print.bus)) {
    if (runs::can_go_on(p.result)) {
      fmt::print(stderr, "firn demo: {}: {}: {}; run folder {}\n", p.scheme, p.result.outcome,
                 for_people(p.result.reason), p.folder);
      return p.result.status;
    }
    folders.push_back(p.folder);
    all.push_back({std::move(p), {}});
  }
  std::uint64_t nodes = 0, steps = 0, messages = 0;
  for (Printed& p : all) {
    ReplayCommandOptions r;
    r.run = p.print.folder;
    p.replay = replay_verdict(product, r);
    if (!p.replay.identical()) {
      status = kFailed;
      std::fputs(replay::to_text(p.replay).c_str(), stderr);
    }
    nodes += p.replay.nodes.size();
    for (const auto& n : p.replay.nodes) {
      steps += n.steps;
      messages += n.messages;
    }
  }
  ReportOptions report;
  report.runs = folders;
  report.output = options.output.empty() ? RunPaths(folders.back()).report_path().string() : options.output;
  report.verdicts.reserve(all.size());
  for (const Printed& p : all) report.verdicts.push_back(p.replay.identical() ? "identical" : "differs");
  write_report(product, report);

  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  if (options.json) {
    nlohmann::ordered_json j;
    for (const Printed& p : all) {
      const runs::MapError error = p.print.result.error.value_or(runs::MapError{});
      j["runs"].push_back({{"run", p.print.folder},
                           {"scheme", p.print.scheme},
                           {"outcome", p.print.result.outcome},
                           {"layers", p.print.result.layers},
                           {"droplets", p.print.droplets},
                           {"mean_error_um", error.mean_um},
                           {"rms_um", error.rms_um},
                           {"std_um", error.std_um},
                           {"wall_s", p.print.wall_s},
                           {"identical", p.replay.identical()}});
    }
    j["replayed"] = {{"nodes", nodes}, {"steps", steps}, {"messages", messages}};
    j["report"] = report.output;
    j["wall_s"] = wall_s;
    std::puts(j.dump(2).c_str());
  } else {
    show(all);
    fmt::print("replayed {} nodes, {} steps, {} messages: {}\n", nodes, grouped(steps), grouped(messages),
               status == kOk ? "identical" : "they DIFFER (see above)");
    fmt::print("report: {}\n{:.1f} s in all\nin a browser: ./firn view {}\n", report.output, wall_s,
               options.runs);
  }
  std::fflush(stdout);
  for (const Printed& p : all) pack_print(p.print, print);
  return status;
}

}  // namespace

void declare_demo(OptionSet& options) {
  auto& o = options.calls(run_demo);
  options.option("--bus", o.bus, "in-process, or an LCM URL of loopback; default: a port for each run");
  options.override_option(o.overrides, "KEY=VALUE, for every scheme");
  options.runs_option(o.runs, "where run folders go");
  options.option("-o,--output", o.output, "report; default: report.html in the last run's folder");
  options.json_flag(o.json);
}

}  // namespace firn
