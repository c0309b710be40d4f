#include "print/preview/print_preview.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "config/ice_lab.h"
#include "config/labs.h"
#include "config/nozzles.h"
#include "config/slice.h"
#include "config/swaths.h"
#include "core/grid/geometry.h"
#include "core/grid/npy.h"
#include "core/grid/outline.h"
#include "core/options/for_people.h"
#include "core/path/job_codec.h"
#include "core/path/line_overlap.h"
#include "core/path/polyline.h"
#include "core/planning/path_reach.h"
#include "core/slice/coverage/footprint.h"
#include "drivers/stage/raster.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/inputs/mesh_part.h"
#include "print/prepare/slice_job.h"
#include "print/run_facts.h"
#include "report/draw/heat_map.h"
#include "report/draw/style.h"
#include "runs/folder/verdict.h"

namespace firn {
namespace {

constexpr double kPreviewUm = 1e3;    // per mm
constexpr double kRowTurn_s = 0.065;  // of a stage between two rows
constexpr double kWaveform_s = 0.55;  // until the jet has taken another one
constexpr double kPathStart_s = 1.5;  // of an arm: load, travel, approach
constexpr double kBead_mm = 1.5;      // width of a line of ice
constexpr std::size_t kMaxSections = 60;
constexpr std::size_t kMaxRefused = 5;
constexpr int kRoomForLayers = 3;  // feedback takes up to twice the nominal layers

// All swaths, and between them the way back.
double time_of_scan_s(const Experiment& e) {
  const double swaths = double(swath_shifts_mm(e).size()), length_mm = (e.grid.ny + 1) * e.grid.pitch_y_mm;
  return swaths * (length_mm / e.process.scan_speed_mm_s + kRowTurn_s) +
         (swaths - 1.0) * (length_mm / e.process.pass_speed_mm_s + kRowTurn_s);
}

// The finished part, the size of its box and its cells.
void measure(const HeightMap& height, const Mask& mask, PrintPreview& p) {
  p.picture = HeightMap(height.spec, kNotMeasured);
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (!mask.cells[c]) continue;
    ++p.cells;
    p.picture.cells[c] = height.cells[c];
  }
  p.grid = height.spec;
  p.size_mm = part_size_mm(height, mask);
}

void add(PrintPreview& p, const std::vector<std::string>& remarks) {
  p.remarks.insert(p.remarks.end(), remarks.begin(), remarks.end());
}

// Places inside the cells cost time: nearer droplets, more runs of the stage.
std::string places_remark(const Experiment& e, const OffsetTable& places) {
  double most = 0.0;
  for (int n = 0; n < places.size(); ++n) most = std::max(most, places[n].x);
  const double nearest_mm = (1.0 - 2.0 * most) * e.grid.pitch_x_mm,
               speed_mm_s = nearest_mm * drivers::kRateShare * jets_rate_hz(e);
  std::string text = fmt::format("actuation.offsets: {} places in a cell", places.places());
  if (places.places() < places.size())
    text += "; small droplets are a pass of their own in each layer, with two changes of the waveform";
  if (places.sub_rows() > 1)
    text += fmt::format("; a row of cells is up to {} runs of the stage, one for each height in it",
                        places.sub_rows());
  return text +
         (speed_mm_s < e.process.pass_speed_mm_s
              ? fmt::format(
                    "; droplets may be {:.0f} um apart, which the jet follows at {:.0f} of {:.0f} mm/s: "
                    "such a row is slower, or has two runs where that is quicker",
                    nearest_mm * kPreviewUm, speed_mm_s, e.process.pass_speed_mm_s)
              : "; the jet follows the nearest droplets at full speed");
}

PrintPreview of_droplets(const Experiment& e, const Blobs& inputs, const std::filesystem::path& folder) {
  PrintPreview p;
  const GridSpec& g = e.grid;
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, g, "target");
  const Mask mask = mask_from_npy(blob(inputs, "mask").bytes, g, "mask");
  measure(target, mask, p);
  const std::string& kind = e.part.shape.kind;
  p.amount_name = "droplets";
  const double layer_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm,
               cell_mm2 = g.pitch_x_mm * g.pitch_y_mm;
  p.layers = int(std::ceil(p.size_mm[2] / layer_mm - 1e-9));
  const bool two = e.geometry.solid.kind != "none";
  const Geometry geometry =
      two ? geometry_from_bytes(blob(inputs, "geometry").bytes, g, "geometry")
          : Geometry(g, std::max(p.size_mm[2], layer_mm), std::vector<std::vector<Span>>(g.size()));
  double object_mm3 = 0.0;
  for (std::size_t c = 0; c < g.size(); ++c) {
    if (!mask.cells[c]) continue;
    p.volume_mm3 += target.cells[c] * cell_mm2;
    p.amount += std::llround(target.cells[c] / layer_mm);
    for (const Span& s : geometry.spans(c)) object_mm3 += (s.to_mm - s.from_mm) * cell_mm2;
  }
  p.materials.emplace_back(two ? "ink A" : "ink", two ? object_mm3 : p.volume_mm3);
  if (two) p.materials.emplace_back("ink B", p.volume_mm3 - object_mm3);
  const OffsetTable places(e.actuation);
  const double rows = p.size_mm[1] / g.pitch_y_mm * (two ? 2.0 : 1.0) * e.process.sub_patterns *
                      places.sub_rows(),
               sizes = places.size() / places.places(),  // each a pass of its own
      pass_s = sizes * rows * ((g.nx + 1) * g.pitch_x_mm / e.process.pass_speed_mm_s + kRowTurn_s) +
               (sizes - 1.0) * 2.0 * kWaveform_s,
               scan_s = time_of_scan_s(e);
  p.time_s =
      p.layers * (pass_s + scan_s + e.process.sub_patterns * (e.process.exposure_s + 2.0 * kRowTurn_s));
  const double detail_mm = std::max(g.pitch_x_mm, g.pitch_y_mm);
  if (kind == "mesh")
    add(p, mesh_remarks(folder / e.part.mesh, "part.mesh", e.part.mesh_scale_xy, e.part.mesh_scale_z,
                        detail_mm));
  if (e.geometry.solid.kind == "mesh")
    add(p, mesh_remarks(folder / e.geometry.mesh, "geometry.mesh", e.geometry.mesh_scale_xy,
                        e.geometry.mesh_scale_z, detail_mm));
  if (places.size() > 1) p.remarks.push_back(places_remark(e, places));
  if (p.layers > e.control.max_layers)
    p.remarks.push_back(fmt::format(
        "control.max_layers = {}: the print waits for you there, and the part needs at least {} layers; "
        "--set control.max_layers={} lets it go on",
        e.control.max_layers, p.layers, kRoomForLayers * p.layers));
  return p;
}

