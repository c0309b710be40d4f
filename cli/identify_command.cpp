#include "cli/identify_command.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <stdexcept>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/sealed_run.h"
#include "core/options/display_unit.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/import/imported_run.h"
#include "report/draw/style.h"
#include "runs/folder/run_folder.h"
#include "studies/identify/identify.h"
#include "studies/identify/identify_beads.h"
#include "studies/identify/identify_places.h"
#include "studies/identify/identify_runs.h"
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

std::string text_of(double mean_mm, double half_mm, const DisplayUnit& unit) {
  return fmt::format("{:.3f} +- {:.3f}", mean_mm * unit.per_mm, half_mm * unit.per_mm);
}

ordered_json held_out_json(const statistics::HeldOut& h) {
  if (!h.known()) return nullptr;
  return {{"fitted_layers", h.fitted_layers},
          {"held_out_layers", h.held_out_layers},
          {"cells", h.cells()},
          {"model_rms_um", h.model_rms_mm() * 1e3},
          {"constant_rms_um", h.constant_rms_mm() * 1e3},
          {"persistence_rms_um", h.persistence_rms_mm() * 1e3},
          {"model_is_best", h.model_is_best()}};
}

// "model 0.21 mm, constant 0.87 mm": of one unit.
void show_held_out(const statistics::HeldOut& h,
                   const std::vector<std::pair<std::string, double>>& models_mm) {
  if (!h.known()) {
    fmt::print("too few layers to hold any out: three measured ones at least are needed\n");
    return;
  }
  const DisplayUnit unit = display_unit_for(h.constant_rms_mm() * 10.0);
  std::string line =
      fmt::format("prediction of the last {} layers from the first {}, RMS [{}]:", h.held_out_layers,
                  h.fitted_layers, unit.name);
  for (const auto& [name, mm] : models_mm) line += fmt::format(" {} {:.3g},", name, mm * unit.per_mm);
  fmt::print("{} constant {:.3g}, persistence {:.3g}\n", line, h.constant_rms_mm() * unit.per_mm,
             h.persistence_rms_mm() * unit.per_mm);
}

void show_identification(const Identification& id) {
  const auto& p = id.prints;
  const DisplayUnit unit = display_unit_for(id.layer_height.mean_mm);
  fmt::print("{} layers, {} droplets, noise {:.3g} {} a cell; 95 % intervals, {}\n", id.layers, id.droplets,
             id.noise_std_mm * unit.per_mm, unit.name, unit.name);
  if (p.complete())
    fmt::print("prints of V-C: {} single, {} with four sides, {} with one corner\n", p.single.size(),
               p.cross.size(), p.pair.size());
  // Table I is of the paper's droplet: it has no meaning beside one of another size.
  fmt::print("h1, h2, h3 of this run are means over cells{}\n",
             id.prior_of_maps ? "" : "; those of Table I are heights at points, the cells' middles");
  fmt::print("{:<18} {:>8} {:>18} {:>18} {:>18}\n", "", id.prior_of_maps ? "" : "Table I", "fit of (3)-(5)",
             p.complete() ? "V-C: centre" : "", p.complete() ? "beside a single" : "");
  fmt::print("{:<18} {:>8} {:>18} {:>18} {:>18}\n", "", id.prior_of_maps ? "" : "points", "cell means",
             p.complete() ? "cell means" : "", p.complete() ? "cell means" : "");
  const auto line = [&](const char* name, double paper_um, const Known& fit, const std::string& not_found,
                        const droplet::Repeats& vc, const droplet::Repeats& beside) {
    fmt::print("{:<18} {:>8} {:>18} {:>18} {:>18}{}\n", name,
               id.prior_of_maps ? "" : fmt::format("{:.1f}", paper_um),
               not_found.empty() ? text_of(fit.mean_mm, fit.half_width_mm, unit) : "not found",
               p.complete() ? text_of(vc.mean_mm, vc.half_width_mm, unit) : "",
               p.complete() ? text_of(beside.mean_mm, beside.half_width_mm, unit) : "",
               not_found.empty()
                   ? ""
                   : fmt::format("  the fit ended {}, {:.3f}", not_found, fit.mean_mm * unit.per_mm));
  };
  line("h1", 4.4, id.h1, id.not_found[0], p.h1, p.h1);
  line("h2", 0.6, id.h2, id.not_found[1], p.h2, p.side);
  line("h3", 0.2, id.h3, id.not_found[2], p.h3, p.corner);
  fmt::print("{:<18} {:>8} {:>18}\n", "h1 + 4 h2 + 4 h3", id.prior_of_maps ? "" : "7.6",
             text_of(id.layer_height.mean_mm, id.layer_height.half_width_mm, unit));
  fmt::print("excitation {:.3f}, droplet scatter {}, fit {:.2f} (1 where the model explains the maps)\n",
             id.fit.excitation,
             id.fit.scatter_at_bound ? "not found (at its bound)"
                                     : fmt::format("{:.1f} %", 100 * id.fit.droplet_scatter),
             id.fit.fit);
  if (id.prior_of_maps)
    fmt::print("the maps' rise per droplet is far from model.h1_mm..h3_mm: the prior has the maps' size\n");
  show_held_out(id.held_out, {{"model", id.held_out.model_rms_mm()}});
}

