#include "print/prepare/slice_job.h"

#include <fmt/core.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <iterator>
#include <optional>
#include <span>

#include "core/geometry/planar.h"
#include "core/slice/paths/path_codec.h"
#include "core/slice/support/scaffold.h"
#include "files/mesh/mesh_file.h"
#include "files/usage_error.h"
#include "print/prepare/slice_report.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

using geometry::Region;
using geometry::Rings;

// Layers. Their text may be ten times as large as their paths: fewer are written at once.
constexpr std::size_t kPlannedAtOnce = 64, kWrittenAtOnce = 16;

double wall_now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
double cpu_now_s() {
  timespec t{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

StageTime& stage_of(std::vector<StageTime>& times, const std::string& stage) {
  for (StageTime& t : times)
    if (t.stage == stage) return t;
  return times.emplace_back(StageTime{stage, 0.0, 0.0});
}

slice::Sliced slice_part(const std::filesystem::path& file, std::size_t number, const SliceSettings& settings,
                         const ParallelFor& parallel, SlicedJob& job) {
  PartReport report;
  std::optional<MeshFile> mesh;
  {
    const StageTimer timer(job.times, "read");
    mesh.emplace(file, facet_count(settings));
  }
  report.file = file.string();
  report.format = mesh->data().format;
  report.material = material_of(settings, number);
  report.file_defects = mesh->data().defects;
  const double file_unit = report.format == "3MF" ? mesh->data().mm_per_unit : 0.0;
  try {
    std::optional<slice::Segments> segments;
    {
      const StageTimer timer(job.times, "intersect");
      const slice::FacetView facets = mesh->facets();
      const slice::Affine affine = slice::place(facets, placement(settings, number, file_unit), parallel);
      const auto planes = slice::layer_planes(settings.contour.layer_height_mm, std::max(affine.high.z, 0));
      segments.emplace(slice::intersect(facets, affine, planes, parallel));
    }
    mesh.reset();
    const slice::MeshFacts facts = segments->facts;
    std::optional<std::vector<slice::Contours>> contours;
    {
      const StageTimer timer(job.times, "link");
      contours.emplace(slice::link(std::move(*segments), contour_options(settings), parallel));
      segments.reset();
    }
    const StageTimer timer(job.times, "regions");
    slice::Sliced sliced = slice::regions(std::move(*contours), facts, contour_options(settings), parallel);
    report.facts = sliced.facts;
    report.counts = sliced.counts;
    report.defects = std::move(sliced.defects);
    job.parts.push_back(std::move(report));
    return sliced;
  } catch (const std::invalid_argument& e) {
    throw UsageError(file.string() + ": " + e.what());
  }
}

void append(std::vector<Rings>&& more, std::vector<Rings>& to) {
  to.resize(std::max(to.size(), more.size()));
  for (std::size_t k = 0; k < more.size(); ++k)
    if (to[k].empty())
      to[k] = std::move(more[k]);
    else
      for (std::size_t r = 0; r < more[k].size(); ++r) to[k].add(more[k][r]);
}

// Meshes of one material become one region; a later material is cut by the earlier ones (difference by
// priority).
std::vector<std::vector<Region>> by_material(std::vector<std::vector<Region>>& parts, const SlicedJob& job,
                                             const ParallelFor& parallel) {
  if (parts.size() > 1) {
    std::vector<std::vector<Region>*> all;
    for (auto& p : parts) all.push_back(&p);
    slice::subtract_by_priority(all, parallel);
  }
  std::uint8_t most = slice::kScaffoldMaterial;
  for (const PartReport& p : job.parts) most = std::max(most, p.material);
  std::size_t layers = 0;
  for (const auto& p : parts) layers = std::max(layers, p.size());
  std::vector<std::vector<Region>> out(std::size_t(most) + 1);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    std::vector<Region>& to = out[job.parts[n].material];
    if (to.empty()) {
      to = std::move(parts[n]);
      to.resize(layers);
      continue;
    }
    parallel(int(parts[n].size()), [&](int k) {
      Region& region = to[std::size_t(k)];
      region = region.empty() ? std::move(parts[n][std::size_t(k)])
                              : geometry::unite(region, parts[n][std::size_t(k)]);
    });
  }
  for (auto& m : out) m.resize(layers);
  return out;
}

std::vector<Region> all_materials(const std::vector<std::vector<Region>>& materials,
                                  const ParallelFor& parallel) {
  std::vector<Region> all = materials[0];
  for (std::size_t m = slice::kScaffoldMaterial + 1; m < materials.size(); ++m)
    parallel(int(all.size()), [&](int k) {
      const Region& more = materials[m][std::size_t(k)];
      Region& region = all[std::size_t(k)];
      if (!more.empty()) region = region.empty() ? more : geometry::unite(region, more);
    });
  return all;
}

}  // namespace

StageTimer::StageTimer(std::vector<StageTime>& times, const std::string& stage)
    : time_(stage_of(times, stage)), wall_s_(wall_now_s()), cpu_s_(cpu_now_s()) {}

StageTimer::~StageTimer() {
  time_.wall_s += wall_now_s() - wall_s_;
  time_.cpu_s += cpu_now_s() - cpu_s_;
}

FacetCount facet_count(const SliceSettings& settings) {
  return settings.facet_count == "header" ? FacetCount::kHeader
         : settings.facet_count == "file" ? FacetCount::kFile
                                          : FacetCount::kAgree;
}

slice::SliceOptions contour_options(const SliceSettings& settings) {
  slice::SliceOptions options = settings.contour;
  options.chord_tolerance_mm *= slice::kOutlineShare;
  return options;
}