// The heights of the highest layers that cover each cell, from some of the layers.
void picture_of(const slice::PrintPaths& paths, double pitch_mm, PrintPreview& p) {
  std::int32_t x0 = INT32_MAX, y0 = INT32_MAX, x1 = INT32_MIN, y1 = INT32_MIN;
  for (const slice::LayerPaths& l : paths.layers)
    for (const geometry::Point& q : l.lines.points) {
      x0 = std::min(x0, q.x);
      x1 = std::max(x1, q.x);
      y0 = std::min(y0, q.y);
      y1 = std::max(y1, q.y);
    }
  if (x0 > x1) return;
  const auto cells = [&](std::int32_t low, std::int32_t high) {
    return int(std::ceil((double(high) - low) * geometry::kMmPerUnit / pitch_mm)) + 3;
  };
  const GridSpec g{cells(x0, x1),
                   cells(y0, y1),
                   pitch_mm,
                   pitch_mm,
                   x0 * geometry::kMmPerUnit - pitch_mm,
                   y0 * geometry::kMmPerUnit - pitch_mm};
  HeightMap height(g);
  Mask mask(g);
  const std::size_t all = paths.layers.size(), step = std::max<std::size_t>(1, all / kMaxSections);
  for (std::size_t n = all; n-- > 0;) {
    if ((all - 1 - n) % step != 0) continue;
    const slice::LayerPaths& l = paths.layers[n];
    const auto covers = slice::footprint_materials(l, g);
    for (std::size_t c = 0; c < g.size(); ++c)
      if (covers.cells[c] && !mask.cells[c]) {
        mask.cells[c] = 1;
        height.cells[c] = l.z * geometry::kMmPerUnit;
      }
  }
  measure(height, mask, p);
}

double speed_of(const Experiment& e, const slice::PathInfo& path) {
  const IceMaterialConfig& m = path.material == 0 ? e.ice.water : e.ice.scaffold;
  return path.kind == PathKind::kMeasurement ? m.measure_mm_s
         : path.kind == PathKind::kBoundary  ? m.boundary_mm_s
                                             : m.fill_mm_s;
}

double length_mm(const slice::LayerPaths& l, std::size_t line) {
  const Path path = slice::to_path(l, line);
  return path_length_mm(path.points, path.closed);
}

PrintPreview of_paths(const Experiment& e, const Blobs& inputs, const std::filesystem::path& folder) {
  PrintPreview p;
  const slice::PrintPaths paths = slice::decode_print_paths(blob(inputs, "paths").bytes);
  p.amount_name = "pulses";
  p.layers = int(paths.layers.size());
  picture_of(paths, e.ice.pitch_mm, p);
  std::vector<double> volume_mm3;
  for (const slice::LayerPaths& l : paths.layers) {
    const auto use = slice::material_use(l);
    if (use.size() > volume_mm3.size()) volume_mm3.resize(use.size(), 0.0);
    for (std::size_t m = 0; m < use.size(); ++m) volume_mm3[m] += use[m].volume_mm3;
    for (std::size_t n = 0; n < l.info.size(); ++n)
      p.time_s += length_mm(l, n) / speed_of(e, l.info[n]) + kPathStart_s;
  }
  double pulses = 0.0;
  for (std::size_t m = 0; m < volume_mm3.size(); ++m) {
    p.volume_mm3 += volume_mm3[m];
    pulses += volume_mm3[m] * (m == 0 ? e.valve_a : e.valve_b).hz_per_mm3_s;
    p.materials.emplace_back(
        m < paths.head.materials.size() ? paths.head.materials[m].name : "material " + std::to_string(m),
        volume_mm3[m]);
  }
  p.amount = std::llround(pulses);
  const std::vector<std::byte>& text = blob(inputs, "machine").bytes;
  const planning::PlanningSetup setup = planning_setup(
      e, parse_machine({reinterpret_cast<const char*>(text.data()), text.size()}, e.ice.machine));
  for (const planning::Unreachable& u :
       planning::unreachable_paths(planning::TaskPlanner(setup), paths, setup, kMaxRefused))
    p.outside.push_back(u.text);
  if (e.ice.paths.empty()) {
    const SliceSettings settings = load_slice_settings(folder / e.ice.slice);
    add(p, mesh_remarks(folder / e.ice.mesh, "ice.mesh", settings.scale[0], settings.scale[2], kBead_mm,
                        facet_count(settings)));
  }
  return p;
}

