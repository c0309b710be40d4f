#include "estimators/calibration/table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/statistics/distributions.h"
#include "estimators/calibration/uneven.h"

namespace firn::calibration {
namespace {

double spread(std::span<const TablePoint> points, const std::vector<double>& lift) {
  double low = std::numeric_limits<double>::max(), high = -low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double z = points[i].z_mm + (lift.empty() ? 0.0 : lift[i]);
    low = std::min(low, z);
    high = std::max(high, z);
  }
  return high - low;
}

constexpr std::size_t kPointsOfTwist = 7, kPointsOfBend = 15;
constexpr double kMin_mm = 1e-4, kBentBeforehand = 1.0 / 300.0;

void set(TableLevel& t, const std::vector<Estimate>& e) {
  t.height_mm = e[0];
  t.slope_x = e[1];
  t.slope_y = e[2];
  if (e.size() > 3) t.twist = e[3];
  if (e.size() > 4) {
    t.bend_x = e[4];
    t.bend_y = e[5];
    t.bend_xxy = e[6].value;
    t.bend_xyy = e[7].value;
    t.bend_xxyy = e[8].value;
  }
}

TableLevel plane_of(std::span<const TablePoint> points, double tolerance_mm, bool twisted,
                    std::optional<TablePoint> about = {}, bool bent = false) {
  TableLevel t;
  if (about) {
    t.middle_x_mm = about->x_mm;
    t.middle_y_mm = about->y_mm;
  } else
    for (const TablePoint& p : points) {
      t.middle_x_mm += p.x_mm / double(points.size());
      t.middle_y_mm += p.y_mm / double(points.size());
    }
  std::vector<Parameter> parameters{{"height", points.empty() ? 0.0 : points[0].z_mm, 0.1, 100.0},
                                    {"slope along x", 0.0, 1e-3, 0.5},
                                    {"slope along y", 0.0, 1e-3, 0.5}};
  if (twisted) parameters.push_back({"twist", 0.0, 1e-5, 1e-2});
  if (bent)
    parameters.insert(parameters.end(), {{"bend along x", 0.0, 1e-5, 1e-2},
                                         {"bend along y", 0.0, 1e-5, 1e-2},
                                         {"bend xxy", 0.0, 1e-7, 1e-4},
                                         {"bend xyy", 0.0, 1e-7, 1e-4},
                                         {"bend xxyy", 0.0, 1e-9, 1e-6}});
  const Residual residual = [&](std::size_t i, const double* x, double* g) {
    const TablePoint& p = points[i];
    g[0] = 1.0;
    g[1] = p.x_mm - t.middle_x_mm;
    g[2] = p.y_mm - t.middle_y_mm;
    double z = x[0] + x[1] * g[1] + x[2] * g[2];
    if (twisted) {
      g[3] = g[1] * g[2];
      z += x[3] * g[3];
    }
    if (bent) {
      g[4] = g[1] * g[1];
      g[5] = g[2] * g[2];
      g[6] = g[4] * g[2];
      g[7] = g[1] * g[5];
      g[8] = g[4] * g[5];
    }
    for (std::size_t k = 4; bent && k < 9; ++k) z += x[k] * g[k];
    return z - p.z_mm;
  };
  t.fit = robust_fit(parameters, points.size(), residual, kMin_mm);
  set(t, t.fit.parameters);
  t.spread_mm = t.left_mm = spread(points, {});
  for (const TablePoint& p : points) t.off_mm.push_back(p.z_mm - t.twisted_mm(p.x_mm, p.y_mm));
  t.level = t.spread_mm <= tolerance_mm;
  return t;
}

void add_turn(TableLevel& t, const Lifter& l, double lift_mm, double min_mm) {
  if (std::abs(lift_mm) >= min_mm) t.turns.push_back({l.name, lift_mm, lift_mm / l.pitch_mm});
}

}  // namespace

double TableLevel::plane_mm(double x_mm, double y_mm) const {
  return height_mm.value + slope_x.value * (x_mm - middle_x_mm) + slope_y.value * (y_mm - middle_y_mm);
}

double TableLevel::twisted_mm(double x_mm, double y_mm) const {
  const double dx = x_mm - middle_x_mm, dy = y_mm - middle_y_mm;
  return plane_mm(x_mm, y_mm) + twist.value * dx * dy + bend_x.value * dx * dx + bend_y.value * dy * dy +
         (bend_xxy * dx + bend_xyy * dy + bend_xxyy * dx * dy) * dx * dy;
}

