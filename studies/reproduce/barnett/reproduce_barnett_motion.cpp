// Computes the rows of chapter 4. The thesis prints its trajectories as figures without numbers, so most rows
// test the statements of its text about them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/motion/constant_speed.h"
#include "core/motion/planner.h"
#include "core/motion/thesis/test_path.h"
#include "core/motion/vplus_default.h"
#include "core/path/polyline.h"
#include "studies/reproduce/barnett/reproduce_barnett_motion.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

using namespace motion;
using namespace barnett;

std::string id(const char* name) { return std::string("barnett.motion.") + name; }

double duration(const Trajectory& t) { return double(t.samples() - 1) * t.tick_s; }

void start_rows(Reproduction& to, const Chapter4& c) {
  const double h = 0.016, ideal = 4000 * h * h * h / 6, lifted = ideal + 80 * h * h / 2;
  const Point2 at{thesis::kWellPlaced.x_mm + 46, thesis::kWellPlaced.y_mm};
  const JointVector before = c.arm->inverse({at.x_mm, at.y_mm, 0, 0}, {1, 0});
  const auto counts = [&](double distance) {  // of the joint that moves less, in its encoder's counts
    const JointVector after = c.arm->inverse({at.x_mm + distance, at.y_mm, 0, 0}, {1, 0});
    const double degree = 180 / std::numbers::pi;
    return std::pair{std::abs(after[0] - before[0]) * degree / 0.00045,
                     std::abs(after[1] - before[1]) * degree / 0.00072};
  };
  const auto [a1, a2] = counts(ideal);
  const auto [b1, b2] = counts(lifted);
  to.row(ReproduceRow(id("start-ideal"),
                      "4.2.6: travel of the joints in the first tick with a(0) = 0, in encoder counts", "",
                      fmt::format("{:.2f} and {:.2f} counts", a1, a2))
             .prints("below these resolutions", "p. 80, 4.2.6",
                     "will be below these resolutions if the ideal path end conditions are imposed")
             .holds(std::min(a1, a2) < 1, "less than a count"));
  to.row(ReproduceRow(id("start-80"), "4.2.6: the same with a(0) = 80 mm/s2", "",
                      fmt::format("{:.2f} and {:.2f} counts", b1, b2))
             .prints("displacements above the joint positioning resolutions", "p. 80, 4.2.6",
                     "To produce displacements above the joint positioning resolutions")
             .holds(std::min(b1, b2) > 1, "more than a count"));
}

double speed_at(const thesis::Profile& p, double s) {
  std::size_t k = 0;
  while (k + 2 < p.size() && p.s_mm[k + 1] < s) ++k;
  return (p.s_mm[k + 1] - p.s_mm[k]) / p.dt_s[k];
}

void path_rows(Reproduction& to, const Chapter4& c) {
  to.row(
      ReproduceRow(id("pieces"), "4.2.2: pieces of the path of Fig. 4-2", "", double(c.well.steps.size()), 0)
          .prints("two pieces", "p. 74, 4.2.2", "is split into two pieces at the 90° corner")
          .holds(c.well.steps.size() == 2, "2"));
  int minima = 0, maxima = 0;
  double at = 26;
  for (const auto& [radius, line] : {std::pair{20.0, 62.0}, {10.0, 77.0}, {5.0, 87.0}}) {
    const double arc = radius * std::numbers::pi / 2;
    const auto& p = c.well.steps[0].final;
    const double in = speed_at(p, at), centre = speed_at(p, at + arc / 2), out = speed_at(p, at + arc);
    minima += (in < speed_at(p, at - 5) && in < centre) + (out < centre && out < speed_at(p, at + arc + 5));
    maxima += centre > in && centre > out;
    at += arc + line;
  }
  to.row(ReproduceRow(id("speed-minima"),
                      "Fig. 4-7: local minima of speed at the 6 jumps of curvature (3 rounds)", "",
                      double(minima), 0)
             .prints("local minima in speed at these curvature discontinuities", "p. 82, 4.3",
                     "MTTS imposes local minima in speed at these curvature discontinuities")
             .holds(minima == 6, "6"));
  to.row(ReproduceRow(id("speed-maxima"), "Fig. 4-7: local maxima of speed at the centres of the 3 rounds",
                      "", double(maxima), 0)
             .prints("local maxima at the centers of the rounds", "p. 82, 4.3",
                     "speed increases to local maxima at the centers of the rounds")
             .holds(maxima == 3, "3"));
}