PrintPreview of_lines(const Experiment& e, const Blobs& inputs) {
  PrintPreview p;
  const GridSpec& g = e.grid;
  const PrintJob job = decode_job(blob(inputs, "job").bytes);
  measure(height_map_from_npy(blob(inputs, "target").bytes, g, "target"),
          mask_from_npy(blob(inputs, "mask").bytes, g, "mask"), p);
  p.amount_name = "mm of lines";
  p.layers = e.aerosol.layers;
  double length_mm = 0.0, open_s = 0.0;
  for (const PrintSegment& s : job.segments) {
    const double mm = std::hypot(s.to.x_mm - s.from.x_mm, s.to.y_mm - s.from.y_mm);
    length_mm += mm;
    open_s += mm / s.speed_mm_s;
  }
  p.amount = std::llround(p.layers * length_mm);
  p.volume_mm3 = p.layers * open_s * e.aerosol.flow_mm3_s;
  p.materials.emplace_back("ink", p.volume_mm3);
  for (const std::string& r : overlap_remarks(job)) p.remarks.push_back(e.aerosol.job + ": " + r);
  p.time_s = p.layers * open_s + (p.layers + 1) * time_of_scan_s(e);
  return p;
}

}  // namespace

PrintPreview preview_print(const Experiment& e, const Blobs& inputs, const std::filesystem::path& folder) {
  PrintPreview p = prints_paths(e)   ? of_paths(e, inputs, folder)
                   : prints_lines(e) ? of_lines(e, inputs)
                                     : of_droplets(e, inputs, folder);
  p.part = part_name(e);
  return p;
}

void take_foretold(const Foretold& f, const Experiment& e, PrintPreview& p) {
  if (f.layer_s.empty()) return;
  p.layers = f.layer_s.rbegin()->first;
  p.time_s = f.time_s;
  if (p.amount_name == lab_of(e).words.amount) p.amount = f.amount;
  p.simulated = e.control.scheme;
}

std::string preview_text(const PrintPreview& p) {
  std::string text = fmt::format("{} on {} x {} cells of {} x {} mm, {} of the part\n",
                                 runs::part_words({p.part, p.size_mm}), p.grid.nx, p.grid.ny,
                                 for_people(p.grid.pitch_x_mm), for_people(p.grid.pitch_y_mm), p.cells);
  text +=
      fmt::format("about {} layers, {} {}, {}{}", p.layers, for_people(double(p.amount)), p.amount_name,
                  time_for_people(p.time_s), p.simulated.empty() ? "" : " (" + p.simulated + ", simulated)");
  for (const auto& [name, mm3] : p.materials) text += fmt::format("; {} mm^3 of {}", for_people(mm3), name);
  text += '\n';
  for (const std::string& r : p.remarks) text += "remark: " + r + '\n';
  for (const std::string& o : p.outside) text += "OUTSIDE: " + o + '\n';
  return text;
}

std::string preview_json(const PrintPreview& p) {
  using Json = nlohmann::ordered_json;
  Json materials = Json::array();
  for (const auto& [name, mm3] : p.materials) materials.push_back({{"name", name}, {"volume_mm3", mm3}});
  const Json j = {{"part", p.part},
                  {"size_mm", p.size_mm},
                  {"grid",
                   {{"nx", p.grid.nx},
                    {"ny", p.grid.ny},
                    {"pitch_x_mm", p.grid.pitch_x_mm},
                    {"pitch_y_mm", p.grid.pitch_y_mm}}},
                  {"cells", p.cells},
                  {"layers", p.layers},
                  {p.amount_name, p.amount},
                  {"volume_mm3", p.volume_mm3},
                  {"time_s", p.time_s},
                  {"simulated", p.simulated.empty() ? Json(nullptr) : Json(p.simulated)},
                  {"materials", materials},
                  {"remarks", p.remarks},
                  {"outside", p.outside}};
  return j.dump(2) + "\n";
}

std::string preview_svg(const PrintPreview& p) {
  return report::standalone_svg(report::heat_map(
      p.picture, {0.0, std::max(1e-3, p.size_mm[2] * kPreviewUm), report::ColorMap::kSequential}, p.part));
}

}  // namespace firn
