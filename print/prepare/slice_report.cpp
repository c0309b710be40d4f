#include "print/prepare/slice_report.h"

#include <fmt/core.h>

#include <algorithm>

#include "files/json.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShownDefects = 20;

double mm(std::int32_t units) { return units * geometry::kMmPerUnit; }

Json json_of(const slice::Defect& d, std::size_t part) {
  Json j{{"kind", slice::name(d.kind)}, {"part", part + 1}};
  if (d.layer > 0) {
    j["layer"] = d.layer;
    j["at_mm"] = {mm(d.at.x), mm(d.at.y)};
  }
  if (d.size_mm > 0.0) j["size_mm"] = d.size_mm;
  j["count"] = d.count;
  return j;
}

Json json_of(const PartReport& p) {
  const slice::MeshFacts& f = p.facts;
  return {{"file", p.file},
          {"format", p.format},
          {"material", p.material},
          {"facets", f.facets},
          {"closed", f.closed},
          {"volume_mm3", f.volume_mm3},
          {"low_mm", {mm(f.low.x), mm(f.low.y), mm(f.low.z)}},
          {"high_mm", {mm(f.high.x), mm(f.high.y), mm(f.high.z)}},
          {"segments", p.counts.segments},
          {"contours", p.counts.contours},
          {"linked_points", p.counts.linked_points},
          {"kept_points", p.counts.kept_points},
          {"repaired_layers", p.counts.repaired_layers},
          {"file_defects", p.file_defects}};
}

Json json_of(const slice::Coverage& c, std::size_t material) {
  return {{"material", material},
          {"wanted_mm2", c.wanted_mm2},
          {"swept_mm2", c.swept_mm2},
          {"gap_mm2", c.gap_mm2},
          {"beyond_mm2", c.beyond_mm2},
          {"overlap_mm2", c.overlap_mm2},
          {"widest_gap_mm", c.widest_gap_mm},
          {"pitch_mm", c.pitch_mm}};
}

StageTime total(const std::vector<StageTime>& times) {
  StageTime sum{"total", 0.0, 0.0};
  for (const StageTime& t : times) {
    sum.wall_s += t.wall_s;
    sum.cpu_s += t.cpu_s;
  }
  return sum;
}

std::string shown(const slice::Defect& d, const PartReport& part) {
  std::string out = part.file + ": ";
  if (d.layer > 0) out += fmt::format("layer {} at {:.2f}, {:.2f} mm: ", d.layer, mm(d.at.x), mm(d.at.y));
  out += std::string(slice::explanation(d.kind));
  if (d.size_mm > 0.0) out += fmt::format(" ({:.2f} mm)", d.size_mm);
  if (d.count > 1) out += fmt::format(", {} times", d.count);
  return out + "\n";
}

// A part that no layer's plane meets leaves no trace: the report must say so.
std::vector<std::string> warnings(const SlicedJob& job, double height_mm) {
  std::vector<std::string> list;
  for (const PartReport& p : job.parts) {
    if (p.facts.facets == p.facts.not_finite || p.counts.segments > 0) continue;
    const double low = mm(p.facts.low.z), high = mm(p.facts.high.z);
    list.push_back(
        fmt::format("{}: in no layer: it reaches from z = {:g} to {:g} mm ({:g} mm high), and layers are cut "
                    "at {:g} + n x {:g} mm (layer.height_mm)",
                    p.file, low, high, high - low, 0.5 * height_mm, height_mm));
  }
  if (job.layers.empty() && list.empty()) list.push_back("no layers: the meshes hold no facets");
  return list;
}

}  // namespace

std::string material_name(std::size_t material) {
  return material == slice::kPartMaterial       ? "part"
         : material == slice::kScaffoldMaterial ? "scaffold"
                                                : fmt::format("material {}", material);
}

void SliceSums::add(const PlannedLayer& l) {
  ++totals.layers;
  totals.paths += std::int64_t(l.paths.lines.size());
  totals.points += std::int64_t(l.paths.lines.points.size());
  if (l.use.size() > totals.use.size()) totals.use.resize(l.use.size());
  for (std::size_t m = 0; m < l.use.size(); ++m) {
    totals.use[m].length_mm += l.use[m].length_mm;
    totals.use[m].volume_mm3 += l.use[m].volume_mm3;
  }
  transit_mm += l.transit_mm;
  clipper_rings += l.paths.clipper_rings;
  if (!l.coverage.empty()) coverage.push_back({l.paths.layer, l.coverage});
}

