// Computes 4.4 of Barnett (2012): the hours of three ways of moving for the part of Fig. 4-15, and the
// components of these hours.
#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "studies/reproduce/barnett/build_time.h"
#include "studies/reproduce/barnett/reproduce_barnett_motion.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

using barnett::BuildPaths;
using motion::PathInput;

constexpr double kPaperHours[] = {11.6, 7.4, 2.6};
constexpr const char* kPlaces[] = {"p. 89, 4.4", "p. 90, 4.4", "p. 89, 4.4"};
constexpr const char* kBothHours =
    "11.6 hours using the constant-speed technique and 2.6 hours using the variable-speed technique";
constexpr const char* kTimeQuotes[] = {kBothHours, "the required construction time is 7.4 hours", kBothHours};
constexpr const char* kBetween =
    "the thesis prints no time that valve, link and controller take between two paths";
constexpr double kShare = 0.15;

// The statue of 4.3: 85 h for 48,000 paths with 14 million points, one every 16 ms (10,000 m at 0.4 mm would
// be 25 million).
constexpr double kLucyPath_s = (85.0 * 3600.0 - 14e6 * 0.016) / 48e3;

// The thesis's slicing (3.2, 3.5, 3.7): fine facets, points 0.4 mm apart, its offsets, rings alone without
// beads in the gaps between.
constexpr int kFineEdges = 200, kCoarseEdges = 16;
const std::vector<std::string> kFineScenes{"contour.tolerance_mm=0.0005"};
const std::vector<std::string> kOffsets{"part.first_offset_mm=0.6", "scaffold.first_offset_mm=1.2"};
const std::vector<std::string> kNoBeads{"part.gap_mm=0", "scaffold.gap_mm=0"};
const std::vector<std::string> kLines{"part.fill=lines", "scaffold.fill=lines"};

using Settings = std::vector<std::vector<std::string>>;

struct Builder {
  Machine machine = parse_machine(barnett::kBoxMachine, "the Cobra 600");
  std::unique_ptr<motion::Arm> arm = make_arm(machine);
  motion::MotionLimits limits = motion_limits(machine);
  barnett::BoxPart part;
  int threads = 1;

  BuildPaths paths(int edges, const Settings& settings) const {
    barnett::BoxPart p = part;
    p.round_edges = edges;
    std::vector<std::string> overrides{"layer.height_mm=0.25", "measure.on=0"};
    for (const auto& s : settings) overrides.insert(overrides.end(), s.begin(), s.end());
    return build_paths(barnett::BoxFolder(p, true), limits.position, overrides, threads);
  }
  double motion_h(barnett::Way way, const BuildPaths& of, const motion::MotionLimits& within) const {
    return motion_s(of, [&](const PathInput& in) { return duration_s(way, in, *arm, within); }) / 3600.0;
  }
  double motion_h(barnett::Way way, const BuildPaths& of) const { return motion_h(way, of, limits); }
};

std::string described(const BuildPaths& p) {
  return fmt::format("{:.0f} m in {} paths", p.length_mm() * 1e-3, p.count());
}

// Computes the variable speed's hours with one limit after another lifted.
void lift(Reproduction& to, const Builder& b, const BuildPaths& paths, double ways_h) {
  const std::string id = "barnett.build-time.lifted-";
  const auto row = [&](const std::string& name, const std::string& what, double hours) {
    to.beside({id + name, "variable speed, " + what, "h", hours});
  };
  motion::MotionLimits l = b.limits;
  l.joint = {};
  row("joints", "motion and ways without the joints' limits of (4.10)",
      ways_h + b.motion_h(barnett::Way::kVariable, paths, l));
  // Finite, as the planner wants them, and beyond anything that a path of 0.4 mm points asks for.
  l.position.jerk = 1e6;
  row("jerk", "without jerk limits either", ways_h + b.motion_h(barnett::Way::kVariable, paths, l));
  l.position.acceleration = 1e5;
  row("acceleration", "without acceleration limits either: 125 mm/s nearly everywhere",
      ways_h + b.motion_h(barnett::Way::kVariable, paths, l));
  double straight_s = 0.0;
  for (const barnett::BuildPath& p : paths.paths)
    straight_s += double(p.count) * barnett::rest_to_rest_s(p.length_mm, b.limits.position);
  row("straightened", "bound: each path straight, from rest to rest", ways_h + straight_s / 3600.0);
  row("straightened-statue",
      "the same with the statue's time from path to path: less than this 2.6 h cannot be, were it in them",
      (straight_s + kLucyPath_s * double(paths.count())) / 3600.0);
  row("length", fmt::format("bound: {} at {:.0f} mm/s", described(paths), b.limits.position.rate),
      paths.length_mm() / b.limits.position.rate / 3600.0);
  const ValveConfig& v = b.machine.valve;
  row("flow",
      fmt::format("bound: {:.0f} cm^3 at the valve's {:.0f} mm^3/s; 125 mm/s of 3.0 x 0.25 mm are {:.0f} "
                  "mm^3/s, {:.0f} of {:.0f} Hz",
                  paths.volume_mm3 * 1e-3, v.max_flow_mm3_s, 125.0 * 0.75, 125.0 * 0.75 * v.hz_per_mm3_s,
                  v.max_frequency_hz),
      paths.volume_mm3 / std::min(v.max_flow_mm3_s, v.max_frequency_hz / v.hz_per_mm3_s) / 3600.0);
}