void peak_rows(Reproduction& to, const Chapter4& c) {
  to.beside(
      {id("speed"), "Fig. 4-7: highest speed over its limit 125 mm/s", "", largest(c.well_seen.speed) / 125});
  to.beside({id("acceleration"),
             "Fig. 4-7: highest total acceleration over its limit 500 mm/s2 (ACON's margin: 10 %)", "",
             largest(c.well_seen.acceleration) / 500});
  const auto peaks = [](const Sampled& s) {
    int count = 0;
    for (std::size_t i = 1; i + 1 < s.jerk.size(); ++i)
      count += s.jerk[i] > 4000 * 1.05 && s.jerk[i] >= s.jerk[i - 1] && s.jerk[i] > s.jerk[i + 1];
    return count;
  };
  to.row(
      ReproduceRow(id("jerk-exceeds"), "4.3: the jerk exceeds its limit", "",
                   fmt::format("at {} peaks, up to {:.2f} times", peaks(c.well_seen),
                               largest(c.well_seen.jerk) / 4000))
          .prints("at several locations", "p. 82, 4.3",
                  "also shows the jerk exceeding $\\ddot{s}_{\\text{max}}^{\\dagger}$ at several locations")
          .holds(peaks(c.well_seen) >= 3, "three or more peaks above 1.05"));
  to.beside({id("jerk-poor"), "the same, poorly placed path: highest total jerk over its limit", "",
             largest(c.poor_seen.jerk) / 4000});
}

void placement_rows(Reproduction& to, const Chapter4& c) {
  to.beside({id("time-well"), "Fig. 4-7: time of travel, well placed (jerk-safe optimum: 5.165 s)", "s",
             c.well_seen.duration_s()});
  to.beside({id("time-poor"), "Fig. 4-9: time of travel, poorly placed (jerk-safe optimum: 6.102 s)", "s",
             c.poor_seen.duration_s()});
  const auto seconds = [](const ThesisResult& r, double from, double until) {
    double sum = 0;
    const auto& p = r.steps[0].final;
    for (std::size_t k = 0; k < p.dt_s.size(); ++k)
      if (p.s_mm[k] >= from && p.s_mm[k + 1] <= until) sum += p.dt_s[k];
    return sum;
  };
  const double along_x = seconds(c.poor, 135.2, 212.1) / seconds(c.well, 135.2, 212.1);
  const double along_y = seconds(c.poor, 65, 110) / seconds(c.well, 65, 110);
  to.row(
      ReproduceRow(id("along-x-and-y"), "4.3: time along x and along y, poorly against well placed", "",
                   fmt::format("time x {:.2f}; x {:.2f}", along_x, along_y))
          .prints(
              "mostly unchanged", "p. 82, 4.3",
              "motion along the x axis is significantly restricted, while motion along the y axis is mostly "
              "unchanged")
          .holds(along_x > 1.3 && along_y < 1.1, "x > 1.3, y < 1.1"));
  int lower = 0, upper = 0, elsewhere = 0;
  const auto& rate = c.poor_seen.joints[1].rate;
  for (std::size_t i = 0; i + 1 < c.poor.steps[0].final.size(); ++i) {
    if (std::abs(rate[i]) < 0.98 * 39) continue;
    const double s = c.poor.steps[0].final.s_mm[i];
    (s < 57.5 ? lower : s > 119.3 && s < 212.2 ? upper : elsewhere) += 1;
  }
  to.row(
      ReproduceRow(
          id("theta-2-rate"), "Fig. 4-9: places where the rate of theta 2 is at its limit (first piece)", "",
          fmt::format("lower right ({} ticks), upper side ({} ticks), elsewhere {}", lower, upper, elsewhere))
          .prints("in both regions", "p. 82, 4.3",
                  "has been imposed in both regions where the motion has been significantly affected")
          .holds(lower > 5 && upper > 5 && elsewhere == 0, "both, none elsewhere"));
}