ordered_json identification_json(const std::string& run, const Identification& id) {
  const auto constant = [&](const Known& k, const std::string& not_found) {
    ordered_json j = json_of(k);
    j["found"] = id.uninformative.empty() && not_found.empty();
    j["why_not"] = not_found;
    return j;
  };
  ordered_json j = {{"run", run},
                    {"model", "droplets"},
                    {"identified", id.uninformative.empty()},
                    {"reason", id.uninformative},
                    {"layers", id.layers},
                    {"droplets", id.droplets},
                    {"noise_std_um", id.noise_std_mm * 1e3},
                    {"heights", "means over cells"},
                    {"h1", constant(id.h1, id.not_found[0])},
                    {"h2", constant(id.h2, id.not_found[1])},
                    {"h3", constant(id.h3, id.not_found[2])},
                    {"layer_height", json_of(id.layer_height)},
                    {"excitation", id.fit.excitation},
                    {"droplet_scatter", id.fit.droplet_scatter},
                    {"droplet_scatter_at_bound", id.fit.scatter_at_bound},
                    {"fit", id.fit.fit},
                    {"prior", id.prior_of_maps ? "the maps' rise per droplet" : "model.h1_mm..h3_mm"},
                    {"held_out", held_out_json(id.held_out)}};
  if (id.prints.complete())
    j["prints"] = {{"h1", json_of(id.prints.h1)},
                   {"h2", json_of(id.prints.h2)},
                   {"h3", json_of(id.prints.h3)},
                   {"side", json_of(id.prints.side)},
                   {"corner", json_of(id.prints.corner)}};
  return j;
}

ordered_json places_json(const std::string& run, const PlaceIdentification& id) {
  const bool identified = id.uninformative.empty();
  ordered_json places = ordered_json::array();
  for (int n = 1; identified && n < id.table.size(); ++n) {
    ordered_json heights_um = ordered_json::array();
    for (const double h : id.prints.kernels[std::size_t(n)].height_mm) heights_um.push_back(h * 1e3);
    places.push_back({{"place", n},
                      {"small", id.table.small(n)},
                      {"x", id.table[n].x},
                      {"y", id.table[n].y},
                      {"mixed_error", id.mixed_error[std::size_t(n)]},
                      {"heights_um", heights_um}});
  }
  return {{"run", run},
          {"model", "places"},
          {"identified", identified},
          {"reason", id.uninformative},
          {"layers", id.layers},
          {"droplets", id.prints.droplets},
          {"drop_height_um", id.prints.drop_height_mm * 1e3},
          {"small_drop_height_um", id.prints.small_drop_height_mm * 1e3},
          {"places", places},
          {"keys", identified ? places_toml(id) : ""}};
}

int identify_places_of(const IdentifyOptions& options, const ObservedRun& observed) {
  if (!options.output.empty()) throw UsageError("--output: a picture is drawn of h1, h2, h3 alone");
  if (options.offsets != word(OffsetKind::kX) && options.offsets != word(OffsetKind::kGrid))
    throw UsageError("--offsets " + options.offsets + ": must be x or grid");
  const std::string& run = options.runs.front();
  const PlaceIdentification id =
      identify_places(observed, options.offsets == word(OffsetKind::kX) ? OffsetKind::kX : OffsetKind::kGrid);
  if (options.json) {
    std::puts(places_json(run, id).dump(2).c_str());
  } else if (id.uninformative.empty()) {
    fmt::print("# {} droplets alone; a droplet adds {:.3f} um over all cells\n", id.prints.droplets,
               id.prints.drop_height_mm * 1e3);
    if (id.prints.small_drop_height_mm > 0.0)
      fmt::print("# a small one {:.3f} um\n", id.prints.small_drop_height_mm * 1e3);
    fmt::print("# {:>5} {:>7} {:>7} {:>14} {:>32}\n", "place", "x", "y", "own cell [um]",
               "mixture of h1..h3 is off by");
    for (int n = 1; n < id.table.size(); ++n)
      fmt::print("# {:>5} {:>7.3f} {:>7.3f} {:>14.3f} {:>23.3f} droplets\n", n, id.table[n].x, id.table[n].y,
                 id.prints.kernels[std::size_t(n)].at(0, 0) * 1e3, id.mixed_error[std::size_t(n)]);
    fmt::print("{}", places_toml(id));
  }
  if (id.uninformative.empty()) return kOk;
  fmt::print(stderr, "{} cannot identify actuation.heights_mm: {}\n", run, id.uninformative);
  return kFailed;
}

