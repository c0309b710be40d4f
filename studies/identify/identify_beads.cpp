#include "studies/identify/identify_beads.h"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <set>
#include <span>
#include <stdexcept>

#include "config/experiment.h"
#include "core/grid/cell_quality.h"
#include "files/usage_error.h"
#include "firn/height_map_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "print/import/imported_run.h"
#include "runs/folder/config_change.h"
#include "runs/folder/run_folder.h"
#include "runs/read/run_messages.h"

namespace firn {
namespace {

using bead::Bead;

// Of ln v: below, a and b are one parameter. At the scatter of real beads, 8 %, a thousand of them know a to
// 0.5.
constexpr double kMinSpeedSpread = 0.01;

struct BeadRecord {
  std::vector<Bead> beads;
  std::int64_t left_out = 0;
};

RecordedInputs inputs_of(const runs::RunFolder& folder, const GridSpec& grid) {
  const auto inputs = recorded_inputs(folder.inputs(), grid);
  if (!inputs)
    throw UsageError(
        folder.path().string() +
        ": holds no recorded speeds; firn import makes such a run of a record with a column of speed");
  return *inputs;
}

BeadRecord record_of(const std::filesystem::path& run) {
  const runs::RunFolder folder = runs::RunFolder::open(run);
  const Experiment e =
      parse_experiment(runs::recorded_config(run), run.string() + ": recorded configuration");
  const RecordedInputs inputs = inputs_of(folder, e.grid);
  std::map<int, height_map_t> maps;
  const std::string channel(channels::kHeightMap.name);
  const runs::RunMessages messages(run, {channel});
  messages.each<height_map_t>(channel, [&](const height_map_t& m) { maps[m.layer] = m; });
  BeadRecord r;
  for (std::size_t layer = 1; layer <= inputs.layers.size(); ++layer) {
    const auto above = maps.find(int(layer)), below = maps.find(int(layer) - 1);
    if (above == maps.end() || below == maps.end()) continue;
    const HeightMap after = height_of(above->second), before = height_of(below->second);
    for (std::size_t c = 0; c < after.size(); ++c) {
      const double speed = inputs.layers[layer - 1].cells[c], height = after.cells[c] - before.cells[c];
      const bool measured = above->second.quality[c] == std::int8_t(CellQuality::kMeasured);
      if (measured && speed > 0.0 && height > 0.0)
        r.beads.push_back({int(layer), std::uint32_t(c), speed, height});
      else
        ++r.left_out;
    }
  }
  return r;
}

std::vector<int> layers_of(const std::vector<Bead>& beads) {
  std::set<int> layers;
  for (const Bead& b : beads) layers.insert(b.layer);
  return {layers.begin(), layers.end()};
}

void predict_held_out(const std::vector<Bead>& beads, BeadIdentification& id) {
  const std::vector<int> layers = layers_of(beads);
  const int fitted = statistics::fitted_of(int(layers.size()));
  if (fitted == 0) return;
  const int last_fitted = layers[std::size_t(fitted - 1)];
  std::vector<Bead> known;
  double constant_mm = 0.0;
  for (const Bead& b : beads) {
    if (b.layer > last_fitted) continue;
    known.push_back(b);
    constant_mm += (b.height_mm - constant_mm) / double(known.size());
  }
  if (known.size() < 3) return;
  const bead::BeadLaw common = bead::fit_bead_law(known).law;
  std::map<std::uint32_t, bead::BeadEstimator> segments;
  std::map<std::uint32_t, Bead> before;
  id.common.fitted_layers = id.recursive.fitted_layers = fitted;
  id.common.held_out_layers = id.recursive.held_out_layers = int(layers.size()) - fitted;
  for (const Bead& b : beads) {  // a segment has one bead in a layer
    bead::BeadEstimator& own = segments.try_emplace(b.segment, common).first->second;
    const auto last = before.find(b.segment);
    if (b.layer > last_fitted && last != before.end() && last->second.layer == b.layer - 1) {
      const double constant = constant_mm - b.height_mm, persistence = last->second.height_mm - b.height_mm;
      id.common.add(common.height_mm(b.speed_mm_s) - b.height_mm, constant, persistence);
      id.recursive.add(own.law().height_mm(b.speed_mm_s) - b.height_mm, constant, persistence);
    }
    own.add(b.speed_mm_s, b.height_mm);
    before[b.segment] = b;
  }
}

}  // namespace

BeadIdentification identify_beads(const std::vector<Bead>& beads) {
  BeadIdentification id;
  id.fit = bead::fit_bead_law(beads);
  for (const Bead& b : beads) id.mean_height_mm += b.height_mm / double(beads.size());
  if (id.fit.speed_spread < kMinSpeedSpread) {
    id.uninformative = fmt::format(
        "no excitation: the speeds vary by {:.2f} % (standard deviation), {:.0f} % is needed to distinguish "
        "a from b; "
        "they tell the height at {:.3g} mm/s alone",
        100 * id.fit.speed_spread, 100 * kMinSpeedSpread, id.fit.reference_mm_s);
    return id;
  }
  if (id.fit.law.a > id.fit.a_half_width) {
    id.uninformative = fmt::format(
        "wrong sign: its faster beads are higher, a = {:.2g} +- {:.2g}, although the same wire is drawn out "
        "over "
        "more length: what else changed with the speed, as feedback does, is taken for its effect",
        id.fit.law.a, id.fit.a_half_width);
    return id;
  }
  if (id.fit.layers < 2 && id.fit.segments < 2) {
    id.uninformative = "one segment of one layer: nothing tells how sure a law would be";
    return id;
  }
  std::map<std::uint32_t, bead::BeadEstimator> segments;
  std::map<std::uint32_t, std::int64_t> counts;
  for (const Bead& b : beads) {
    segments.try_emplace(b.segment, id.fit.law).first->second.add(b.speed_mm_s, b.height_mm);
    ++counts[b.segment];
  }
  for (const auto& [segment, estimator] : segments)
    id.segments.push_back({segment, counts[segment], estimator.law()});
  predict_held_out(beads, id);
  return id;
}

std::vector<Bead> recorded_beads(const std::filesystem::path& run) { return record_of(run).beads; }

BeadIdentification identify_beads(const std::filesystem::path& run) try {
  const BeadRecord record = record_of(run);
  BeadIdentification id = identify_beads(record.beads);
  id.left_out = record.left_out;
  return id;
} catch (const UsageError&) {
  throw;
} catch (const std::invalid_argument& error) {
  throw UsageError(run.string() + ": " + error.what());
}

}  // namespace firn