void certified_rows(Reproduction& to, const Chapter4& c) {
  PathInput in{.points = c.points};
  for (const auto& [name, origin] :
       {std::pair{"well", thesis::kWellPlaced}, {"poor", thesis::kPoorlyPlaced}}) {
    in.origin = origin;
    const PlanResult r = plan(in, *c.arm, cobra600_limits());
    double worst = 0;
    for (const LimitRatio& limit : r.trajectory.certificate.limits) worst = std::max(worst, limit.ratio);
    to.beside(
        {id((std::string("certified-") + name).c_str()),
         fmt::format("the same path, {} placed, --method certified ({:.3f} s): largest of the nine ratios",
                     name == std::string("well") ? "well" : "poorly", r.trajectory.certificate.duration_s),
         "", worst, 4});
  }
}

double distance_to(const std::vector<Point2>& path, Point2 p) {
  double nearest = 1e300;
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    nearest = std::min(nearest, squared_distance(p, path[i], path[i + 1]));
  return std::sqrt(nearest);
}

void default_rows(Reproduction& to, const Chapter4& c) {
  const Sampled &mtts = c.well_seen, &v = c.fallback_seen;
  to.beside({id("default-time"),
             "4.4: time of the default technique, its acceleration adjusted to MTTS's time", "s",
             v.duration_s()});
  constexpr const char* kFitted = "blend time and spacing of points of our model of V+'s default technique";
  to.row(ReproduceRow(id("default-radius"),
                      "Fig. 4-13: radius to which the default technique rounds the 90 degree corner", "mm",
                      125 * c.fallback_blend_s / 2)
             .prints(10.0, "p. 86, 4.4", "is rounded off to a radius of approximately 10 mm")
             .within(1.0)
             .fitted(kFitted));
  double worst = 0, corner = 1e300;
  for (const Point2& p : mtts.at)
    worst = std::max(
        worst, distance_to(c.points, {p.x_mm - thesis::kWellPlaced.x_mm, p.y_mm - thesis::kWellPlaced.y_mm}));
  for (const Point2& p : v.at)
    corner =
        std::min(corner, std::hypot(p.x_mm - thesis::kWellPlaced.x_mm, p.y_mm - thesis::kWellPlaced.y_mm));
  to.row(ReproduceRow(id("mtts-deviation"), "Fig. 4-13: farthest commanded MTTS sample from the path", "mm",
                      worst, 4)
             .prints("followed very closely", "p. 86, 4.4",
                     "the test path is followed very closely by the robot when the trajectory control data "
                     "supplied by "
                     "MTTS is used")
             .at_most(0.05)
             .not_identifiable("the figure is of joint encoders, and the thesis does not print how its servo "
                               "follows: ours are the commanded samples"));
  to.beside({id("default-corner"), "Fig. 4-13: distance at which the default technique passes the corner",
             "mm", corner});
  const auto mean_speed = [](const Sampled& s, Point2 centre, double radius) {  // on the round's quarter
    double length = 0, time = 0;
    for (std::size_t i = 0; i + 1 < s.at.size(); ++i) {
      const double x = s.at[i].x_mm - thesis::kWellPlaced.x_mm - centre.x_mm,
                   y = s.at[i].y_mm - thesis::kWellPlaced.y_mm - centre.y_mm;
      if (x < 0 || y * (centre.y_mm < 46 ? -1 : 1) < 0 || std::abs(std::hypot(x, y) - radius) > 0.2 * radius)
        continue;
      length += s.speed[i] * 0.016;
      time += 0.016;
    }
    return length / time;
  };
  const double m20 = mean_speed(mtts, {72, 20}, 20), d20 = mean_speed(v, {72, 20}, 20);
  const double m10 = mean_speed(mtts, {82, 82}, 10), d10 = mean_speed(v, {82, 82}, 10);
  to.row(ReproduceRow(id("default-rounds"),
                      "Fig. 4-12: speed on the 20 and 10 mm rounds, default against MTTS", "",
                      fmt::format("{:.0f} : {:.0f} and {:.0f} : {:.0f} mm/s", d20, m20, d10, m10))
             .prints("very slowly", "p. 87, 4.4",
                     "the robot follows the 10 mm and 20 mm rounds very slowly, when compared to MTTS")
             .holds(d20 < 0.6 * m20 && d10 < m10, "less than 0.6 and less")
             .fitted(kFitted));
  to.row(
      ReproduceRow(id("default-acceleration"), "Fig. 4-12: highest acceleration, default against MTTS", "",
                   fmt::format("{:.0f} : {:.0f} mm/s2", largest(v.acceleration), largest(mtts.acceleration)))
          .prints("all higher for the default technique", "p. 87, 4.4",
                  "The accelerations reached are all higher for the default technique")
          .holds(largest(v.acceleration) > largest(mtts.acceleration), "higher")
          .fitted(kFitted));
  to.row(ReproduceRow(id("default-jerk"), "Fig. 4-12: highest jerk, default against MTTS", "",
                      fmt::format("{:.0f} : {:.0f} mm/s3", largest(v.jerk), largest(mtts.jerk)))
             .prints("much smaller for MTTS", "p. 87, 4.4", "The jerk is also much smaller for MTTS")
             .holds(largest(v.jerk) > 2 * largest(mtts.jerk), "more than twice")
             .fitted(kFitted));
}

