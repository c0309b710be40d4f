#include "cli/identify_command.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/sealed_run.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "report/draw/style.h"
#include "runs/folder/run_folder.h"
#include "studies/identify/identify.h"
#include "studies/reproduce/reproduce.h"

namespace firn {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const Known& k) {
  return {{"mean_um", k.mean_mm * 1e3}, {"half_width_um", k.half_width_mm * 1e3}};
}
ordered_json json_of(const droplet::Repeats& r) {
  return {{"n", r.n}, {"mean_um", r.mean_mm * 1e3}, {"half_width_um", r.half_width_mm * 1e3}};
}

std::string text_of(double mean_mm, double half_mm) {
  return fmt::format("{:.3f} +- {:.3f}", mean_mm * 1e3, half_mm * 1e3);
}

void show_identification(const Identification& id) {
  const auto& p = id.prints;
  fmt::print("{} layers, {} droplets, noise {:.2f} um a cell; 95 % intervals, um\n", id.layers, id.droplets,
             id.noise_std_mm * 1e3);
  if (p.complete())
    fmt::print("prints of V-C: {} single, {} with four sides, {} with one corner\n", p.single.size(),
               p.cross.size(), p.pair.size());
  fmt::print("{:<18} {:>8} {:>18} {:>18} {:>18}\n", "", "Table I", "fit of (3)-(5)", "V-C: centre",
             "beside a single");
  const auto line = [&](const char* name, double paper_um, const Known& fit, const droplet::Repeats& vc,
                        const droplet::Repeats& beside) {
    fmt::print("{:<18} {:>8.1f} {:>18} {:>18} {:>18}\n", name, paper_um,
               text_of(fit.mean_mm, fit.half_width_mm),
               p.complete() ? text_of(vc.mean_mm, vc.half_width_mm) : "",
               p.complete() ? text_of(beside.mean_mm, beside.half_width_mm) : "");
  };
  line("h1", 4.4, id.h1, p.h1, p.h1);
  line("h2", 0.6, id.h2, p.h2, p.side);
  line("h3", 0.2, id.h3, p.h3, p.corner);
  fmt::print("{:<18} {:>8.1f} {:>18}\n", "h1 + 4 h2 + 4 h3", 7.6,
             text_of(id.layer_height.mean_mm, id.layer_height.half_width_mm));
  fmt::print(
      "excitation {:.3f}, droplet scatter {:.1f} %, fit {:.2f} (1 where the model explains the maps)\n",
      id.fit.excitation, 100 * id.fit.droplet_scatter, id.fit.fit);
}

int identify_one(const IdentifyOptions& options) {
  if (options.runs.size() != 1) throw UsageError("firn identify takes one run; several only with --spacing");
  const auto still = use_sealed_run(options.runs.front(), options.unsealed);
  const Identification id = identify(ObservedRun::read(options.runs.front()));
  if (options.json) {
    ordered_json j = {{"run", options.runs.front()},
                      {"identified", id.uninformative.empty()},
                      {"reason", id.uninformative},
                      {"layers", id.layers},
                      {"droplets", id.droplets},
                      {"noise_std_um", id.noise_std_mm * 1e3},
                      {"h1", json_of(id.h1)},
                      {"h2", json_of(id.h2)},
                      {"h3", json_of(id.h3)},
                      {"layer_height", json_of(id.layer_height)},
                      {"excitation", id.fit.excitation},
                      {"droplet_scatter", id.fit.droplet_scatter},
                      {"fit", id.fit.fit}};
    if (id.prints.complete())
      j["prints"] = {{"h1", json_of(id.prints.h1)},
                     {"h2", json_of(id.prints.h2)},
                     {"h3", json_of(id.prints.h3)},
                     {"side", json_of(id.prints.side)},
                     {"corner", json_of(id.prints.corner)}};
    std::puts(j.dump(2).c_str());
  } else if (id.uninformative.empty()) {
    show_identification(id);
  }
  if (!id.uninformative.empty()) {
    fmt::print(stderr, "{} cannot identify h1, h2, h3: {}\n", options.runs.front(), id.uninformative);
    return kFailed;
  }
  if (!options.output.empty())
    write_file_atomically(options.output, report::standalone_svg(identification_svg(id)));
  return kOk;
}

int choose(const IdentifyOptions& options) {
  if (!(options.diameter_mm > 0.0)) throw UsageError("--diameter: a droplet diameter above 0 mm is wanted");
  std::vector<droplet::SpacingResult> results;
  droplet::SpacingChoice choice;
  try {
    for (const std::string& run : options.runs) {
      const auto still = use_sealed_run(run, options.unsealed);
      try {
        results.push_back(spacing_of(ObservedRun::read(run), options.diameter_mm));
      } catch (const UsageError& error) {
        throw UsageError(run + ": " + error.what());
      }
    }
    std::sort(results.begin(), results.end(), [](const auto& a, const auto& b) { return a.gamma < b.gamma; });
    choice = droplet::choose_spacing(results);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  if (options.json) {
    ordered_json rows = ordered_json::array();
    for (const auto& r : results)
      rows.push_back({{"gamma", r.gamma},
                      {"height_um", r.height_mm * 1e3},
                      {"between_sizes", r.between_sizes},
                      {"within", r.within},
                      {"inconsistency", r.inconsistency},
                      {"std_error", r.std_error},
                      {"repeats", r.repeats}});
    std::puts(ordered_json{{"gamma", choice.gamma},
                           {"std_error", choice.std_error},
                           {"inside", choice.inside},
                           {"spacings", rows}}
                  .dump(2)
                  .c_str());
  } else {
    fmt::print("{:>7} {:>12} {:>15} {:>10} {:>20}\n", "gamma", "height [um]", "between sizes", "within",
               "inconsistency");
    for (const auto& r : results)
      fmt::print("{:>7.3f} {:>12.2f} {:>14.1f}% {:>9.1f}% {:>12.1f} +- {:.1f}%\n", r.gamma, r.height_mm * 1e3,
                 100 * r.between_sizes, 100 * r.within, 100 * r.inconsistency, 100 * r.std_error);
    if (choice.inside)
      fmt::print("chosen: gamma = {:.3f} +- {:.3f} (one standard error); the paper's: 0.627\n", choice.gamma,
                 choice.std_error);
    else
      fmt::print(
          "the smallest inconsistency lies at the end of the tried spacings, gamma = {:.3f}: try further "
          "ones\n",
          choice.gamma);
  }
  if (!options.output.empty())
    write_file_atomically(options.output, report::standalone_svg(spacing_svg(results, choice)));
  return kOk;
}

}  // namespace

int run_identify(const IdentifyOptions& options) {
  return options.spacing ? choose(options) : identify_one(options);
}

void declare_identify(OptionSet& options) {
  auto& o = options.calls(run_identify);
  options.option("RUN", o.runs, "run folder; with --spacing several, each at another spacing of droplets")
      .required();
  options.flag("--spacing", o.spacing, "chooses the spacing of droplets from prints of squares");
  options.option("--diameter", o.diameter_mm, "with --spacing: droplet diameter [mm]").show_default();
  options.option("-o,--output", o.output, "picture, SVG");
  declare_unsealed(options, o.unsealed);
  options.json_flag(o.json);
}

}  // namespace firn
