#include "studies/compare/recorded_study.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "core/grid/outline.h"
#include "core/options/number.h"
#include "core/statistics/correlated_series.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "firn/layer_metrics_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/told_heights.h"
#include "print/import/imported_run.h"
#include "print/labs/full_product.h"
#include "report/run/differing_parameters.h"
#include "runs/folder/documents.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/run_meta.h"
#include "runs/read/run_reader.h"
#include "studies/compare/outline_metrics.h"
#include "studies/compare/study_lab.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr double kUmPerMm = 1e3;

const std::vector<report::StudyMetric>& measured_metrics() {
  static const std::vector<report::StudyMetric> table = [] {
    std::vector<report::StudyMetric> t = {
        {"rms_um", "um", "RMS of the last measured map about the target", 3},
        {"std_um", "um", "roughness: standard deviation of the measured error about its mean", 3},
        {"abs_mean_um", "um", "size of the mean error of the last measured map", 3},
        {"max_um", "um", "largest absolute measured error of a cell", 2},
        {"layers", "", "layers printed", 1},
        {"droplets", "", "droplets fired", 0},
    };
    for (const OutlineMetric& m : kOutlineMetrics) t.push_back(outline_metric_of(m));
    return t;
  }();
  return table;
}

std::vector<double> metrics_of_layer(const layer_metrics_t& m, const std::optional<OutlineStats>& outline) {
  std::vector<double> values{m.rms_mm * kUmPerMm,
                             m.std_mm * kUmPerMm,
                             std::abs(m.mean_error_mm) * kUmPerMm,
                             std::max(std::abs(m.min_error_mm), std::abs(m.max_error_mm)) * kUmPerMm,
                             double(m.layer),
                             double(m.drops_total)};
  for (const OutlineMetric& o : kOutlineMetrics)
    values.push_back(outline_value(o, outline.value_or(OutlineStats{})));
  return values;
}

// Of the layers of a window; the outline is of the last map alone.
std::vector<double> mean_metrics(const std::vector<layer_metrics_t>& layers) {
  std::vector<double> sum(measured_metrics().size(), 0.0);
  for (const layer_metrics_t& m : layers) {
    const std::vector<double> values = metrics_of_layer(m, std::nullopt);
    for (std::size_t n = 0; n < sum.size(); ++n) sum[n] += values[n] / double(layers.size());
  }
  return sum;
}

// The difference of two prints, layer by layer.
std::string difference_of(const std::string& a, const std::vector<layer_metrics_t>& of_a,
                          const std::string& b, const std::vector<layer_metrics_t>& of_b) {
  std::vector<double> difference_um;
  int first = 0, last = 0;
  for (const layer_metrics_t& m : of_a) {
    const auto same = std::ranges::find(of_b, m.layer, &layer_metrics_t::layer);
    if (same == of_b.end()) continue;
    if (difference_um.empty()) first = m.layer;
    last = m.layer;
    difference_um.push_back((m.rms_mm - same->rms_mm) * kUmPerMm);
  }
  if (difference_um.empty())
    return "One print each: " + a + " and " + b + " have no measured layer in common";
  const statistics::SeriesMean s = statistics::mean_of_series(difference_um);
  const std::string of =
      fmt::format("One print each: rms_um of {} less that of {}, mean of layers {} to {}: {:.3g} um", a, b,
                  first, last, s.mean);
  if (std::isnan(s.interval.low)) return of + "; too few layers for an interval";
  const bool apart = s.interval.low > 0.0 || s.interval.high < 0.0;
  return of +
         fmt::format(
             " [{:.3g}, {:.3g}] by block bootstrap. A layer correlates by {:.2f} with the next, so that "
             "{} layers count as {:.1f}. These two prints {}, which says nothing of other prints of these "
             "schemes",
             s.interval.low, s.interval.high, s.lag1, difference_um.size(), s.effective,
             apart ? "differ" : "do not differ beyond chance");
}

// An older program kept no outline, and lines and paths have none.
void drop_unknown(report::StudyTable& t) {
  for (std::size_t m = t.metrics.size(); m-- > 0;) {
    const auto known = [&](const report::StudyRun& r) { return std::isfinite(r.metrics[m]); };
    if (std::ranges::any_of(t.runs, known)) continue;
    t.metrics.erase(t.metrics.begin() + std::ptrdiff_t(m));
    for (report::StudyRun& r : t.runs) r.metrics.erase(r.metrics.begin() + std::ptrdiff_t(m));
  }
}

std::string run_name(const fs::path& run) { return fs::weakly_canonical(run).filename().string(); }