// The distance between samples carries the speed.
void spacing_row(Reproduction& to, const Chapter4& c) {
  constexpr double kCorner_mm = 2.0;
  const Sampled& s = c.well_seen;
  double corner_mm = 1e300, widest_mm = 0.0;
  for (std::size_t i = 0; i + 1 < s.at.size(); ++i) {
    const double step_mm = s.s_mm[i + 1] - s.s_mm[i];
    widest_mm = std::max(widest_mm, step_mm);
    if (i > 0 && i + 2 < s.at.size() &&
        std::hypot(s.at[i].x_mm - thesis::kWellPlaced.x_mm, s.at[i].y_mm - thesis::kWellPlaced.y_mm) <
            kCorner_mm)
      corner_mm = std::min(corner_mm, step_mm);
  }
  to.row(ReproduceRow(
             id("spacing"),
             "Fig. 4-11, on the path of Fig. 4-2 instead of the statue's layer: distance of samples 16 ms "
             "apart, least at the corner and widest",
             "", fmt::format("{:.4f} and {:.2f} mm", corner_mm, widest_mm))
             .prints(
                 "very dense in sharp corners", "p. 83, 4.3, Fig. 4-11",
                 "The spacing is very dense in sharp corners and becomes coarser in regions of low curvature")
             .holds(corner_mm < 0.1 * widest_mm, "less than a tenth"));
}

// Fig. 4-10: the statue's mesh is public, but not how the thesis placed, sliced and supported it.
void statue_rows(Reproduction& to) {
  constexpr const char* kWhy =
      "not computed: the thesis does not print how it placed, sliced and supported the statue";
  to.row(ReproduceRow(id("statue-variable"), "4.4, Fig. 4-10: construction time of the statue, MTTS", "days",
                      std::string())
             .prints(3.5, "p. 90, 4.4", "the construction time being 3.5 days")
             .not_identifiable(kWhy));
  to.row(ReproduceRow(id("statue-constant"), "4.4, Fig. 4-10: the same at constant speed with straight fill",
                      "days", std::string())
             .prints("over 5 days", "p. 90, 4.4", "construction time is predicted to be over 5 days")
             .not_identifiable(kWhy));
}