int identify_droplets(const IdentifyOptions& options, const ObservedRun& observed) {
  const std::string& run = options.runs.front();
  const Identification id = identify(observed);
  if (options.json)
    std::puts(identification_json(run, id).dump(2).c_str());
  else if (id.uninformative.empty())
    show_identification(id);
  if (!id.uninformative.empty()) {
    if (!options.json && id.held_out.known())
      show_held_out(id.held_out, {{"model", id.held_out.model_rms_mm()}});
    fmt::print(stderr, "{} cannot identify h1, h2, h3: {}\n", run, id.uninformative);
    return kFailed;
  }
  if (id.held_out.known() && !id.held_out.model_is_best())
    fmt::print(stderr,
               "{}: the model predicts the held-out layers no better than a constant or persistence does\n",
               run);
  if (!options.output.empty())
    write_file_atomically(options.output, report::standalone_svg(identification_svg(id)));
  return kOk;
}

ordered_json law_json(const bead::BeadLaw& law) { return {{"a", law.a}, {"b", law.b}}; }

ordered_json beads_json(const std::string& run, const BeadIdentification& id) {
  ordered_json segments = ordered_json::array();
  for (const SegmentLaw& s : id.segments)
    segments.push_back({{"segment", s.segment}, {"beads", s.beads}, {"a", s.law.a}, {"b", s.law.b}});
  return {
      {"run", run},
      {"model", "beads"},
      {"identified", id.uninformative.empty()},
      {"reason", id.uninformative},
      {"layers", id.fit.layers},
      {"beads", id.fit.beads},
      {"left_out", id.left_out},
      {"law", law_json(id.fit.law)},
      {"a", {{"mean", id.fit.law.a}, {"half_width", id.fit.a_half_width}, {"found", id.a_found()}}},
      {"b",
       {{"mean", id.fit.law.b}, {"half_width", id.fit.b_half_width}, {"found", id.uninformative.empty()}}},
      {"scatter", id.fit.scatter},
      {"speed_spread", id.fit.speed_spread},
      {"mean_height_um", id.mean_height_mm * 1e3},
      {"segments", segments},
      {"held_out", held_out_json(id.common)},
      {"held_out_by_segment", held_out_json(id.recursive)}};
}

void show_beads(const BeadIdentification& id) {
  const bead::BeadFit& f = id.fit;
  fmt::print("{} layers of {} segments, {} beads, {} left out: not measured, or no height or speed above 0\n",
             f.layers, f.segments, f.beads, id.left_out);
  fmt::print("ln dh = a ln v + b, v in mm/s, dh in mm; 95 % intervals\n");
  if (id.a_found())
    fmt::print("a  {:.4f} +- {:.4f}\n", f.law.a, f.a_half_width);
  else
    fmt::print(
        "a  not found: its interval {:.4f} +- {:.4f} holds 0, the height is not seen to depend on the "
        "speed\n",
        f.law.a, f.a_half_width);
  fmt::print("b  {:.4f} +- {:.4f}\n", f.law.b, f.b_half_width);
  const double mm = f.law.height_mm(f.reference_mm_s);
  const DisplayUnit unit = display_unit_for(mm);
  fmt::print("at {:.3g} mm/s a height of {} {}; scatter of a bead {:.1f} %, of the speeds {:.1f} %\n",
             f.reference_mm_s, text_of(mm, mm * f.height_half_width, unit), unit.name, 100 * f.scatter,
             100 * f.speed_spread);
  show_held_out(id.common, {{"law", id.common.model_rms_mm()},
                            {"law of each segment, recursive", id.recursive.model_rms_mm()}});
}

int identify_speeds(const IdentifyOptions& options) {
  if (!options.output.empty()) throw UsageError("--output: a picture is drawn of h1, h2, h3 alone");
  const std::string& run = options.runs.front();
  const BeadIdentification id = identify_beads(run);
  if (options.json)
    std::puts(beads_json(run, id).dump(2).c_str());
  else if (id.uninformative.empty())
    show_beads(id);
  if (!id.uninformative.empty()) {
    fmt::print(stderr, "{} cannot identify a and b of ln dh = a ln v + b: {}\n", run, id.uninformative);
    return kFailed;
  }
  if (id.common.known() && !id.common.model_is_best() && !id.recursive.model_is_best())
    fmt::print(stderr,
               "{}: the law predicts the held-out layers no better than a constant or persistence does\n",
               run);
  return kOk;
}

