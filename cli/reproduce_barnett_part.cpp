// Table 5-1 and 4.4 of Barnett (2012): the part of Fig. 4-15, printed in the simulated lab and measured, and the hours that three ways
// of moving take to build it.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>

#include "cli/box_part.h"
#include "cli/box_print.h"
#include "cli/memory_print.h"
#include "cli/reproduce_barnett_motion.h"
#include "cli/reproduce_parts.h"
#include "cli/slice_job.h"
#include "cli/thread_pool.h"
#include "config/machine.h"
#include "core/motion/constant_speed.h"
#include "core/motion/thesis/test_path.h"
#include "core/motion/thesis/thesis.h"
#include "replay/report_ice.h"

namespace firn {
namespace {

using barnett::BoxPart;

struct PaperRow {
  double nominal;
  std::array<double, 4> measured;
};
constexpr PaperRow kTable51[] = {{6.0, {6.2, 6.2, 6.6, 6.3}},         {6.0, {6.0, 6.1, 6.3, 6.4}},         {123.5, {122.9, 122.9, 122.7, 122.5}}, {116.0, {116.0, 116.0, 116.4, 116.2}},
                                 {92.0, {92.3, 92.2, 92.4, 92.3}},    {25.0, {25.7, 25.7, 25.8, 25.6}},    {92.0, {92.5, 92.5, 92.8, 92.7}}};

std::string listed(std::span<const double> values) {
  std::string s;
  for (const double v : values) s += (s.empty() ? "" : " ") + fmt::format("{:.1f}", v);
  return s;
}

}  // namespace

void reproduce_barnett_part(Reproduction& to) {
  const std::string id = "barnett.part.";
  BoxPart part;
  if (to.quick()) part.side_mm = 32.0, part.height_mm = 5.0, part.plate_mm = 2.5, part.round_mm = {0.0, 6.0, 5.0, 4.0};
  to.note(
      "Fig. 5-10 is not in the text: a box on a plate has all nominal dimensions of Table 5-1 as outside dimensions, which is what 5.3 says of them. Layers of 0.25 mm, intervals "
      "of 1.25 mm, valve frequency with the optimal gains, boundaries at 25 and fill at 40 mm/s, one seed. The caliper's jaws are 3 mm wide and touch the outermost ice on the "
      "simulated true surface of the ice, without its scaffold; four places each. Water begins 0.75 mm inside the outline and scaffold 0.9 mm outside (5.3: slicing parameters "
      "could be adjusted to centre the measurements; with 0.6 and 1.2 mm of 3.7 the plate comes out 0.7 mm wider); the sharp corner is rounded by the bead and comes out smaller.");
  const double layers = part.height_mm / barnett::kBoxLayer_mm;
  const MemoryPrintReport r = barnett::print_box(part, 1, [&] { to.progress(0.0, "printing"); });
  to.row(row_holds(id + "finished", fmt::format("5.3: the part is printed, {:.0f} layers under feedback", layers), "built", r.result.outcome + (r.result.status == 0 ? "" : ": " + r.result.reason), r.result.status == 0));
  std::vector<double> rms;
  for (const LayerTruth& l : r.series) rms.push_back(l.error.rms_mm);
  if (rms.empty()) return;
  to.row(row_informative(id + "rms", "true RMS at its intervals, largest", "mm", "about 0.13 (5.3)", *std::max_element(rms.begin(), rms.end()), RowKind::kComputed));
  const std::vector<barnett::Dimension> dimensions = measured(part, r.ice);
  for (std::size_t n = 0; n < dimensions.size(); ++n) {
    const barnett::Dimension& d = dimensions[n];
    const double mean = std::accumulate(d.measured_mm.begin(), d.measured_mm.end(), 0.0) / double(d.measured_mm.size());
    const auto [least, largest] = std::minmax_element(d.measured_mm.begin(), d.measured_mm.end());
    const std::string paper = fmt::format("{:.1f}: {}", kTable51[n].nominal, listed(kTable51[n].measured));
    const double worst = std::max(std::abs(*least - d.nominal_mm), std::abs(*largest - d.nominal_mm));
    ReproduceRow row = row_holds(id + d.name, fmt::format("Table 5-1, {}: {}, nominal and four places [mm]", d.name, d.what), paper,
                                 fmt::format("{:.1f}: {} (mean {:+.2f})", d.nominal_mm, listed(d.measured_mm), mean - d.nominal_mm), worst <= (d.name == "l3" ? 1.0 : 0.5));
    row.tolerance = std::string(d.name == "l3" ? "each within 1.0 mm of nominal, as the thesis's" : "each within 0.5 mm of nominal");
    if (to.quick()) row.pass.reset(), row.kind = RowKind::kComputed, row.tolerance = "none: a part this small is mostly edges";
    to.row(std::move(row));
    if (d.name == "l3" && !to.quick()) to.row(row_holds(id + "corner", "5.3: the diagonal comes out smaller, since the corner is rounded off", "smaller", fmt::format("{:+.2f} mm", mean - d.nominal_mm), mean < d.nominal_mm));
  }
  to.picture({"fig-4-15", "Fig. 4-15 (b): thickness of the ice as built; a contour line every 5 mm", replay::shaded_relief(r.ice, 5.0, "the ice as built")});
}

namespace {

using motion::PathInput;

enum class Way { kStraightConstant, kConcentricConstant, kVariable };

/// Motion along all paths of all layers.
struct BuildTime {
  double motion_s = 0.0, length_mm = 0.0;
  std::int64_t paths = 0;
};

double duration_of(Way way, const PathInput& in, const motion::Arm& arm, const motion::MotionLimits& limits) {
  motion::ConstantOptions constant;
  constant.fill_mm_s = way == Way::kStraightConstant ? 125.0 : 25.0;  // 4.4
  const Trajectory t = way == Way::kVariable ? plan_thesis(in, arm, limits) : plan_constant(in, arm, limits, constant);
  return t.tick_s * double(t.samples() - 1);
}

BuildTime build_time(Way way, const barnett::BoxFolder& folder, const Machine& machine, int threads) {
  std::vector<std::string> overrides{"layer.height_mm=0.25", "measure.on=0"};
  if (way == Way::kStraightConstant) overrides.insert(overrides.end(), {"part.fill=lines", "scaffold.fill=lines"});
  const SliceSettings settings = load_slice_settings(folder.path / "slice.toml", overrides);
  const ParallelFor parallel = parallel_on(threads);
  const auto silent = [](double, const std::string&) {};
  SlicedJob job = slice_meshes({folder.path / "box.stl"}, settings, parallel, silent);
  const auto arm = make_arm(machine);
  const motion::MotionLimits limits = motion_limits(machine);
  std::map<std::vector<std::int32_t>, double> known;  // walls are the same in all layers
  BuildTime b;
  plan_layers(job, settings, parallel, silent, {}, [&](PlannedLayer&& l) {
    for (std::size_t n = 0; n < l.paths.info.size(); ++n) {
      const slice::PathInfo& info = l.paths.info[n];
      const auto line = l.paths.lines[n];
      if (info.kind == PathKind::kMeasurement || line.size() < 2) continue;
      std::vector<std::int32_t> key{std::int32_t(info.kind), info.closed};
      std::vector<Point2> points;
      double length = 0.0;
      for (const slice::Point& p : line) {
        key.insert(key.end(), {p.x, p.y});
        points.push_back({p.x * slice::kMmPerUnit, p.y * slice::kMmPerUnit});
        if (points.size() > 1) length += std::hypot(points.back().x_mm - points[points.size() - 2].x_mm, points.back().y_mm - points[points.size() - 2].y_mm);
      }
      if (info.closed) length += std::hypot(points.back().x_mm - points[0].x_mm, points.back().y_mm - points[0].y_mm);
      if (length < 0.4) continue;  // shorter than the thesis's sampling
      const auto [at, fresh] = known.try_emplace(std::move(key));
      if (fresh) {
        PathInput in{.points = points};
        in.kind = info.kind;
        in.closed = info.closed;
        in.origin = {motion::thesis::kWellPlaced.x_mm + 46.0, motion::thesis::kWellPlaced.y_mm + 46.0};
        at->second = duration_of(way, in, *arm, limits);
      }
      b.motion_s += at->second;
      b.length_mm += length;
      ++b.paths;
    }
  });
  return b;
}

}  // namespace

void reproduce_barnett_build_time(Reproduction& to) {
  const std::string id = "barnett.build-time.";
  constexpr double kPaperHours[] = {11.6, 7.4, 2.6};
  constexpr const char* kNames[] = {"straight", "concentric", "variable"};
  constexpr const char* kWhat[] = {"constant speed (25 mm/s, straight fill 125 mm/s)", "constant speed (25 mm/s), concentric fill", "variable speed (MTTS to 125 mm/s), concentric fill"};
  to.note(
      "The text gives neither the part's height nor its scaffold, nor what passes between two paths (travel, valve, link). So hours are not foretold but compared: the ratio of the two times of concentric fill does "
      "not depend on height, and the third time then tells what a straight line costs beside its motion. Motion alone makes straight fill faster than concentric fill at 25 mm/s: its 11.6 h are stops "
      "between lines, which the thesis does not time. The part as read from Table 5-1, with full scaffold, has many short rings and so a smaller ratio.");
  BoxPart part;
  if (to.quick()) part.height_mm = 7.0;
  const Machine machine = parse_machine(barnett::kBoxMachine, "the Cobra 600");
  const barnett::BoxFolder folder(part, true);
  BuildTime times[3];
  for (int n = 0; n < 3; ++n) {
    to.progress(n / 3.0, kNames[n]);
    times[n] = build_time(Way(n), folder, machine, to.threads());
  }
  for (int n = 0; n < 3; ++n)
    to.row(row_informative(id + kNames[n], fmt::format("4.4, {}: motion of the part as read here, plate on top, with its scaffold: {:.0f} m in {} paths", kWhat[n], times[n].length_mm * 1e-3, times[n].paths), "h",
                           kPaperHours[n], times[n].motion_s / 3600.0, RowKind::kFit));
  // Walls alone, as Fig. 4-16 shows one layer of them: what the three times say of each other.
  const auto arm = make_arm(machine);
  const motion::MotionLimits limits = motion_limits(machine);
  const barnett::BoxLayer layer = barnett::box_layer();
  double wall_s[3]{};
  for (int n = 0; n < 3; ++n) {
    const auto add = [&](const std::vector<std::vector<Point2>>& lines, PathKind kind) {
      for (const std::vector<Point2>& points : lines) {
        PathInput in{.points = points};
        in.kind = kind;
        in.origin = motion::thesis::kWellPlaced;
        wall_s[n] += duration_of(Way(n), in, *arm, limits);
      }
    };
    add(layer.boundaries, PathKind::kBoundary);
    if (Way(n) == Way::kStraightConstant) add(layer.lines, PathKind::kFill);
    else add(layer.contours, Way(n) == Way::kVariable ? PathKind::kFill : PathKind::kBoundary);
  }
  const double layers = (kPaperHours[1] - kPaperHours[2]) * 3600.0 / (wall_s[1] - wall_s[2]);
  const double line_s = (kPaperHours[0] * 3600.0 / layers - wall_s[0]) / double(layer.lines.size());
  ReproduceRow ratio = row_near(id + "ratio", "4.4: concentric fill, constant against variable speed, one layer of walls (7.4 h : 2.6 h)", "", kPaperHours[1] / kPaperHours[2], wall_s[1] / wall_s[2],
                                0.15 * kPaperHours[1] / kPaperHours[2], RowKind::kFit);
  to.row(std::move(ratio));
  to.row(row_informative(id + "straight-ratio", "4.4: constant speed, straight against concentric fill, one layer of walls, motion alone", "", kPaperHours[0] / kPaperHours[1], wall_s[0] / wall_s[1], RowKind::kFit));
  to.row(row_informative(id + "layers", "layers of walls that 7.4 - 2.6 h ask for", "", "", layers, RowKind::kFit));
  to.row(row_informative(id + "line", fmt::format("then 11.6 h ask for so long between two of a layer's {} straight lines", layer.lines.size()), "s", "", line_s, RowKind::kFit));
}

}  // namespace firn
