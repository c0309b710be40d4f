#include "estimators/calibration/table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace firn::calibration {
namespace {

double spread(std::span<const TablePoint> points, const std::vector<double>& lift) {
  double low = std::numeric_limits<double>::max(), high = -low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double z = points[i].z_mm + (lift.empty() ? 0.0 : lift[i]);
    low = std::min(low, z), high = std::max(high, z);
  }
  return high - low;
}

constexpr std::size_t kPointsOfTwist = 7, kPointsOfBend = 12;

TableLevel plane_of(std::span<const TablePoint> points, double tolerance_mm, bool twisted, std::optional<TablePoint> about = {}, bool bent = false) {
  TableLevel t;
  if (about) t.middle_x_mm = about->x_mm, t.middle_y_mm = about->y_mm;
  else for (const TablePoint& p : points) t.middle_x_mm += p.x_mm / double(points.size()), t.middle_y_mm += p.y_mm / double(points.size());
  std::vector<Unknown> unknowns{{"height", points.empty() ? 0.0 : points[0].z_mm, 0.1, 100.0}, {"slope along x", 0.0, 1e-3, 0.5}, {"slope along y", 0.0, 1e-3, 0.5}};
  if (twisted) unknowns.push_back({"twist", 0.0, 1e-5, 1e-2});
  if (bent) unknowns.insert(unknowns.end(), {{"bend along x", 0.0, 1e-5, 1e-2}, {"bend along y", 0.0, 1e-5, 1e-2}});
  const Residual residual = [&](std::size_t i, const double* x, double* g) {
    const TablePoint& p = points[i];
    g[0] = 1.0, g[1] = p.x_mm - t.middle_x_mm, g[2] = p.y_mm - t.middle_y_mm;
    double z = x[0] + x[1] * g[1] + x[2] * g[2];
    if (twisted) g[3] = g[1] * g[2], z += x[3] * g[3];
    if (bent) g[4] = g[1] * g[1], g[5] = g[2] * g[2], z += x[4] * g[4] + x[5] * g[5];
    return z - p.z_mm;
  };
  t.fit = robust_fit(unknowns, points.size(), residual, 1e-4);
  t.height_mm = t.fit.unknowns[0], t.slope_x = t.fit.unknowns[1], t.slope_y = t.fit.unknowns[2];
  if (twisted) t.twist = t.fit.unknowns[3];
  if (bent) t.bend_x = t.fit.unknowns[4], t.bend_y = t.fit.unknowns[5];
  t.spread_mm = t.left_mm = spread(points, {});
  for (const TablePoint& p : points) t.off_mm.push_back(p.z_mm - t.twisted_mm(p.x_mm, p.y_mm));
  t.level = t.spread_mm <= tolerance_mm;
  return t;
}

void add_turn(TableLevel& t, const Lifter& l, double lift_mm, double least_mm) {
  if (std::abs(lift_mm) >= least_mm) t.turns.push_back({l.name, lift_mm, lift_mm / l.pitch_mm});
}

}  // namespace

double TableLevel::plane_mm(double x_mm, double y_mm) const {
  return height_mm.value + slope_x.value * (x_mm - middle_x_mm) + slope_y.value * (y_mm - middle_y_mm);
}

double TableLevel::twisted_mm(double x_mm, double y_mm) const {
  const double dx = x_mm - middle_x_mm, dy = y_mm - middle_y_mm;
  return plane_mm(x_mm, y_mm) + twist.value * dx * dy + bend_x.value * dx * dx + bend_y.value * dy * dy;
}

TableLevel level_by_feet(std::span<const TablePoint> points, std::span<const Lifter> feet, double tolerance_mm, double least_mm) {
  TableLevel t = plane_of(points, tolerance_mm, points.size() >= kPointsOfTwist);
  if (t.level || feet.empty()) return t;
  double mean = 0.0;
  for (const Lifter& f : feet) mean += t.twisted_mm(f.x_mm, f.y_mm) / double(feet.size());
  for (const Lifter& f : feet) add_turn(t, f, mean - t.twisted_mm(f.x_mm, f.y_mm), least_mm);
  std::vector<double> lift;
  for (const TablePoint& p : points) lift.push_back(mean - t.twisted_mm(p.x_mm, p.y_mm));
  t.left_mm = spread(points, lift);
  return t;
}

TableLevel table_about(std::span<const TablePoint> points, double x_mm, double y_mm, bool bent) {
  return plane_of(points, std::numeric_limits<double>::max(), points.size() >= kPointsOfTwist, TablePoint{x_mm, y_mm, 0.0}, bent && points.size() >= kPointsOfBend);
}

TableLevel level_by_screws(std::span<const TablePoint> points, std::span<const Lifter> screws, double tolerance_mm, double least_mm) {
  if (points.size() < screws.size())
    throw Uninformative(std::to_string(points.size()) + " points cannot tell the lifts of " + std::to_string(screws.size()) + " screws");
  TableLevel t = plane_of(points, tolerance_mm, false);
  if (t.level || screws.empty()) return t;
  double reach_x = std::numeric_limits<double>::max(), reach_y = reach_x, mean = 0.0;
  for (const Lifter& a : screws)
    for (const Lifter& b : screws) {
      if (std::abs(a.x_mm - b.x_mm) > 1.0) reach_x = std::min(reach_x, std::abs(a.x_mm - b.x_mm));
      if (std::abs(a.y_mm - b.y_mm) > 1.0) reach_y = std::min(reach_y, std::abs(a.y_mm - b.y_mm));
    }
  for (const TablePoint& p : points) mean += p.z_mm / double(points.size());
  const auto share = [&](const Lifter& s, const TablePoint& p) {
    return std::max(0.0, 1.0 - std::abs(s.x_mm - p.x_mm) / reach_x) * std::max(0.0, 1.0 - std::abs(s.y_mm - p.y_mm) / reach_y);
  };
  // Gauss and Seidel on the screws' own points: the share of a screw at its nearest point is the largest of its column.
  std::vector<double> lift(screws.size(), 0.0), at(points.size(), 0.0);
  for (int sweep = 0; sweep < 200; ++sweep)
    for (std::size_t s = 0; s < screws.size(); ++s) {
      double wanted = 0.0, weight = 0.0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double w = share(screws[s], points[i]);
        wanted += w * (mean - points[i].z_mm - at[i]), weight += w * w;
      }
      if (weight <= 1e-6) throw Uninformative("no point lies near " + screws[s].name);
      const double change = wanted / weight;
      lift[s] += change;
      for (std::size_t i = 0; i < points.size(); ++i) at[i] += change * share(screws[s], points[i]);
    }
  for (std::size_t s = 0; s < screws.size(); ++s) add_turn(t, screws[s], lift[s], least_mm);
  t.left_mm = spread(points, at);
  return t;
}

}  // namespace firn::calibration