ordered_json pooled_json(const IdentifyOptions& options, const PooledIdentification& p) {
  ordered_json constants = ordered_json::array();
  for (const PooledConstant& c : p.constants) {
    const double scale = c.length ? 1e3 : 1.0;
    ordered_json without = ordered_json::array();
    for (const double v : c.without) without.push_back(scale * v);
    constants.push_back({{"name", c.name},
                         {"unit", c.length ? "um" : ""},
                         {"mean", scale * c.value},
                         {"half_width", scale * c.half_width},
                         {"without_each_run", without},
                         {"runs_without_it", c.runs_without_it}});
  }
  return {{"runs", options.runs},
          {"intervals", "95 %, by leaving one run out"},
          {"identified", p.uninformative.empty()},
          {"reason", p.uninformative},
          {"constants", constants}};
}

void show_pooled(const PooledIdentification& p, std::size_t runs) {
  fmt::print("{} runs; 95 % intervals by leaving one run out\n", runs);
  for (const PooledConstant& c : p.constants) {
    const DisplayUnit unit = display_unit_for(p.constants.back().value);
    if (c.runs_without_it.empty())
      fmt::print("{:<18} {}{}\n", c.name,
                 c.length ? text_of(c.value, c.half_width, unit) + " "
                          : fmt::format("{:.4f} +- {:.4f}", c.value, c.half_width),
                 c.length ? unit.name : "");
    else
      fmt::print("{:<18} not found: {} of {} runs do not tell it\n", c.name, c.runs_without_it.size(), runs);
  }
}

int identify_several(const IdentifyOptions& options) {
  if (!options.output.empty()) throw UsageError("--output: a picture is drawn of one run alone");
  if (options.model == "places") throw UsageError("--model places takes one run");
  std::vector<decltype(use_sealed_run(options.runs.front(), true))> still;
  std::vector<bool> speeds;
  std::set<std::int64_t> met;
  for (const std::string& run : options.runs) {
    still.push_back(use_sealed_run(run, options.unsealed));
    if (!met.insert(runs::RunFolder::open(run).run_id()).second)
      throw UsageError(
          run + ": this run is given already; its layers would count twice, and the intervals be too small");
    speeds.push_back(options.model == "beads" || (options.model == "auto" && records_speeds(run)));
    if (speeds.back() != speeds.front())
      throw UsageError(options.runs.front() + " and " + run +
                       " are no runs of one model: only one records speeds");
  }
  PooledIdentification p;
  if (speeds.front()) {
    std::vector<std::vector<bead::Bead>> runs;
    for (const std::string& run : options.runs) runs.push_back(recorded_beads(run));
    p = pool(runs, options.runs);
  } else {
    std::vector<Identification> runs;
    for (const std::string& run : options.runs) runs.push_back(identify(ObservedRun::read(run)));
    p = pool(runs, options.runs);
  }
  if (options.json)
    std::puts(pooled_json(options, p).dump(2).c_str());
  else if (p.uninformative.empty())
    show_pooled(p, options.runs.size());
  if (p.uninformative.empty()) return kOk;
  fmt::print(stderr, "{}\n", p.uninformative);
  return kFailed;
}

int identify_one(const IdentifyOptions& options) {
  const std::string& run = options.runs.front();
  const std::string& model = options.model;
  if (model != "auto" && model != "droplets" && model != "places" && model != "beads")
    throw UsageError("--model " + model + ": must be one of auto, droplets, places, beads");
  if (options.runs.size() > 1) return identify_several(options);
  const auto still = use_sealed_run(run, options.unsealed);
  if (model == "beads" || (model == "auto" && records_speeds(run))) return identify_speeds(options);
  const ObservedRun observed = ObservedRun::read(run);
  return model == "places" || (model == "auto" && prints_places(observed.experiment()))
             ? identify_places_of(options, observed)
             : identify_droplets(options, observed);
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
  options
      .option(
          "RUN", o.runs,
          "run folder; several: one model of all, with intervals by leaving one run out; with --spacing each "
          "at another spacing of droplets")
      .required();
  options.flag("--spacing", o.spacing, "chooses the spacing of droplets from prints of squares");
  options.option("--diameter", o.diameter_mm, "with --spacing: droplet diameter [mm]").show_default();
  options
      .option("--model", o.model,
              "droplets: h1, h2, h3; places: heights of droplets beside the centres of their cells; beads: "
              "ln dh = "
              "a ln v + b; auto: beads where speeds are recorded, places where they are printed")
      .show_default();
  options.option("--offsets", o.offsets, "places: of actuation.offsets = x or grid, with the run's positions")
      .show_default();
  options.option("-o,--output", o.output, "picture, SVG");
  declare_unsealed(options, o.unsealed);
  options.json_flag(o.json);
}

}  // namespace firn
