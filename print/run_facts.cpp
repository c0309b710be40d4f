#include "print/run_facts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "config/labs.h"
#include "core/grid/npy.h"
#include "core/grid/outline.h"
#include "core/slice/coverage/footprint.h"
#include "firn/height_map_t.hpp"
#include "lcmtypes/convert.h"
#include "replay/audit_run.h"
#include "replay/ice_error.h"
#include "runs/read/print_use.h"
#include "runs/read/run_reader.h"

namespace firn {
namespace {

constexpr double kFactsUm = 1e3;  // per mm
constexpr double kPercent = 100.0;

std::optional<height_map_t> last_map(const runs::RunFolder& run) {
  runs::RunReader reader(run.path(),
                         {std::string(channels::kHeightMap.name), std::string(channels::kRunEnd.name)},
                         runs::RunReader::Source::kLog);
  std::optional<runs::Place> place;
  reader.poll([&](std::string_view channel, std::span<const std::byte>, runs::Place at) {
    if (channel == channels::kHeightMap.name) place = at;
  });
  if (!place) return std::nullopt;
  const std::vector<std::byte> bytes = reader.read(*place);
  height_map_t map{};
  if (map.decode(bytes.data(), 0, int(bytes.size())) != int(bytes.size())) return std::nullopt;
  return map;
}

// A line fades beside its middle, so half of its section lies beyond any outline: it has none.
void add_surface(const Experiment& e, const HeightMap& target, const Mask& mask,
                 const std::optional<height_map_t>& map, runs::RunResult& r) {
  r.part->size_mm = part_size_mm(target, mask);
  if (!map || map->layer == 0 || prints_lines(e)) return;
  const HeightMap height = measured_height_of(*map);
  if (height.spec != target.spec) return;
  r.outline = outline_stats(height, target, mask);
  if (std::isfinite(r.outline->overspill)) r.overspill_percent = r.outline->overspill * kPercent;
}

// The scheduler tells the error over a layer's whole footprint. Its inside is where a layer is judged, as in
// the pictures of the report.
void add_path_surface(const slice::PrintPaths& paths, const std::optional<height_map_t>& map,
                      runs::RunResult& r) {
  const replay::NominalPart whole = replay::nominal_part(
      paths, replay::kOutlineCell_mm, replay::kOutlineMargin_mm, replay::NominalOf::kPartAndScaffold);
  r.part->size_mm = part_size_mm(whole.target, whole.mask);
  const slice::LayerPaths* layer = map ? slice::find_layer(paths, map->layer) : nullptr;
  if (!layer || !r.error) return;
  const HeightMap height = height_of(*map);
  const HeightMap nominal(height.spec, layer->z * geometry::kMmPerUnit);
  const Mask inside = replay::judged_cells(*layer, height.spec);
  Mask rim = slice::footprint_mask(slice::footprint_materials(*layer, height.spec));
  for (std::size_t c = 0; c < rim.cells.size(); ++c)
    if (inside.cells[c]) rim.cells[c] = 0;
  r.error->rms_inside_um = error_stats(height, nominal, inside).rms_mm * kFactsUm;
  r.error->rms_rim_um = error_stats(height, nominal, rim).rms_mm * kFactsUm;
}

std::string audit_of(const std::filesystem::path& run) try {
  return replay::audit_words(replay::audit_records(run));
} catch (const std::exception& e) {
  return std::string("not possible: ") + e.what();
}

}  // namespace

std::string part_name(const Experiment& e) {
  switch (lab_of(e).deposition) {
    case Deposition::kPaths:
      return e.ice.paths.empty() ? "mesh " + e.ice.mesh : "paths " + e.ice.paths;
    case Deposition::kLines:
      return "lines " + e.aerosol.job;
    case Deposition::kDroplets:
      break;
  }
  const std::string& kind = e.part.shape.kind;
  return kind + (kind == "height_map" ? " " + e.part.image : kind == "mesh" ? " " + e.part.mesh : "");
}

void add_facts(const runs::RunFolder& run, const Experiment& e, runs::RunResult& r) {
  try {
    r.part = runs::PrintedPart{part_name(e), {}};
    const Blobs inputs = run.inputs();
    const auto map = last_map(run);
    if (prints_paths(e)) {
      add_path_surface(slice::decode_print_paths(blob(inputs, "paths").bytes), map, r);
    } else {
      const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
      add_surface(e, target, mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask"), map, r);
    }
  } catch (const std::exception&) {  // an unreadable record: the audit names it
  }
  r.use = runs::print_use(run.path());
  r.audit = audit_of(run.path());
}

}  // namespace firn
