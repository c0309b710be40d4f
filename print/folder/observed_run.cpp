#include "print/folder/observed_run.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "config/labs.h"
#include "core/grid/npy.h"
#include "files/usage_error.h"
#include "firn/deposition_report_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "runs/folder/config_change.h"
#include "runs/folder/run_folder.h"
#include "runs/read/run_messages.h"

namespace firn {
namespace {

constexpr double kWidePrior = 2.0;
constexpr double kNoiseIfUnknown = 0.13;  // of a layer's height: 1 um of the paper's 7.6 um

}  // namespace

double ObservedRun::noise_of(const height_map_t& map) const {
  if (map.noise_std_mm > 0.0) return map.noise_std_mm;
  if (usual_noise_mm_) return *usual_noise_mm_;
  double sum = 0.0;
  int n = 0;
  for (const auto& [layer, m] : maps_) {
    if (!(m.noise_std_mm > 0.0)) continue;
    sum += m.noise_std_mm;
    ++n;
  }
  usual_noise_mm_ = n > 0 ? sum / n : kNoiseIfUnknown * prior().layer_height_mm();
  return *usual_noise_mm_;
}

ObservedRun::ObservedRun(const Experiment& experiment, Mask mask)
    : experiment_(experiment), mask_(std::move(mask)) {}

void require_droplets(const Experiment& e, const std::string& run) {
  if (lab_of(e).deposition != Deposition::kDroplets)
    throw UsageError(run + ": a run of the ink-jet lab is wanted; lab.kind = \"" + e.lab.kind + "\"");
}

ObservedRun ObservedRun::read(const std::filesystem::path& path) {
  const runs::RunFolder folder = runs::RunFolder::open(path);
  const Experiment e =
      parse_experiment(runs::recorded_config(path), path.string() + ": recorded configuration");
  require_droplets(e, path.string());
  if (has_two_jets(e))
    throw UsageError(path.string() + ": this run printed two inks; h1, h2, h3 are those of one");
  ObservedRun run(e, mask_from_npy(blob(folder.inputs(), "mask").bytes, e.grid, "mask"));
  try {
    const std::string stage(channels::kStageCommand.name), reports(channels::kDepositionReport.name),
        maps(channels::kHeightMap.name);
    const runs::RunMessages messages(path, {stage, reports, maps});
    for (const std::string& channel : {stage, reports, maps})
      for (const auto bytes : messages.on(channel)) run.take(channel, bytes);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  return run;
}

void ObservedRun::take(std::string_view channel, std::span<const std::byte> bytes) {
  usual_noise_mm_.reset();
  if (channel == channels::kHeightMap.name) {
    height_map_t m{};
    if (m.decode(bytes.data(), 0, int(bytes.size())) < 0 || from_message(m.grid) != experiment_.grid) return;
    const auto known = maps_.find(m.layer);
    if (known == maps_.end() || known->second.attempt <= m.attempt) maps_[m.layer] = std::move(m);
  } else if (channel == channels::kStageCommand.name) {
    stage_command_t c{};
    if (c.decode(bytes.data(), 0, int(bytes.size())) < 0 || c.n_offset == 0) return;
    Placement placement = placement_of(c, OffsetTable(experiment_.actuation));
    check(placement, from_message(c.grid));
    offsets_[c.layer] = placement.map;
    placed_[{c.layer, c.attempt, c.pass_index}] = std::move(placement);
  } else if (channel == channels::kDepositionReport.name) {
    deposition_report_t r{};
    if (r.decode(bytes.data(), 0, int(bytes.size())) < 0 || from_message(r.grid) != experiment_.grid) return;
    const auto placed = placed_.find({r.layer, r.attempt, r.pass_index});
    drops_[r.layer].add({drops_of(r), r.pass_index, r.passes, r.triggered_jet, r.unknown_from, r.unknown_to,
                         placed == placed_.end() ? Placement{} : placed->second});
  }
}

int ObservedRun::layers() const {
  int n = 0;
  while (maps_.contains(n) && maps_.contains(n + 1) && drops_.contains(n + 1)) ++n;
  return n;
}

double ObservedRun::noise_std_mm() const {
  double sum = 0.0;
  for (const auto& [layer, m] : maps_) sum += noise_of(m);
  return maps_.empty() ? 0.0 : sum / double(maps_.size());
}

std::int64_t ObservedRun::droplets() const {
  std::int64_t n = 0;
  const int last = layers();
  for (int k = 1; k <= last; ++k)
    for (const droplet::Pass& p : drops_.at(k).passes()) n += std::int64_t(p.cells.size());
  return n;
}

std::vector<droplet::Use> ObservedRun::use_of(const droplet::LayerDrops& drops,
                                              const height_map_t& map) const {
  return drops.use_of(height_of(map), map.quality, mask_);
}

std::vector<droplet::PrintedLayer> ObservedRun::printed() const {
  std::vector<droplet::PrintedLayer> out;
  const int last = layers();
  for (int k = 1; k <= last; ++k) {
    const height_map_t &before = maps_.at(k - 1), &after = maps_.at(k);
    droplet::PrintedLayer l{DropletPattern(experiment_.grid), height_of(before), height_of(after), {}};
    for (const droplet::Pass& p : drops_.at(k).passes())
      for (const auto c : p.cells) ++l.fired.cells[c];
    l.use = use_of(drops_.at(k), after);
    const auto first = use_of({}, before);
    for (std::size_t c = 0; c < l.use.size(); ++c)
      if (first[c] == droplet::Use::kNothing) l.use[c] = droplet::Use::kNothing;
    out.push_back(std::move(l));
  }
  return out;
}

std::vector<OffsetMap> ObservedRun::offsets() const {
  std::vector<OffsetMap> out;
  const int last = layers();
  for (int k = 1; k <= last; ++k) {
    const auto known = offsets_.find(k);
    out.push_back(known == offsets_.end() ? OffsetMap{} : known->second);
  }
  return out;
}

deposition::DropletModel ObservedRun::prior() const {
  const auto& m = experiment_.model;
  const deposition::DropletModel model{m.h1_mm, m.h2_mm, m.h3_mm};
  double rise_mm = 0.0, fired = 0.0;
  for (const droplet::PrintedLayer& l : printed())
    for (std::size_t c = 0; c < l.use.size(); ++c) {
      if (l.use[c] == droplet::Use::kNothing) continue;
      rise_mm += l.after.cells[c] - l.before.cells[c];
      fired += l.fired.cells[c];
    }
  const double size = fired > 0.0 ? rise_mm / (fired * model.layer_height_mm()) : 1.0;
  const bool beyond = size > 1.0 + kWidePrior || size < 1.0 / (1.0 + kWidePrior);
  return size > 0.0 && beyond ? model.times(size) : model;
}

droplet::EstimatorOptions ObservedRun::estimator_options() const {
  droplet::EstimatorOptions o;
  o.prior = prior();
  o.prior_std = kWidePrior;
  o.window_layers = experiment_.estimator.window_layers;
  o.border = border();
  return o;
}

std::optional<double> ObservedRun::glance_excitation() const {
  constexpr int kStretches = 8, kLayers = 5;  // layers of a usual print are much alike
  const int last = layers();
  if (last < 2 * kStretches * kLayers) return std::nullopt;
  droplet::EstimatorOptions o = estimator_options();
  o.window_layers = std::max(o.window_layers, kLayers);
  droplet::Symmetric3 information;
  for (int n = 0; n < kStretches; ++n) {
    const int first = (last - kLayers) * n / (kStretches - 1);  // the map before the stretch is its ground
    droplet::DropletEstimator estimator(experiment_.grid, o);
    estimator.set_substrate(height_of(maps_.at(first)), use_of({}, maps_.at(first)),
                            noise_of(maps_.at(first)));
    for (int k = first + 1; k <= first + kLayers; ++k)
      estimator.keep_layer(drops_.at(k).passes(), height_of(maps_.at(k)), use_of(drops_.at(k), maps_.at(k)),
                           noise_of(maps_.at(k)));
    information += estimator.look().information;
  }
  return droplet::separation(information);
}

ObservedRun::Learned ObservedRun::learn() const {
  const int last = layers(), fitted = statistics::fitted_of(last);
  if (last <= 0)
    throw std::invalid_argument(maps_.contains(0) ? "no layer was printed and measured"
                                                  : "there is no map of the bare ground");
  const droplet::EstimatorOptions o = estimator_options();
  droplet::DropletEstimator estimator(experiment_.grid, o);
  estimator.set_substrate(height_of(maps_.at(0)), use_of({}, maps_.at(0)), noise_of(maps_.at(0)));
  Learned out;
  droplet::Estimate of_first;
  // Every layer is estimated while it is in the window. An estimate after each one would cost more and tell
  // no more.
  const int step = std::max(1, o.window_layers / 2);
  for (int k = 1; k <= last; ++k) {
    const bool estimated = k % step == 0 || k == fitted || k == last;
    const auto add = [&](auto take) {
      return (estimator.*take)(drops_.at(k).passes(), height_of(maps_.at(k)),
                               use_of(drops_.at(k), maps_.at(k)), noise_of(maps_.at(k)));
    };
    if (!estimated) {
      add(&droplet::DropletEstimator::keep_layer);
      continue;
    }
    out.all = add(&droplet::DropletEstimator::add_layer);
    if (k == fitted) of_first = out.all;
  }
  if (fitted > 0) out.held_out = predict(of_first, fitted);
  return out;
}

deposition::Border ObservedRun::border() const {
  return experiment_.model.border == "keep" ? deposition::Border::kKeep : deposition::Border::kLose;
}

statistics::HeldOut ObservedRun::predict(const droplet::Estimate& fit, int fitted_layers) const {
  using droplet::Use;
  statistics::HeldOut out;
  const int all = layers();
  out.fitted_layers = fitted_layers;
  const std::vector<droplet::PrintedLayer> printed = this->printed();
  double constant_mm = 0.0, n = 0.0;
  for (int k = 1; k <= out.fitted_layers; ++k) {
    const droplet::PrintedLayer& l = printed[std::size_t(k - 1)];
    for (std::size_t c = 0; c < l.use.size(); ++c)
      if (l.use[c] == Use::kLearn) constant_mm += (l.after.cells[c] - l.before.cells[c] - constant_mm) / ++n;
  }
  droplet::SurfaceFilter filter(experiment_.grid, border());
  const double noise_mm = noise_std_mm();
  droplet::Surface surface =
      filter.substrate(height_of(maps_.at(0)).cells, use_of({}, maps_.at(0)), noise_mm * noise_mm);
  for (int k = 1; k <= all; ++k) {
    const HeightMap height = height_of(maps_.at(k));
    droplet::Layer layer{drops_.at(k).passes(),
                         height.cells,
                         use_of(drops_.at(k), maps_.at(k)),
                         noise_mm * noise_mm,
                         {},
                         {},
                         {},
                         {}};
    if (k > out.fitted_layers) {
      droplet::Surface ahead = surface;
      filter.predict(layer, ahead, fit.model, fit.droplet_scatter);
      const droplet::PrintedLayer &now = printed[std::size_t(k - 1)], &before = printed[std::size_t(k - 2)];
      for (std::size_t c = 0; c < height.size(); ++c) {
        if (now.use[c] != Use::kLearn || before.use[c] == Use::kNothing) continue;
        const double rise_mm = now.after.cells[c] - now.before.cells[c];
        out.add(ahead.height_mm[c] - height.cells[c], constant_mm - rise_mm,
                before.after.cells[c] - before.before.cells[c] - rise_mm);
      }
      ++out.held_out_layers;
    }
    filter.reference(layer, surface, fit.model, fit.droplet_scatter);
  }
  return out;
}

}  // namespace firn
