// Computes the levelling of the table: readings at nine points, feet, then screws [2.2].
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/options/number.h"
#include "estimators/calibration/table.h"
#include "studies/calibrate/calibration_lab.h"
#include "studies/calibrate/lab_calibrations.h"

namespace firn {
namespace {

using calibration::Lifter;
using calibration::TableLevel;
using calibration::TablePoint;

constexpr double kCoarse_mm = 0.5, kFine_mm = 0.2;
constexpr double kHeightTolerance_mm = 0.05;

std::vector<Lifter> feet_of(const CalibrationConfig& c) {
  std::vector<Lifter> feet;
  for (const double y : {-0.5, 0.5})
    for (const double x : {-0.5, 0.5})
      feet.push_back({"foot " + std::to_string(feet.size() + 1), c.table_x_mm + x * c.table_width_mm,
                      c.table_y_mm + y * c.table_depth_mm, c.foot_pitch_mm});
  return feet;
}

std::vector<Lifter> screws_of(const CalibrationConfig& c) {
  std::vector<Lifter> screws;
  for (const double y : {-0.5, 0.0, 0.5})
    for (const double x : {-0.5, 0.0, 0.5})
      screws.push_back({"screw " + std::to_string(screws.size() + 1), c.table_x_mm + x * c.table_width_mm,
                        c.table_y_mm + y * c.table_depth_mm, c.screw_pitch_mm});
  return screws;
}

std::vector<TablePoint> grid_of(const std::vector<double>& xs, const std::vector<double>& ys) {
  std::vector<TablePoint> points;
  for (const double y : ys)
    for (const double x : xs) points.push_back({x, y, 0.0});
  return points;
}

std::vector<double> between(const std::vector<double>& v) {
  std::vector<double> middles;
  for (std::size_t n = 1; n < v.size(); ++n) middles.push_back(0.5 * (v[n - 1] + v[n]));
  return middles;
}

constexpr double kApartShare = 0.9;  // of the spacing of the points of 2.2
constexpr double kEdge_mm = 10.0, kTableStep_mm = 10.0;

double distance_to(const std::vector<TablePoint>& points, const TablePoint& p) {
  double nearest = std::numeric_limits<double>::max();
  for (const TablePoint& q : points)
    nearest = std::min(nearest, std::hypot(q.x_mm - p.x_mm, q.y_mm - p.y_mm));
  return nearest;
}

// The points of 2.2 determine the foot and the screw to turn; nine of them leave the height uncertain by a
// third of the table's unevenness. So more points are read once all turns are done: the rows between along
// the side with the wider spacing, then places of the table within the arm's reach beyond them, always the
// place farthest from all others. Places nearer to each other than kApartShare share their unevenness: they
// would make the intervals narrower and the height no better.
std::vector<TablePoint> more_points(const CalibrationLab& lab) {
  const CalibrationConfig& c = lab.experiment().calibration;
  const auto &xs = c.level_x_mm, &ys = c.level_y_mm;
  const auto step = [](const std::vector<double>& v) {
    return v.size() < 2 ? 0.0 : std::abs(v.back() - v.front()) / double(v.size() - 1);
  };
  std::vector<TablePoint> more = step(ys) >= step(xs) ? grid_of(xs, between(ys)) : grid_of(between(xs), ys),
                          all = grid_of(xs, ys);
  all.insert(all.end(), more.begin(), more.end());
  const double apart_mm = kApartShare * std::min(step(xs), step(ys));
  if (apart_mm <= kTableStep_mm) return more;
  std::vector<TablePoint> places;
  for (double y = c.table_y_mm - 0.5 * c.table_depth_mm + kEdge_mm;
       y <= c.table_y_mm + 0.5 * c.table_depth_mm - kEdge_mm; y += kTableStep_mm)
    for (double x = c.table_x_mm - 0.5 * c.table_width_mm + kEdge_mm;
         x <= c.table_x_mm + 0.5 * c.table_width_mm - kEdge_mm; x += kTableStep_mm)
      if (distance_to(all, {x, y, 0.0}) >= apart_mm && lab.reaches(x, y)) places.push_back({x, y, 0.0});
  while (true) {
    std::erase_if(places, [&](const TablePoint& p) { return distance_to(all, p) < apart_mm; });
    if (places.empty()) return more;
    const TablePoint far = *std::max_element(
        places.begin(), places.end(),
        [&](const TablePoint& a, const TablePoint& b) { return distance_to(all, a) < distance_to(all, b); });
    all.push_back(far);
    more.push_back(far);
  }
}

void measure(CalibrationLab& lab, std::vector<TablePoint>& points,
             const std::function<void(double)>& progress) {
  std::size_t read = 0;
  for (TablePoint& p : points) {
    p.z_mm = lab.surface_mm(p.x_mm, p.y_mm);
    if (progress) progress(double(++read) / double(points.size()));
  }
}

/// Turns feet or screws as an operator does who follows the instructions exactly.
void turn(const TableLevel& t, bool feet, IcePlantConfig& table, LabCalibration& out) {
  std::vector<double>&heights = feet ? table.foot_mm : table.screw_mm,
  &lifts = feet ? out.foot_lift_mm : out.screw_lift_mm;
  heights.resize(feet ? 4 : 9, 0.0);
  for (const calibration::Turn& done : t.turns) {
    const std::size_t n =
        whole_number<std::size_t>(std::string_view(done.name).substr(done.name.find(' ') + 1)).value() - 1;
    heights[n] += done.lift_mm;
    lifts[n] += done.lift_mm;
  }
}

std::string told(const calibration::Turn& t, const std::vector<Lifter>& lifters) {
  const auto l =
      std::find_if(lifters.begin(), lifters.end(), [&](const Lifter& x) { return x.name == t.name; });
  return fmt::format("turn {} at ({:.0f}, {:.0f}) mm {} by {:.2f} turns: {} by {:.2f} mm", t.name, l->x_mm,
                     l->y_mm, t.turns > 0.0 ? "clockwise" : "counterclockwise", std::abs(t.turns),
                     t.lift_mm > 0.0 ? "up" : "down", std::abs(t.lift_mm));
}

}  // namespace

LabCalibration calibrate_table(const Experiment& experiment, const std::string& machine_toml,
                               const LabCalibrationOptions& o) {
  Experiment e = lab_calibrations::with_field(experiment, -60.0, -60.0, 10.0, 10.0);
  const std::vector<Lifter> feet = feet_of(e.calibration), screws = screws_of(e.calibration);
  LabCalibration out;
  out.what = "level-table";
  out.foot_lift_mm.assign(feet.size(), 0.0);
  out.screw_lift_mm.assign(screws.size(), 0.0);
  TableLevel t;
  std::vector<TablePoint> points;
  bool screwed = false;  // screws bend the table
  for (int round = 1;; ++round) {
    CalibrationLab lab(e, machine_toml);
    lab.get_ready();
    points = grid_of(e.calibration.level_x_mm, e.calibration.level_y_mm);
    measure(lab, points, [&](double share) {
      if (o.progress) o.progress((round - 1 + share) / o.rounds);
    });
    t = calibration::level_by_feet(points, feet, kCoarse_mm);
    // Feet cannot bend the table: where no foot needs a turn, the screws follow.
    const bool coarse = !t.level && !t.turns.empty();
    const TableLevel fit = t;
    if (!coarse) t = calibration::level_by_screws(points, screws, kFine_mm);
    out.level = !coarse && t.level;
    const std::string measured = fmt::format("{} points lie within {:.3f} mm", points.size(), t.spread_mm);
    if (out.level) {
      out.lines.push_back(fmt::format("{}: level ({} mm)", measured, kFine_mm));
    } else {
      out.lines.push_back(fmt::format("{}; {} mm is wanted: {}, which should leave {:.3f} mm", measured,
                                      coarse ? kCoarse_mm : kFine_mm,
                                      coarse ? "turn the feet" : "turn the screws", t.left_mm));
      for (const calibration::Turn& turn : t.turns)
        out.lines.push_back("  " + told(turn, coarse ? feet : screws));
      if (t.turns.empty())
        out.lines.push_back("  no turn of these would help: the table is bent between the points");
    }
    const TableLevel told_now = t;
    t = fit;
    if (out.level || round >= o.rounds || told_now.turns.empty()) {
      std::vector<TablePoint> more = more_points(lab);
      measure(lab, more, {});
      points.insert(points.end(), more.begin(), more.end());
      std::stable_sort(points.begin(), points.end(),
                       [](const TablePoint& a, const TablePoint& b) { return a.y_mm < b.y_mm; });
      t = calibration::table_about(points, fit.middle_x_mm, fit.middle_y_mm, screwed);
      out.lines.push_back(
          fmt::format("height and slopes from {} points, {} of them between and beside the first",
                      points.size(), more.size()));
      out.lab_s += lab.now_s();
      break;
    }
    out.lab_s += lab.now_s();
    turn(told_now, coarse, e.plant.ice, out);
    screwed |= !coarse;
  }
  out.data = t.fit.data;
  out.outliers = t.fit.outliers;
  out.residual_std = t.fit.residual_std;
  out.residual_unit = "mm";
  out.also = {{"height at the levelling points' middle [mm]", t.height_mm},
              {"slope along x [mm/mm]", t.slope_x},
              {"slope along y [mm/mm]", t.slope_y},
              {"twist [mm/mm^2]", t.twist}};
  out.plot = {"x [mm]", "point off the table fitted [mm]", {}};
  for (std::size_t n = 0; n < points.size(); ++n) {
    const std::string label = fmt::format("y = {:.0f} mm", points[n].y_mm);
    if (out.plot.groups.empty() || out.plot.groups.back().label != label)
      out.plot.groups.push_back({label, {}, {}});
    out.plot.groups.back().x.push_back(points[n].x_mm);
    out.plot.groups.back().y.push_back(t.off_mm[n]);
  }
  if (t.height_mm.ci95_half_width > 3.0 * kHeightTolerance_mm)
    throw calibration::Unidentifiable(
        fmt::format("the table's height is known to +- {:.3f} mm only", t.height_mm.ci95_half_width));
  if (out.level)
    out.keys = {{"ice",
                 "origin_z_mm",
                 "mm",
                 {experiment.ice.origin_z_mm + t.height_mm.value},
                 {t.height_mm.ci95_half_width},
                 {experiment.ice.origin_z_mm},
                 3,
                 false,
                 3.0 * kHeightTolerance_mm}};
  return out;
}

}  // namespace firn