SlicedJob slice_meshes(const std::vector<std::filesystem::path>& files, const SliceSettings& settings,
                       const ParallelFor& parallel, const SliceProgress& progress) {
  SlicedJob job;
  job.times.reserve(16);
  std::vector<std::vector<Region>> parts;
  std::vector<Rings> contours;  // of all parts
  for (std::size_t n = 0; n < files.size(); ++n) {
    progress(0.2 * double(n) / double(files.size()), "reading " + files[n].filename().string());
    slice::Sliced part = slice_part(files[n], n, settings, parallel, job);
    parts.push_back(std::move(part.layers));
    append(std::move(part.contours), contours);
  }
  std::vector<std::vector<Region>> materials;
  {
    const StageTimer timer(job.times, "regions");
    materials = by_material(parts, job, parallel);
  }
  const double height_mm = settings.contour.layer_height_mm;
  const auto height = std::int32_t(std::lround(height_mm * geometry::kUnitsPerMm));
  const slice::PathOptions options = path_options(settings);
  if (options.support.kind != slice::Support::kNone) {
    progress(0.2, "scaffold");
    const StageTimer timer(job.times, "scaffold");
    const bool one = materials.size() == slice::kScaffoldMaterial + 1;
    const std::vector<Region> merged = one ? std::vector<Region>() : all_materials(materials, parallel);
    materials[slice::kScaffoldMaterial] = slice::scaffold_regions(
        one ? materials[0] : merged, height, options.support, options.chord_tolerance_mm, parallel);
  }
  const std::size_t layers = materials[0].size();
  job.layers.resize(layers);
  for (std::size_t k = 0; k < layers; ++k) {
    slice::LayerRegions& l = job.layers[k];
    l.layer = std::int32_t(k) + 1;
    l.z = std::int32_t(std::lround(double(k + 1) * height_mm * geometry::kUnitsPerMm));
    l.height = height;
    if (k < contours.size()) l.contours = std::move(contours[k]);
    l.contours_alone = files.size() == 1;
    l.simplified_mm = contour_options(settings).chord_tolerance_mm;
    for (auto& m : materials) l.by_material.push_back(std::move(m[k]));
  }
  return job;
}

std::vector<std::string> material_tools(const SliceSettings& s, std::size_t materials) {
  std::vector<std::string> tools(std::max<std::size_t>(materials, 2), s.part.tool);
  tools[slice::kScaffoldMaterial] = s.scaffold.tool;
  return tools;
}

slice::PathFileHead path_file_head(const SlicedJob& job, const SliceSettings& s) {
  slice::PathFileHead head;
  head.made_by = "firn " + build_commit();
  head.layers = std::int32_t(job.layers.size());
  std::size_t materials = 2;
  for (const PartReport& p : job.parts) materials = std::max<std::size_t>(materials, p.material + 1u);
  const std::vector<std::string> tools = material_tools(s, materials);
  for (std::size_t m = 0; m < materials; ++m) head.materials.push_back({material_name(m), tools[m]});
  // Scan lines that were moved by the laser's offset are the nozzle's to follow.
  const bool moved = s.paths.measure.laser_x_mm != 0.0 || s.paths.measure.laser_y_mm != 0.0;
  head.laser = moved ? s.part.tool : s.laser_tool;
  head.settings = dump(s);
  return head;
}

void plan_layers(SlicedJob& job, const SliceSettings& settings, const ParallelFor& parallel,
                 const SliceProgress& progress, const LayerBytes& bytes,
                 const std::function<void(PlannedLayer&&)>& sink) {
  const slice::PathOptions options = path_options(settings);
  const std::size_t layers = job.layers.size();
  tbb::enumerable_thread_specific<slice::PathWork> work;
  std::vector<PlannedLayer> batch, made;  // some layers are handed on while the next ones' bytes are made
  const auto hand_on = [&] {
    for (PlannedLayer& l : made) sink(std::move(l));
    made.clear();
  };
  for (std::size_t begin = 0; begin < layers; begin += kPlannedAtOnce) {
    progress(0.4 + 0.6 * double(begin) / double(layers), fmt::format("layer {} of {}", begin + 1, layers));
    batch.clear();
    batch.resize(std::min(kPlannedAtOnce, layers - begin));
    {
      const StageTimer timer(job.times, "paths");
      parallel(int(batch.size()), [&](int n) {
        PlannedLayer& l = batch[std::size_t(n)];
        l.regions = std::move(job.layers[begin + std::size_t(n)]);
        l.paths = slice::plan_layer(l.regions, options, work.local());
        l.use = slice::material_use(l.paths);
      });
    }
    if (settings.coverage) {
      const StageTimer timer(job.times, "coverage");
      parallel(int(batch.size()), [&](int n) {
        PlannedLayer& l = batch[std::size_t(n)];
        l.coverage = slice::coverage(l.regions, l.paths, options, settings.coverage_pitch_mm);
      });
    }
    const StageTimer timer(job.times, "output");
    for (std::size_t first = 0; first < batch.size(); first += kWrittenAtOnce) {
      const std::span<PlannedLayer> some =
          std::span(batch).subspan(first, std::min(kWrittenAtOnce, batch.size() - first));
      parallel(1 + int(some.size()), [&](int n) {
        if (n == 0) return hand_on();
        PlannedLayer& l = some[std::size_t(n) - 1];
        l.transit_mm = slice::transit_mm(l.paths);
        if (bytes.encoded) l.encoded = slice::encode(l.paths);
        if (bytes.gcode) l.gcode = bytes.gcode(l.paths);
      });
      made.assign(std::move_iterator(some.begin()), std::move_iterator(some.end()));
    }
  }
  const StageTimer timer(job.times, "output");
  hand_on();
}

}  // namespace firn
