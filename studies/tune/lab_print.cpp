#include "studies/tune/lab_print.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <optional>

#include "config/labs.h"
#include "core/grid/npy.h"
#include "estimators/lab/layer_features.h"
#include "files/usage_error.h"
#include "firn/control_surface_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/channels.h"
#include "print/import/imported_run.h"
#include "print/labs/full_product.h"
#include "runs/folder/config_change.h"
#include "runs/folder/run_folder.h"
#include "runs/read/run_reader.h"
#include "studies/compare/study_lab.h"
#include "studies/tune/ice_layers.h"
#include "studies/tune/print_journal.h"

namespace firn::tune {
namespace {

/// Mean over the maps after each layer.
double noise_of_bends(std::span<const droplet::PrintedLayer> layers) {
  double sum = 0.0;
  for (const droplet::PrintedLayer& l : layers) sum += noise_of_bends_mm(l.after) / double(layers.size());
  return sum;
}

std::vector<double> features_of(const IceLayers& run) {
  const auto intervals = run.printed();
  const HeightMap target = run.target();
  return lab::layer_features({intervals, run.mask(), target, run.noise_std_mm()});
}

std::vector<double> features_of(const ObservedRun& run, const Mask& mask, const HeightMap& target,
                                MapNoise noise) {
  const auto layers = run.printed();
  const double noise_mm = noise == MapNoise::kReported ? run.noise_std_mm() : noise_of_bends(layers);
  return lab::layer_features({layers, mask, target, noise_mm});
}

/// Counts the droplets of the plans, or the actions of an ice print.
class PlanWatch {
 public:
  /// @param mask of droplets
  PlanWatch(const Experiment& e, const Mask& mask)
      : mask_(mask), most_(e.control.scheme == "smf" ? e.control.smf.max_drops : 0) {}

  void take(std::string_view channel, std::span<const std::byte> bytes) {
    if (channel == channels::kControlSurface.name) {
      control_surface_t m{};
      if (m.decode(bytes.data(), 0, int(bytes.size())) < 0 || m.u.empty()) return;
      double growth = 0.0;
      for (const float u : m.u) growth += (1.0 + double(u)) / double(m.u.size());
      full_ += m.saturated_fraction;
      cells_ += 1.0;
      layers_.push_back(growth);
    }
    if (channel != channels::kLayerPlan.name) return;
    layer_plan_t plan{};
    if (plan.decode(bytes.data(), 0, int(bytes.size())) < 0 || plan.drops.size() != mask_.size()) return;
    double drops = 0.0;
    for (std::size_t c = 0; c < mask_.size(); ++c) {
      if (!mask_.cells[c]) continue;
      drops += plan.drops[c];
      cells_ += 1.0;
      if (most_ > 1 && plan.drops[c] >= most_) full_ += 1.0;
    }
    layers_.push_back(drops);
  }

  PrintTraits traits() const {
    PrintTraits t;
    t.saturated = cells_ > 0.0 ? full_ / cells_ : 0.0;
    const std::size_t n = layers_.size() - layers_.size() / 5;
    if (n < 4) return t;
    double mean = 0.0, squares = 0.0, product = 0.0;
    for (std::size_t k = 0; k < n; ++k) mean += layers_[k] / double(n);
    for (std::size_t k = 0; k < n; ++k) {
      squares += (layers_[k] - mean) * (layers_[k] - mean);
      if (k > 0) product += (layers_[k] - mean) * (layers_[k - 1] - mean);
    }
    if (squares > 0.0 && mean > 0.0) {
      t.alternation = product / squares;
      t.swing = std::sqrt(squares / double(n)) / mean;
    }
    return t;
  }