runs::ProvenanceDocument provenance_of(const fs::path& run) {
  const fs::path file = RunPaths(run).provenance_path();
  return runs::parse_provenance(read_file(file), file.string());
}

struct ReadRun {
  report::StudyRun run;
  std::string target;                   // digest
  std::string doubt;                    // damage of its records, or layers without a map; empty: none
  bool own_target = false;              // imported: flat, at the mean of its own last map
  std::vector<layer_metrics_t> layers;  // of the window, each once: as it was measured last
};

// None: its makers' records have no tolerance.
std::optional<bool> within_tolerance(const fs::path& run, const runs::RunFolder& folder, double rms_um) {
  if (is_imported(run)) return std::nullopt;
  const Experiment e =
      parse_recorded_experiment(folder.experiment_toml(), RunPaths(run).experiment_path().string());
  const double limit_um = tolerance_of_part_um(e);
  return limit_um > 0.0 ? std::optional(rms_um <= limit_um) : std::nullopt;
}

ReadRun read_recorded(const fs::path& path, const LayerWindow& window) {
  const runs::RunLock still(path, runs::RunUse::kRead);
  const runs::RunFolder folder = runs::RunFolder::open(path);
  ReadRun read;
  for (const auto& [role, sha256] : provenance_of(path).inputs)
    if (role == "target" || role == "mask") read.target += sha256;
  read.own_target = provenance_of(path).text("imported").find(kNoTarget) != std::string::npos;
  const auto result = folder.result();
  read.run.finished = result && !runs::can_go_on(*result);
  read.run.outcome = result ? result->outcome : "not ended";
  read.run.reason = run_name(path) + (result && !result->reason.empty() ? ": " + result->reason : "");
  if (result && result->outcome == "out of tolerance") read.run.within = false;
  std::optional<layer_metrics_t> last;
  try {
    const runs::RunReader messages(path);
    messages.each<layer_metrics_t>(channels::kLayerMetrics.name, [&](const layer_metrics_t& m) {
      last = m;
      if (!window.holds(m.layer) || !heights_told(m)) return;
      if (!read.layers.empty() && read.layers.back().layer == m.layer)
        read.layers.back() = m;
      else
        read.layers.push_back(m);
    });
    if (!messages.damage().empty()) read.doubt = "is damaged: " + messages.damage().front();
  } catch (const std::invalid_argument& error) {
    throw UsageError(path.string() + ": " + error.what());
  }
  if (!last && read.run.finished)
    throw UsageError(path.string() + ": no layer was printed and measured: nothing can be compared" +
                     (read.doubt.empty() ? "" : "; it " + read.doubt));
  if (last && !heights_told(*last))
    throw UsageError(path.string() + ": heights were not measured: nothing can be compared");
  if (last && read.run.finished && read.doubt.empty() && last->layer != result->layers)
    read.doubt = "was measured last after layer " + std::to_string(last->layer) + " of " +
                 std::to_string(result->layers);
  if (last && !read.run.within) read.run.within = within_tolerance(path, folder, last->rms_mm * kUmPerMm);
  if (window.given() && read.layers.empty())
    throw UsageError(path.string() + ": no layer from " + std::to_string(window.first) + " to " +
                     std::to_string(window.last) + " was measured");
  read.run.metrics =
      window.given() ? mean_metrics(read.layers)
      : last         ? metrics_of_layer(*last, result ? result->outline : std::nullopt)
             : std::vector<double>(measured_metrics().size(), std::numeric_limits<double>::quiet_NaN());
  return read;
}

std::vector<std::size_t> wanted_metrics(const Study& study) {
  const auto& all = measured_metrics();
  std::vector<std::size_t> wanted;
  for (std::size_t m = 0; m < all.size() && study.metrics.empty(); ++m) wanted.push_back(m);
  for (const std::string& name : study.metrics) {
    const auto at = std::ranges::find(all, name, &report::StudyMetric::name);
    if (at == all.end()) {
      std::string known;
      for (const auto& m : all) known += (known.empty() ? "" : ", ") + m.name;
      throw UsageError("metrics: '" + name + "' is not measured in recorded runs; they have " + known);
    }
    wanted.push_back(std::size_t(at - all.begin()));
  }
  return wanted;
}

}  // namespace