// The abstract's build volume against the arm's reach: the largest square about a point of the arm's middle
// line.
void volume_row(Reproduction& to, const Chapter4& c) {
  constexpr double kStep_mm = 5.0;
  const auto reached = [&](double x_mm, double y_mm) {
    try {
      c.arm->inverse({x_mm, y_mm, 0, 0}, {1, 0});
      return true;
    } catch (const MotionError&) {
      return false;
    }
  };
  const auto holds_square = [&](double middle_mm, double side_mm) {
    const double half = 0.5 * side_mm;
    for (double t = -half; t <= half; t += kStep_mm)
      if (!reached(middle_mm + t, -half) || !reached(middle_mm + t, half) || !reached(middle_mm - half, t) ||
          !reached(middle_mm + half, t))
        return false;
    return true;
  };
  double side_mm = 0.0;
  for (double middle_mm = 200.0; middle_mm <= 500.0; middle_mm += kStep_mm)
    while (holds_square(middle_mm, side_mm + kStep_mm)) side_mm += kStep_mm;
  const JointRange stroke = c.arm->range(2);
  const double height_mm = stroke.high - stroke.low;
  to.row(ReproduceRow(id("build-volume"), "abstract: largest square within the arm's reach, and its stroke",
                      "mm", fmt::format("{:.0f} x {:.0f} x {:.0f}", side_mm, side_mm, height_mm))
             .prints("300 x 300 x 200", "p. iii, abstract", "$300 \\times 300 \\times 200$ mm")
             .holds(side_mm >= 300.0 && height_mm >= 200.0, "at least")
             .arithmetic());
}

void box_rows(Reproduction& to, const Chapter4& c) {
  const BoxLayer layer = box_layer();
  const MotionLimits limits = cobra600_limits();
  const auto time = [&](const std::vector<Point2>& points, bool mtts, PathKind kind) {
    PathInput in{.points = points};
    in.origin = thesis::kWellPlaced;
    in.kind = kind;
    ConstantOptions constant;
    constant.fill_mm_s = 125;  // 4.4
    return duration(mtts ? plan_thesis(in, *c.arm, limits) : plan_constant(in, *c.arm, limits, constant));
  };
  double variable = 0, straight = 0;
  for (const auto& p : layer.boundaries) {
    variable += time(p, true, PathKind::kBoundary);
    straight += time(p, false, PathKind::kBoundary);
  }
  for (const auto& p : layer.contours) variable += time(p, true, PathKind::kFill);
  for (const auto& p : layer.lines) straight += time(p, false, PathKind::kFill);
  to.beside(
      {id("box-mtts"), "4.4: MTTS, one wall layer of the box of Fig. 4-15: motion alone", "s", variable});
  to.beside(
      {id("box-straight"),
       "4.4: constant speed with straight fill against MTTS, without the moves, waits and valve between the "
       "lines (11.6 h : 2.6 h)",
       "", straight / variable});
}

}  // namespace

void reproduce_barnett_motion(Reproduction& to) {
  to.note(
      "MTTS as the thesis describes it, with the errata of chapter 4. The figures carry no numbers, so these "
      "rows test what the "
      "text says about them. Coordinates of Fig. 4-3 (origin (354, -46) and (505.899, -46)), the model of "
      "the V+ default technique "
      "(blend time, points every 3.5 mm on the rounds) and the box's layer are choices: rows of kind fit. "
      "Speeds, accelerations and "
      "jerks are differences of the emitted samples at 16 ms.");
  to.progress(0.0, "thesis method");
  const Chapter4 planned = plan_chapter_4();
  start_rows(to, planned);
  path_rows(to, planned);
  peak_rows(to, planned);
  placement_rows(to, planned);
  certified_rows(to, planned);
  default_rows(to, planned);
  spacing_row(to, planned);
  statue_rows(to);
  volume_row(to, planned);
  to.progress(0.5, "box of Fig. 4-15");
  box_rows(to, planned);
  pictures(to, planned);
}

}  // namespace firn
