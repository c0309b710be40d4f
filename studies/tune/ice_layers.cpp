#include "studies/tune/ice_layers.h"

#include <algorithm>
#include <cmath>

#include "core/slice/coverage/footprint.h"
#include "firn/control_surface_t.hpp"
#include "firn/enums.h"
#include "firn/height_map_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "replay/ice_error.h"

namespace firn::tune {
namespace {

constexpr double kUnits = 100.0;  // of a nominal interval's growth

bool is_measured(const slice::LayerPaths& layer) {
  return std::ranges::any_of(layer.info,
                             [](const auto& line) { return line.kind == PathKind::kMeasurement; });
}

}  // namespace

IceLayers::IceLayers(const Experiment& e, std::span<const std::byte> bytes)
    : min_measured_(e.process.min_measured_fraction) {
  const slice::PrintPaths paths = slice::decode_print_paths(bytes);
  for (const slice::LayerPaths& layer : paths.layers) {
    if (!is_measured(layer)) continue;
    if (intervals_.empty()) {
      const GridSpec grid = slice::footprint_grid(layer, e.ice.pitch_mm);
      mask_ = replay::judged_cells(layer, grid);
    } else {
      const Mask judged = replay::judged_cells(layer, mask_.spec);
      for (std::size_t c = 0; c < mask_.size(); ++c) mask_.cells[c] = mask_.cells[c] && judged.cells[c];
    }
    intervals_.push_back({layer.layer, layer.z * geometry::kMmPerUnit});
  }
}

void IceLayers::take(std::string_view channel, std::span<const std::byte> bytes) {
  if (channel == channels::kHeightMap.name) {
    height_map_t m{};
    if (m.decode(bytes.data(), 0, int(bytes.size())) < 0 || m.measured_fraction < min_measured_) return;
    maps_[m.layer] = {m.map_id, m.noise_std_mm, resample(height_of(m), mask_.spec, kNotMeasured)};
  } else if (channel == channels::kControlSurface.name) {
    control_surface_t m{};
    if (m.decode(bytes.data(), 0, int(bytes.size())) < 0) return;
    HeightMap u(from_message(m.grid), 0.0);
    for (std::size_t c = 0; c < u.size() && c < m.u.size(); ++c) u.cells[c] = double(m.u[c]);
    action_[m.map_id] = resample(u, mask_.spec, 0.0);
  }
}

HeightMap IceLayers::target() const {
  return HeightMap(mask_.spec, intervals_.empty() ? 0.0 : intervals_.back().nominal_mm);
}

double IceLayers::noise_std_mm() const {
  double sum = 0.0;
  for (const auto& [layer, map] : maps_) sum += map.noise_mm / double(maps_.size());
  return sum;
}

std::vector<droplet::PrintedLayer> IceLayers::printed() const {
  std::vector<droplet::PrintedLayer> out;
  const HeightMap none(mask_.spec, 0.0);
  const auto table = maps_.find(0);
  HeightMap before = table == maps_.end() ? none : table->second.height;
  std::int64_t answered = table == maps_.end() ? 0 : table->second.id;
  for (const Interval& interval : intervals_) {
    const auto map = maps_.find(interval.layer);
    if (map == maps_.end()) break;
    const auto u = action_.find(answered);
    droplet::PrintedLayer l{DropletPattern(mask_.spec), before, map->second.height, {}};
    for (std::size_t c = 0; c < mask_.size(); ++c) {
      const double growth = 1.0 + (u == action_.end() ? 0.0 : u->second.cells[c]);
      l.fired.cells[c] = std::uint8_t(std::clamp(std::round(kUnits * growth), 0.0, 255.0));
      const bool known = std::isfinite(before.cells[c]) && std::isfinite(l.after.cells[c]);
      l.use.push_back(known ? droplet::Use::kLearn : droplet::Use::kNothing);
    }
    before = l.after;
    answered = map->second.id;
    out.push_back(std::move(l));
  }
  return out;
}

}  // namespace firn::tune