Study study_of_runs(const std::vector<std::string>& runs, const std::string& by) {
  constexpr std::string_view kMeta = "meta.";
  const std::string key = by.starts_with(kMeta) ? by.substr(kMeta.size()) : by;
  if (!by.empty() && !is_meta_key(key))
    throw UsageError("--by " + by + ": is no key of [meta]; meta.ink is one");
  Study study;
  study.name = "runs";
  for (const std::string& run : runs) {
    runs::RunFolder::open(run);  // names what is no run
    const runs::ProvenanceDocument p = provenance_of(run);
    const std::string name = key.empty() ? p.text(is_imported(run) ? "name" : "scheme")
                                         : runs::meta_text(runs::run_meta(p).values, key);
    if (name.empty() && !key.empty())
      throw UsageError(run + ": has no meta." + key + ", which --by asks for");
    auto arm = std::ranges::find(study.arms, name, &StudyEntry::name);
    if (arm == study.arms.end()) arm = study.arms.insert(arm, {name, {}, 0, {}});
    arm->runs.push_back(fs::absolute(run).string());
  }
  for (const StudyEntry& arm : study.arms)
    if (arm.runs.size() != study.arms.front().runs.size())
      throw UsageError(
          arm.name + " has " + std::to_string(arm.runs.size()) + " runs and " + study.arms.front().name +
          " " + std::to_string(study.arms.front().runs.size()) +
          ": the n-th runs of all schemes are compared with each other, so that each needs as many");
  for (std::size_t n = 1; n <= study.arms.front().runs.size(); ++n) study.seeds.push_back(n);
  study.parts.push_back({"part", {}, 0, {}});
  return study;
}

LayerWindow parse_window(const std::string& text) {
  const std::size_t dash = text.find('-');
  LayerWindow w;
  if (dash != text.npos)
    w = {whole_number<int>(text.substr(0, dash)).value_or(0),
         whole_number<int>(text.substr(dash + 1)).value_or(0)};
  if (w.first < 1 || w.last < w.first)
    throw UsageError("--layers '" + text + "': FIRST-LAST is wanted, layers from 1, as in 3-20");
  return w;
}

RecordedStudy recorded_study(const Study& study, const fs::path& folder, const LayerWindow& window) {
  RecordedStudy out;
  report::StudyTable& t = out.table;
  t.name = study.name;
  t.trial = "block";
  t.parts = {"part"};
  t.seeds = study.seeds;
  t.baseline = study.baseline;
  const std::vector<std::size_t> wanted = wanted_metrics(study);
  for (const std::size_t m : wanted) t.metrics.push_back(measured_metrics()[m]);
  std::set<fs::path> seen;
  std::set<std::string> targets;
  std::vector<Experiment> first;
  bool imported = false;
  int own_targets = 0;
  std::vector<std::vector<layer_metrics_t>> layers;  // of each run
  for (const StudyEntry& arm : study.arms) {
    t.arms.push_back(arm.name);
    std::string names;
    for (const std::string& text : arm.runs) {
      const fs::path run = folder / text;
      if (!seen.insert(fs::weakly_canonical(run)).second) throw UsageError(run.string() + " is given twice");
      ReadRun read = read_recorded(run, window);
      targets.insert(read.target);
      own_targets += read.own_target;
      if (!read.doubt.empty()) t.notes.push_back(run_name(run) + " " + read.doubt);
      std::vector<double> metrics;
      for (const std::size_t m : wanted) metrics.push_back(read.run.metrics[m]);
      read.run.metrics = std::move(metrics);
      t.runs.push_back(std::move(read.run));
      layers.push_back(std::move(read.layers));
      names += (names.empty() ? "" : ", ") + run_name(run);
      imported = imported || is_imported(run);
    }
    out.runs.push_back(names);
    const fs::path run = folder / arm.runs.front();
    first.push_back(parse_recorded_experiment(runs::RunFolder::open(run).experiment_toml(),
                                              RunPaths(run).experiment_path().string()));
  }
  if (window.given())
    t.notes.push_back("Metrics are means over layers " + std::to_string(window.first) + " to " +
                      std::to_string(window.last) +
                      ", which were chosen: another window may say another thing");
  if (t.seeds.size() == 1)
    for (std::size_t a = 0; a < t.arms.size(); ++a)
      for (std::size_t b = a + 1; b < t.arms.size(); ++b)
        t.notes.push_back(difference_of(t.arms[a], layers[a], t.arms[b], layers[b]));
  if (study.metrics.empty()) drop_unknown(t);
  if (targets.size() > 1)
    t.notes.push_back("The runs have " + std::to_string(targets.size()) +
                      " different targets: each error is one about the run's own target");
  if (own_targets > 0)
    t.notes.push_back(
        std::to_string(own_targets) +
        " imported runs tell no target: their errors are about the mean of their last map, so they say "
        "how flat a part is, not how near to its goal");
  if (imported)
    t.notes.push_back("Imported runs count with their last measured map, as their makers measured it");
  out.settings = report::differing_parameters(std::move(first));
  return out;
}

}  // namespace firn
