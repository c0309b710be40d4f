#include "page/run_maps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/labs.h"
#include "core/deposition/offset_change.h"
#include "core/grid/decision.h"
#include "core/grid/npy.h"
#include "core/grid/outline.h"
#include "core/slice/coverage/footprint.h"
#include "files/record/file.h"
#include "firn/control_surface_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/height_model_t.hpp"
#include "firn/height_profile_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "page/map_head.h"
#include "runs/read/truth.h"

namespace firn::page {
namespace {

constexpr double kUm = 1e3;              // per mm
constexpr std::size_t kMaxDerived = 40;  // values that are computed at one look

template <class Message>
std::optional<Message> decode(std::span<const std::byte> bytes) {
  Message m{};
  if (bytes.empty() || m.decode(bytes.data(), 0, int(bytes.size())) != int(bytes.size())) return std::nullopt;
  return m;
}

template <class Message>
double time_s(const Message& m) {
  return double(m.header.utime_us) * 1e-6;
}

std::vector<std::byte> bytes_of(const std::filesystem::path& file) {
  const record::MappedFile mapped(file, record::MappedFile::Packed::kAsIs);
  return {mapped.bytes().begin(), mapped.bytes().end()};
}

HeightMap error_of(const HeightMap& height, const HeightMap& target, const Mask& mask) {
  HeightMap error(height.spec, kNotMeasured);
  for (std::size_t c = 0; c < error.size(); ++c)
    if (mask.cells[c]) error.cells[c] = height.cells[c] - target.cells[c];
  return error;
}

std::vector<int> newest(std::vector<int>& layers) {
  std::vector<int> some = std::exchange(layers, {});
  if (some.size() > kMaxDerived) some.erase(some.begin(), some.end() - kMaxDerived);
  return some;
}

}  // namespace

RunMaps::RunMaps(std::filesystem::path run, const Experiment& experiment,
                 const std::map<std::string, std::filesystem::path>& inputs, Reader read)
    : run_(std::move(run)),
      experiment_(experiment),
      read_(std::move(read)),
      paths_(prints_paths(experiment)),
      model_{experiment.model.h1_mm, experiment.model.h2_mm, experiment.model.h3_mm} {
  try {
    if (paths_) {
      layers_ = slice::decode_print_paths(bytes_of(inputs.at("paths")));
    } else {
      grid_ = experiment.grid;
      droplets_ = std::make_shared<const Wanted>(
          Wanted{height_map_from_npy(bytes_of(inputs.at("target")), *grid_, "target"),
                 mask_from_npy(bytes_of(inputs.at("mask")), *grid_, "mask")});
    }
  } catch (const std::exception&) {  // a run without them has its measured maps
  }
}

std::set<std::string, std::less<>> RunMaps::channels() {
  return {std::string(channels::kHeightMap.name), std::string(channels::kLayerPlan.name),
          std::string(channels::kControlSurface.name), std::string(channels::kHeightModel.name),
          std::string(channels::kHeightProfile.name)};
}

void RunMaps::take(std::string_view channel, std::span<const std::byte> message, runs::Place place) {
  if (channel == channels::kHeightMap.name) {
    const auto m = map_head(message);
    if (!m) return;
    maps_[m->layer] = {place, double(m->utime_us) * 1e-6};
    new_maps_.push_back(m->layer);
    last_.second.reset();
    rows_layer_ = -1;
    if (paths_ || !grid_) grid_ = from_message(m->grid);
  } else if (channel == channels::kLayerPlan.name) {
    const auto m = decode<layer_plan_t>(message);
    if (!m || PlanDecision(m->decision) != PlanDecision::kPrint) return;
    plans_[m->layer] = {place, time_s(*m)};
    new_plans_.push_back(m->layer);
  } else if (channel == channels::kControlSurface.name) {
    if (const auto m = decode<control_surface_t>(message)) surfaces_[m->layer] = {place, time_s(*m)};
  } else if (channel == channels::kHeightModel.name) {
    const auto m = decode<height_model_t>(message);
    if (m && experiment_.control.adapt_model == "on") model_ = {m->h1_mm, m->h2_mm, m->h3_mm};
  } else if (channel == channels::kHeightProfile.name) {
    on_profile(message);
  }
}

std::optional<int> RunMaps::newest_layer() const {
  if (maps_.empty()) return std::nullopt;
  return maps_.rbegin()->first;
}

std::shared_ptr<const RunMaps::Measured> RunMaps::measured(int layer) {
  const auto found = maps_.find(layer);
  if (found == maps_.end()) return nullptr;
  if (last_.first == layer && last_.second) return last_.second;
  const auto m = decode<height_map_t>(read_(found->second.place));
  if (!m) return nullptr;
  last_ = {layer, std::make_shared<const Measured>(Measured{measured_height_of(*m), time_s(*m)})};
  return last_.second;
}

std::shared_ptr<const RunMaps::Wanted> RunMaps::wanted(int layer, const GridSpec& grid) {
  if (!paths_) return droplets_ && droplets_->target.spec == grid ? droplets_ : nullptr;
  const slice::LayerPaths* l = layers_ ? slice::find_layer(*layers_, layer) : nullptr;
  if (!l) return nullptr;
  return std::make_shared<const Wanted>(
      Wanted{HeightMap(grid, l->z * geometry::kMmPerUnit),
             slice::footprint_mask(slice::footprint_materials(*l, grid))});  // as LAYER_METRICS
}

std::optional<std::vector<std::byte>> RunMaps::planned(int layer) {
  const auto& places = paths_ ? surfaces_ : plans_;
  const auto found = places.find(paths_ ? layer : layer + 1);  // the plan that answers the layer's map
  if (found == places.end()) return std::nullopt;
  const std::vector<std::byte> bytes = read_(found->second.place);
  if (paths_) {
    const auto m = decode<control_surface_t>(bytes);
    if (!m) return std::nullopt;
    return encode_map(Surface::kPlanned, layer, from_message(m->grid), kMapFactor, time_s(*m), m->u);
  }
  const auto m = decode<layer_plan_t>(bytes);
  if (!m) return std::nullopt;
  std::vector<float> values(m->drops.begin(), m->drops.end());
  const OffsetTable table(experiment_.actuation);
  const OffsetMap inside = offsets_of(*m);  // without cells: all in the middle
  const auto known = [&](std::uint8_t place) { return place < table.size(); };  // else the audit names it
  const bool beside = inside.size() == values.size() && std::ranges::all_of(inside.cells, known);
  if (beside)
    for (const double Offset::*axis : {&Offset::x, &Offset::y})
      for (std::size_t c = 0; c < inside.size(); ++c) values.push_back(float(table[inside.of(c)].*axis));
  return encode_map(Surface::kPlanned, layer, from_message(m->grid),
                    kMapDroplets | (beside ? kMapPlaces : 0u), time_s(*m), values);
}

// The model wants every cell: those that were not measured count as the mean of the others.
std::optional<RunMaps::Measured> RunMaps::predicted(int layer) {
  const auto plan = plans_.find(layer);
  if (paths_ || plan == plans_.end()) return std::nullopt;
  const auto measured_before = measured(layer - 1);
  const auto m = decode<layer_plan_t>(read_(plan->second.place));
  if (!measured_before || !m || m->n_material > 0 || from_message(m->grid) != measured_before->height.spec)
    return std::nullopt;
  std::optional<Measured> before = *measured_before;
  double sum = 0.0;
  std::size_t known = 0;
  for (const double h : before->height.cells) {
    if (!std::isfinite(h)) continue;
    sum += h;
    ++known;
  }
  for (double& h : before->height.cells)
    if (!std::isfinite(h)) h = known > 0 ? sum / double(known) : 0.0;
  const auto border =
      experiment_.model.border == "keep" ? deposition::Border::kKeep : deposition::Border::kLose;
  const GridSpec& grid = before->height.spec;
  const OffsetMap offsets = offsets_of(*m);
  const OffsetTable places(experiment_.actuation);
  if (offsets.cells.empty()) {
    deposition::HeightChange<1>(grid, deposition::stencil_of(model_), border)
        .deposit(before->height, drops_of(*m));
  } else {
    try {
      const deposition::OffsetModel model = offset_model(model_, places, experiment_.actuation.heights_mm);
      deposition::OffsetChange(grid, model, border, model).deposit(before->height, drops_of(*m), offsets);
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // a plan of another table: the audit names it
    }
  }
  before->t_s = time_s(*m);
  return before;
}

std::optional<RunMaps::Measured> RunMaps::truth(int layer) {
  std::optional<Measured> found;
  runs::each_truth(run_, [&](std::int32_t of, HeightMap surface) {
    if (of == layer) found = Measured{std::move(surface), 0.0};
  });
  return found;
}

std::optional<HeightMap> RunMaps::error(int layer) {
  const auto m = measured(layer);
  const auto w = m ? wanted(layer, m->height.spec) : nullptr;
  if (!w) return std::nullopt;
  return error_of(m->height, w->target, w->mask);
}

std::optional<HeightMap> RunMaps::target(int layer) {
  const auto m = measured(layer);
  const auto w = m ? wanted(layer, m->height.spec) : nullptr;
  if (!w) return std::nullopt;
  return error_of(w->target, HeightMap(w->target.spec, 0.0), w->mask);
}

std::optional<std::vector<std::byte>> RunMaps::frame(const MapRequest& r) {
  if (r.surface == Surface::kPlanned) return planned(r.layer);
  if (r.surface == Surface::kPredicted || r.surface == Surface::kTruth) {
    const auto m = r.surface == Surface::kPredicted ? predicted(r.layer) : truth(r.layer);
    if (!m) return std::nullopt;
    return encode_heights(r.surface, r.layer, m->height, 0, m->t_s);
  }
  const auto m = measured(r.layer);
  if (!m) return std::nullopt;
  if (r.surface == Surface::kMeasured) return encode_heights(r.surface, r.layer, m->height, 0, m->t_s);
  const auto shown = r.surface == Surface::kError ? error(r.layer) : target(r.layer);
  if (!shown) return std::nullopt;
  return encode_heights(r.surface, r.layer, *shown, 0, m->t_s);
}

std::vector<RunMaps::Value> RunMaps::take_predictions() {
  std::vector<Value> values;
  for (const int layer : newest(new_plans_)) {
    const auto p = predicted(layer);
    const auto w = p ? wanted(layer, p->height.spec) : nullptr;
    if (w) values.emplace_back(layer, error_stats(p->height, w->target, w->mask).rms_mm * kUm);
  }
  return values;
}

std::vector<std::pair<int, OutlineStats>> RunMaps::take_outlines() {
  std::vector<std::pair<int, OutlineStats>> found;
  if (prints_lines(experiment_) || prints_paths(experiment_)) return found;  // a line fades beside its middle
  for (const int layer : newest(new_maps_)) {
    if (layer == 0) continue;
    const auto m = measured(layer);
    const auto w = m ? wanted(layer, m->height.spec) : nullptr;
    if (w) found.emplace_back(layer, outline_stats(m->height, w->target, w->mask));
  }
  return found;
}

void RunMaps::on_profile(std::span<const std::byte> message) {
  const auto m = decode<height_profile_t>(message);
  if (!m || !grid_ || paths_ || m->z_mm.empty()) return;
  if (rows_layer_ != m->layer) {
    rows_layer_ = m->layer;
    rows_ = HeightMap(*grid_, kNotMeasured);
    if (const auto before = m->layer > 0 ? measured(m->layer - 1) : nullptr;
        before && before->height.spec == *grid_)
      rows_ = before->height;
    stamps_.assign(std::size_t(grid_->ny), 0);
    first_stamp_ = ++rows_stamp_;
  }
  const double j = std::round((m->y_mm - grid_->origin_y_mm) / grid_->pitch_y_mm);
  if (!(j >= 0.0 && j < grid_->ny)) return;
  for (int i = 0; i < grid_->nx; ++i) {
    const double k = std::round((grid_->x_mm(i) - m->x0_mm) / m->dx_mm);
    if (k >= 0.0 && k < double(m->z_mm.size())) rows_.at(i, int(j)) = double(m->z_mm[std::size_t(k)]);
  }
  rows_s_ = time_s(*m);
  stamps_[std::size_t(j)] = ++rows_stamp_;
}

std::optional<std::vector<std::byte>> RunMaps::partial(std::uint64_t since) const {
  if (rows_layer_ < 0) return std::nullopt;
  if (since >= first_stamp_)
    return encode_rows(Surface::kMeasured, rows_layer_, rows_, kMapPartial, rows_s_, stamps_, since);
  return encode_heights(Surface::kMeasured, rows_layer_, rows_, kMapPartial, rows_s_);
}

}  // namespace firn::page