// Walls alone, as Fig. 4-16 shows one layer of them.
void walls(Reproduction& to, const Builder& b) {
  const barnett::BoxLayer layer = barnett::box_layer();
  double wall_s[3]{};
  for (int n = 0; n < 3; ++n) {
    const auto add = [&](const std::vector<std::vector<Point2>>& lines, PathKind kind) {
      for (const std::vector<Point2>& points : lines) {
        PathInput in{.points = points};
        in.kind = kind;
        in.origin = motion::thesis::kWellPlaced;
        wall_s[n] += duration_s(barnett::Way(n), in, *b.arm, b.limits);
      }
    };
    add(layer.boundaries, PathKind::kBoundary);
    if (barnett::Way(n) == barnett::Way::kStraightConstant)
      add(layer.lines, PathKind::kFill);
    else
      add(layer.contours, barnett::Way(n) == barnett::Way::kVariable ? PathKind::kFill : PathKind::kBoundary);
  }
  const std::string id = "barnett.build-time.";
  to.row(ReproduceRow(id + "ratio",
                      "4.4: concentric fill, constant against variable speed, one layer of walls", "",
                      wall_s[1] / wall_s[2])
             .derives(kPaperHours[1] / kPaperHours[2], "Firn", "7.4 h (p. 90) over 2.6 h (p. 89)")
             .within_derived(kShare * kPaperHours[1] / kPaperHours[2]));
  to.beside({id + "straight-ratio",
             "4.4: constant speed, straight against concentric fill, one layer of walls, motion alone (11.6 "
             "h : 7.4 h)",
             "", wall_s[0] / wall_s[1]});
}

}  // namespace

void reproduce_barnett_build_time(Reproduction& to) {
  const std::string id = "barnett.build-time.";
  constexpr const char* kNames[] = {"straight", "concentric", "variable"};
  constexpr const char* kWhat[] = {"constant speed (25 mm/s, straight fill 125 mm/s)",
                                   "constant speed (25 mm/s), concentric fill",
                                   "variable speed (MTTS to 125 mm/s), concentric fill"};
  to.note(
      "The part as read from Table 5-1, plate on top, full scaffold, sliced as the thesis slices: first "
      "offsets 0.6 and 1.2 mm, fill 3.0 mm wide, finely faceted, points 0.4 mm apart, rings alone. Hours are "
      "motion "
      "along the paths and the ways between them from rest to rest within (4.10); straight fill is laid at "
      "its whole speed only (3.5), so each line has a ramp before and one behind. No time is fitted. What "
      "valve, link and controller take between two paths the text does not time; of its statue (85 h, 48,000 "
      "paths, 14 million points of 16 ms) 1.7 s a path are left, ways included. With it straight fill "
      "takes its 11.6 h; rings of variable speed would take longer than the 2.6 h. All rows have the ways "
      "alone; "
      "hours with the statue's time stand beside them.");
  Builder b;
  b.threads = to.threads();
  if (to.quick()) b.part.height_mm = 7.0;
  const Settings fine{kFineScenes, kOffsets, kNoBeads};
  BuildPaths paths[3];
  double motion_h[3], ways_h[3], hours[3];
  for (int n = 0; n < 3; ++n) {
    to.progress(n / 4.0, kNames[n]);
    if (n == 2)
      paths[n] = paths[1];
    else
      paths[n] = b.paths(kFineEdges, n == 0 ? Settings{kFineScenes, kOffsets, kNoBeads, kLines} : fine);
    motion_h[n] = b.motion_h(barnett::Way(n), paths[n]);
    ways_h[n] = (paths[n].transit_s + (n == 0 ? paths[n].run_up_s : 0.0)) / 3600.0;
    hours[n] = motion_h[n] + ways_h[n];
    const std::string what = fmt::format("4.4, {}: {:.2f} h along {}, {:.2f} h between them", kWhat[n],
                                         motion_h[n], described(paths[n]), ways_h[n]);
    ReproduceRow row(id + kNames[n], what, "h", hours[n]);
    row.prints(kPaperHours[n], kPlaces[n], kTimeQuotes[n]);
    if (to.quick())
      row.not_judged("with --quick the part is 7 mm high");
    else
      row.within(kShare * kPaperHours[n]).not_reproduced(kBetween);
    to.row(std::move(row));
  }
  const double rest_s = (kPaperHours[0] - hours[0]) * 3600.0 / double(paths[0].count());
  to.beside({id + "line", "4.4: what 11.6 h leave for valve, link and controller at each straight path", "s",
             rest_s});
  for (int n = 0; n < 3; ++n) {
    const double with = motion_h[n] + ways_h[n] - paths[n].transit_s / 3600.0 +
                        kLucyPath_s * double(paths[n].count()) / 3600.0;
    to.beside(
        {id + kNames[n] + "-statue",
         fmt::format("4.4, {}: with the statue's {:.2f} s from path to path (4.3) instead of the ways alone "
                     "({} h)",
                     kWhat[n], kLucyPath_s, kPaperHours[n]),
         "h", with});
  }
  // From Firn's own slicing to the thesis's, one setting after another.
  const auto change = [&](const char* name, const std::string& what, int edges, const Settings& settings) {
    const BuildPaths p = b.paths(edges, settings);
    to.beside({id + "slicing-" + name,
               fmt::format("variable speed, {}: motion and ways, {}", what, described(p)), "h",
               b.motion_h(barnett::Way::kVariable, p) + p.transit_s / 3600.0});
  };
  to.progress(0.75, "slicing");
  change("own", "rounds of 16 edges, chord tolerance 0.05 mm, beads in gaps, offsets 0.75 and 0.9 mm",
         kCoarseEdges, {});
  change("no-beads", "the same without beads in gaps", kCoarseEdges, {kNoBeads});
  change("offsets", "and with the thesis's offsets", kCoarseEdges, {kNoBeads, kOffsets});
  lift(to, b, paths[2], ways_h[2]);
  walls(to, b);
}

}  // namespace firn