std::string slice_json(const SlicedJob& job, const SliceSettings& settings, const SliceSums& sums,
                       const std::vector<SliceOutput>& outputs, int threads) {
  Json parts = Json::array(), stages = Json::array(), defects = Json::array(), materials = Json::array(),
       files = Json::array();
  std::size_t contours = 0;
  for (std::size_t n = 0; n < job.parts.size(); ++n) {
    parts.push_back(json_of(job.parts[n]));
    contours += job.parts[n].counts.contours;
    for (const slice::Defect& d : job.parts[n].defects) defects.push_back(json_of(d, n));
  }
  std::vector<StageTime> times = job.times;
  times.push_back(total(job.times));
  for (const StageTime& t : times)
    stages.push_back({{"stage", t.stage}, {"wall_s", t.wall_s}, {"cpu_s", t.cpu_s}});
  double metres = 0.0;
  for (std::size_t m = 0; m < sums.totals.use.size(); ++m) {
    const slice::MaterialUse& u = sums.totals.use[m];
    materials.push_back({{"material", m},
                         {"name", material_name(m)},
                         {"metres", u.length_mm / 1000.0},
                         {"volume_mm3", u.volume_mm3}});
    metres += u.length_mm / 1000.0;
  }
  for (const SliceOutput& o : outputs) files.push_back({{"file", o.file}, {"bytes", o.bytes}});
  Json out{{"layers", sums.totals.layers},
           {"layer_height_mm", settings.contour.layer_height_mm},
           {"tolerance_mm", settings.contour.chord_tolerance_mm},
           {"contours", contours},
           {"paths", sums.totals.paths},
           {"points", sums.totals.points},
           {"metres", metres},
           {"transit_metres", sums.transit_mm / 1000.0},
           {"rings_by_clipper", sums.clipper_rings},
           {"threads", threads},
           {"parts", parts},
           {"materials", materials},
           {"stages", stages},
           {"defects", defects},
           {"warnings", warnings(job, settings.contour.layer_height_mm)},
           {"files", files}};
  if (settings.coverage) {
    Json layers = Json::array();
    for (const SliceSums::Layer& l : sums.coverage) {
      Json by_material = Json::array();
      for (std::size_t m = 0; m < l.coverage.size(); ++m) by_material.push_back(json_of(l.coverage[m], m));
      layers.push_back({{"layer", l.layer}, {"materials", by_material}});
    }
    out["coverage"] = layers;
  }
  return out.dump(2) + "\n";
}

std::string slice_text(const SlicedJob& job, const SliceSettings& settings, const SliceSums& sums) {
  std::string out;
  std::size_t defects = 0;
  for (const PartReport& p : job.parts) {
    out += fmt::format("{}: {}, {} facets, {}, {:.0f} mm^3; {} segments, {} contours, {} points of {} kept\n",
                       p.file, p.format, p.facts.facets, p.facts.closed ? "closed" : "not closed",
                       p.facts.volume_mm3, p.counts.segments, p.counts.contours, p.counts.kept_points,
                       p.counts.linked_points);
    for (const std::string& d : p.file_defects) out += p.file + ": " + d + "\n";
    for (const slice::Defect& d : p.defects)
      if (++defects <= kShownDefects) out += shown(d, p);
  }
  if (defects > kShownDefects)
    out += fmt::format("... and {} more defects (--json lists all)\n", defects - kShownDefects);
  for (const std::string& w : warnings(job, settings.contour.layer_height_mm)) out += "warning: " + w + "\n";
  out += fmt::format(
      "\n{} layers of {:g} mm, {} paths, {} points, {:.1f} m between paths; tolerance {:g} mm\n\n{:<12} "
      "{:>12} {:>12}\n",
      sums.totals.layers, settings.contour.layer_height_mm, sums.totals.paths, sums.totals.points,
      sums.transit_mm / 1000.0, settings.contour.chord_tolerance_mm, "material", "metres", "cm^3");
  for (std::size_t m = 0; m < sums.totals.use.size(); ++m)
    out += fmt::format("{:<12} {:>12.2f} {:>12.3f}\n", material_name(m),
                       sums.totals.use[m].length_mm / 1000.0, sums.totals.use[m].volume_mm3 / 1000.0);
  if (settings.coverage) {
    std::vector<slice::Coverage> all;
    for (const SliceSums::Layer& l : sums.coverage) {
      all.resize(std::max(all.size(), l.coverage.size()));
      for (std::size_t m = 0; m < l.coverage.size(); ++m) {
        all[m].wanted_mm2 += l.coverage[m].wanted_mm2;
        all[m].gap_mm2 += l.coverage[m].gap_mm2;
        all[m].overlap_mm2 += l.coverage[m].overlap_mm2;
        all[m].widest_gap_mm = std::max(all[m].widest_gap_mm, l.coverage[m].widest_gap_mm);
        all[m].pitch_mm = std::max(all[m].pitch_mm, l.coverage[m].pitch_mm);
      }
    }
    out += fmt::format("\n{:<12} {:>10} {:>10} {:>14}\n", "coverage", "gaps %", "twice %", "widest gap mm");
    for (std::size_t m = 0; m < all.size(); ++m)
      if (all[m].wanted_mm2 > 0.0)
        out += fmt::format("{:<12} {:>10.2f} {:>10.2f} {:>14.2f}\n", material_name(m),
                           100 * all[m].gap_mm2 / all[m].wanted_mm2,
                           100 * all[m].overlap_mm2 / all[m].wanted_mm2, all[m].widest_gap_mm) +
               (all[m].pitch_mm > settings.coverage_pitch_mm
                    ? fmt::format("{:<12} on lines {:.2f} mm apart, not coverage.pitch_mm = {:g}: the layer "
                                  "has too many metres\n",
                                  "", all[m].pitch_mm, settings.coverage_pitch_mm)
                    : "");
  }
  out += fmt::format("\n{:<12} {:>10} {:>10}\n", "stage", "wall s", "CPU s");
  for (const StageTime& t : job.times)
    out += fmt::format("{:<12} {:>10.3f} {:>10.3f}\n", t.stage, t.wall_s, t.cpu_s);
  const StageTime sum = total(job.times);
  return out + fmt::format("{:<12} {:>10.3f} {:>10.3f}\n", sum.stage, sum.wall_s, sum.cpu_s);
}

}  // namespace firn