 private:
  const Mask& mask_;
  int most_;
  double cells_ = 0.0, full_ = 0.0;
  std::vector<double> layers_;
};

}  // namespace

RecordedRun RecordedRun::of(std::string name, const Experiment& e, const Blobs& inputs,
                            const ObservedRun& run, MapNoise noise) {
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  return {std::move(name), e, inputs, features_of(run, run.mask(), target, noise), run.layers(), noise};
}

namespace {

RecordedRun of_ice(const std::string& name, const Experiment& e, const Blobs& inputs,
                   const std::filesystem::path& path, int layers) {
  IceLayers run(e, blob(inputs, "paths").bytes);
  const runs::RunReader messages(path);
  for (const std::string_view channel : {channels::kHeightMap.name, channels::kControlSurface.name})
    for (const auto bytes : messages.on(channel)) run.take(channel, bytes);
  const int intervals = int(run.printed().size());
  if (intervals < lab::kMinLayers)
    throw std::invalid_argument(std::to_string(intervals) + " measured intervals, at least " +
                                std::to_string(lab::kMinLayers) + " are needed" +
                                (layers >= lab::kMinLayers ? "; printed with --set ice.interval_layers=" +
                                                                 std::to_string(layers / lab::kMinLayers) +
                                                                 " the same part has as many"
                                                           : ""));
  return {name, e, inputs, features_of(run), intervals};
}

}  // namespace

RecordedRun RecordedRun::read(const std::filesystem::path& path) {
  const runs::RunFolder folder = runs::RunFolder::open(path);
  const std::string name = path.string();
  Experiment e =
      parse_recorded_experiment(runs::recorded_config(path), name + ": the recorded configuration");
  // Nodes are not told the plant; a verification prints with it.
  e.plant = parse_recorded_experiment(folder.experiment_toml(), folder.experiment_path().string()).plant;
  if (!prints_paths(e)) require_droplets(e, name);
  const auto result = folder.result();
  if (!result || runs::can_go_on(*result)) throw UsageError(name + ": the print is not finished");
  refuse_beads(path, "firn tune");
  try {
    if (prints_paths(e)) return of_ice(name, e, folder.inputs(), path, result->layers);
    const ObservedRun run = ObservedRun::read(path);
    if (run.droplets() == 0)
      throw std::invalid_argument(
          std::string("no droplets are recorded: firn tune needs the input of each layer") +
          (is_imported(path) ? ", as firn import reads it (--column input=NAME)" : ""));
    return of(name, e, folder.inputs(), run, is_imported(path) ? MapNoise::kFromMaps : MapNoise::kReported);
  } catch (const std::invalid_argument& error) {
    throw UsageError(name + ": " + error.what());
  }
}

namespace {

/// Volume beside the part over that inside it: a part that stays low spills less, and is no safer for it.
double overspill_of(const MemoryPrintReport& report, const HeightMap& target, const Mask& mask) {
  if (!std::isfinite(report.outline.overspill)) return 0.0;
  double height_mm = 0.0;
  const double cells = double(mask.count());
  for (std::size_t c = 0; c < mask.size(); ++c)
    if (mask.cells[c]) height_mm += target.cells[c] / cells;
  const double printed_mm = height_mm + report.error.mean_mm;
  const bool droplets = height_mm > 0.0 && printed_mm > 0.1 * height_mm;
  return report.outline.overspill * (droplets ? height_mm / printed_mm : 1.0);
}

LabPrint made_in_lab(const Experiment& experiment, const Blobs& inputs, const LabDraw& draw,
                     const LabPrintOptions& wanted) {
  Experiment e = experiment;
  const std::vector<double> values = draw.lab->values(draw.z);
  draw.lab->set(values, e);
  e.plant.seed = draw.seed;
  e.control.seed = draw.seed;
  LabPrint out;
  try {
    const bool paths = prints_paths(e);
    const Mask mask = paths ? Mask() : mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
    ObservedRun observed(e, mask);
    std::optional<IceLayers> intervals;
    if (paths && wanted.features) intervals.emplace(e, blob(inputs, "paths").bytes);
    PlanWatch plans(e, mask);
    MemoryPrintOptions options;
    options.outline = true;
    options.series = paths;
    options.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
      plans.take(channel, bytes);
      if (intervals)
        intervals->take(channel, bytes);
      else if (wanted.features)
        observed.take(channel, bytes);
    };
    if (draw.lab->nature) options.nature = [&](plant::WorldConfig& w) { draw.lab->nature(values, w); };
    const MemoryPrintReport report = print_in_memory(full_product(), e, inputs, options);
    out.finished = !runs::can_go_on(report.result);
    out.reason = report.result.reason;
    out.metrics = study_metrics(e, report);
    out.traits = plans.traits();
    const HeightMap target =
        paths ? HeightMap() : height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
    out.traits.overspill = overspill_of(report, target, mask);
    if (intervals) {
      if (out.finished && int(intervals->printed().size()) >= lab::kMinLayers)
        out.features = features_of(*intervals);
    } else if (wanted.features && out.finished && observed.layers() >= lab::kMinLayers) {
      out.features = features_of(observed, mask, target, wanted.noise);
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    out.finished = false;
    out.reason = error.what();
  }
  return out;
}

}  // namespace

LabPrint print_in_lab(const Experiment& experiment, const Blobs& inputs, const LabDraw& draw,
                      const LabPrintOptions& wanted) {
  if (!wanted.journal) return made_in_lab(experiment, inputs, draw, wanted);
  const std::string digest = PrintJournal::digest_of(experiment, inputs, draw, wanted);
  if (auto known = wanted.journal->find(digest)) return std::move(*known);
  LabPrint print = made_in_lab(experiment, inputs, draw, wanted);
  wanted.journal->append(digest, print);
  return print;
}

}  // namespace firn::tune