TableLevel level_by_feet(std::span<const TablePoint> points, std::span<const Lifter> feet,
                         double tolerance_mm, double min_mm) {
  TableLevel t = plane_of(points, tolerance_mm, points.size() >= kPointsOfTwist);
  if (t.level || feet.empty()) return t;
  double mean = 0.0;
  for (const Lifter& f : feet) mean += t.twisted_mm(f.x_mm, f.y_mm) / double(feet.size());
  for (const Lifter& f : feet) add_turn(t, f, mean - t.twisted_mm(f.x_mm, f.y_mm), min_mm);
  std::vector<double> lift;
  for (const TablePoint& p : points) lift.push_back(mean - t.twisted_mm(p.x_mm, p.y_mm));
  t.left_mm = spread(points, lift);
  return t;
}

TableLevel table_about(std::span<const TablePoint> points, double x_mm, double y_mm, bool bent) {
  const auto fitted = [&](bool bend) {
    return plane_of(points, std::numeric_limits<double>::max(), points.size() >= kPointsOfTwist,
                    TablePoint{x_mm, y_mm, 0.0}, bend);
  };
  TableLevel t = fitted(false);
  const std::size_t flat = t.fit.parameters.size();
  try {
    if (points.size() >= kPointsOfBend) t = fitted(true);
  } catch (const Unidentifiable&) {  // these places do not identify a bend
  }
  const std::size_t all = t.fit.parameters.size();
  std::vector<UnevenDatum> data;
  for (std::size_t k = 0; k < t.fit.used.size(); ++k) {
    const TablePoint& p = points[t.fit.used[k]];
    data.push_back({p.x_mm, p.y_mm, p.z_mm, t.fit.rows[k]});
  }
  struct Belief {
    UnevenFit fit;
    double share = 1.0;
  };
  std::vector<Belief> beliefs;
  if (!bent || all == flat) beliefs.push_back({fit_uneven(data, flat, kMin_mm)});
  if (all > flat) beliefs.push_back({fit_uneven(data, all, kMin_mm)});
  if (beliefs.size() > 1) {
    const double flat_per_bent =
        std::exp(std::min(beliefs[0].fit.log_evidence - beliefs[1].fit.log_evidence, 700.0)) /
        kBentBeforehand;
    beliefs[1].share = 1.0 / (1.0 + flat_per_bent);
    beliefs[0].share = 1.0 - beliefs[1].share;
  }
  std::vector<Estimate> mixed(all);
  for (std::size_t k = 0; k < all; ++k) {
    double variance = 0.0, half = 0.0;
    const auto value = [&](const Belief& b) { return k < b.fit.value.size() ? b.fit.value[k] : 0.0; };
    for (const Belief& b : beliefs) mixed[k].value += b.share * value(b);
    for (const Belief& b : beliefs) {
      const double off = value(b) - mixed[k].value,
                   own = (k < b.fit.value.size() ? b.fit.variance[k] : 0.0) + off * off,
                   factor = statistics::student_t_95(b.fit.freedom);
      variance += b.share * own;
      half += b.share * factor * factor * own;
    }
    mixed[k].std = std::sqrt(variance);
    mixed[k].ci95_half_width = std::sqrt(half);
  }
  set(t, mixed);
  for (std::size_t i = 0; i < points.size(); ++i)
    t.off_mm[i] = points[i].z_mm - t.twisted_mm(points[i].x_mm, points[i].y_mm);
  return t;
}

TableLevel level_by_screws(std::span<const TablePoint> points, std::span<const Lifter> screws,
                           double tolerance_mm, double min_mm) {
  if (points.size() < screws.size())
    throw Unidentifiable(std::to_string(points.size()) + " points cannot tell the lifts of " +
                         std::to_string(screws.size()) + " screws");
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
    return std::max(0.0, 1.0 - std::abs(s.x_mm - p.x_mm) / reach_x) *
           std::max(0.0, 1.0 - std::abs(s.y_mm - p.y_mm) / reach_y);
  };
  // Gauss and Seidel on the screws' own points: the share of a screw at its nearest point is the largest of
  // its column.
  std::vector<double> lift(screws.size(), 0.0), at(points.size(), 0.0);
  for (int sweep = 0; sweep < 200; ++sweep)
    for (std::size_t s = 0; s < screws.size(); ++s) {
      double wanted = 0.0, weight = 0.0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double w = share(screws[s], points[i]);
        wanted += w * (mean - points[i].z_mm - at[i]);
        weight += w * w;
      }
      if (weight <= 1e-6) throw Unidentifiable("no point lies near " + screws[s].name);
      const double change = wanted / weight;
      lift[s] += change;
      for (std::size_t i = 0; i < points.size(); ++i) at[i] += change * share(screws[s], points[i]);
    }
  for (std::size_t s = 0; s < screws.size(); ++s) add_turn(t, screws[s], lift[s], min_mm);
  t.left_mm = spread(points, at);
  return t;
}

}  // namespace firn::calibration
