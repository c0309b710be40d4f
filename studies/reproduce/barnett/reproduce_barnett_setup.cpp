#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/motion/thesis/test_path.h"
#include "core/motion/vplus_default.h"
#include "studies/reproduce/barnett/reproduce_barnett_motion.h"

namespace firn::barnett {
namespace {

using namespace motion;

constexpr double kPi = std::numbers::pi;

std::vector<double> differences(const std::vector<double>& values, double tick_s) {
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) out.push_back((values[i + 1] - values[i]) / tick_s);
  return out;
}

/// Returns the places at which a closed contour crosses the line at y.
std::vector<double> crossings(const std::vector<Point2>& contour, double y) {
  std::vector<double> x;
  for (std::size_t i = 0; i + 1 < contour.size(); ++i) {
    const Point2 &a = contour[i], &b = contour[i + 1];
    if ((a.y_mm < y) != (b.y_mm < y))
      x.push_back(a.x_mm + (y - a.y_mm) / (b.y_mm - a.y_mm) * (b.x_mm - a.x_mm));
  }
  return x;
}

std::vector<double> norms(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> out;
  for (std::size_t i = 0; i < x.size(); ++i) out.push_back(std::sqrt(x[i] * x[i] + y[i] * y[i]));
  return out;
}

}  // namespace

Sampled sampled(const Trajectory& trajectory, const Arm& arm) {
  const std::size_t n = trajectory.samples();
  Jets q(arm.joints(), n), pose(kTaskAxes, n);
  for (std::size_t i = 0; i < n; ++i)
    for (int j = 0; j < arm.joints(); ++j)
      q.of(j, 0)[i] = trajectory.positions[i * std::size_t(trajectory.axes) + std::size_t(j)];
  arm.forward(q, pose);
  Sampled out;
  std::vector<double> x(pose.of(kX, 0), pose.of(kX, 0) + n), y(pose.of(kY, 0), pose.of(kY, 0) + n);
  for (std::size_t i = 0; i < n; ++i) {
    out.t_s.push_back(double(i) * trajectory.tick_s);
    out.at.push_back({x[i], y[i]});
    out.s_mm.push_back(i == 0 ? 0.0 : out.s_mm.back() + std::hypot(x[i] - x[i - 1], y[i] - y[i - 1]));
  }
  std::vector<std::vector<double>> rates;
  for (int order = 0; order < 3; ++order) {
    x = differences(x, trajectory.tick_s);
    y = differences(y, trajectory.tick_s);
    rates.push_back(norms(x, y));
  }
  out.speed = rates[0];
  out.acceleration = rates[1];
  out.jerk = rates[2];
  for (int j = 0; j < 2; ++j) {
    Sampled::Joint joint;
    for (std::size_t i = 0; i < n; ++i) joint.angle.push_back(q.of(j, 0)[i] * 180.0 / kPi);
    joint.rate = differences(joint.angle, trajectory.tick_s);
    joint.acceleration = differences(joint.rate, trajectory.tick_s);
    joint.jerk = differences(joint.acceleration, trajectory.tick_s);
    out.joints.push_back(std::move(joint));
  }
  return out;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

Chapter4 plan_chapter_4() {
  Chapter4 out;
  out.points = thesis::fig_4_2();
  out.arm = make_scara(cobra600());
  const MotionLimits limits = cobra600_limits();
  PathInput in{.points = out.points};
  in.origin = thesis::kWellPlaced;
  out.well = plan_thesis_steps(in, *out.arm, limits);
  out.well_seen = sampled(out.well.trajectory, *out.arm);
  DefaultOptions fallback;
  fallback.blend_s = out.fallback_blend_s =
      blend_for_duration(in, limits, fallback, out.well_seen.duration_s());
  out.fallback_seen = sampled(plan_default(in, *out.arm, limits, fallback), *out.arm);
  in.origin = thesis::kPoorlyPlaced;
  out.poor = plan_thesis_steps(in, *out.arm, limits);
  out.poor_seen = sampled(out.poor.trajectory, *out.arm);
  return out;
}

std::vector<Point2> box_contour(double offset, double spacing) {
  // Corners of the inner contour, counter-clockwise from the lower right, with their radii.
  const Point2 corners[] = {{92, 0}, {92, 92}, {0, 92}, {0, 0}};
  const double radii[] = {20, 10, 5, 0};
  std::vector<Point2> out;
  const auto line_to = [&](Point2 to) {
    const Point2 from = out.back();
    const double length = std::hypot(to.x_mm - from.x_mm, to.y_mm - from.y_mm);
    const int n = std::max(1, int(std::lround(length / spacing)));
    for (int i = 1; i <= n; ++i)
      out.push_back({from.x_mm + (to.x_mm - from.x_mm) * i / n, from.y_mm + (to.y_mm - from.y_mm) * i / n});
  };
  out.push_back({46, -offset});
  for (int k = 0; k < 4; ++k) {
    const double r = radii[k] + offset, start = -kPi / 2 + k * kPi / 2;
    const Point2 inward{k == 0 || k == 1 ? -radii[k] : radii[k], k == 0 || k == 3 ? radii[k] : -radii[k]};
    const Point2 centre{corners[k].x_mm + inward.x_mm, corners[k].y_mm + inward.y_mm};
    line_to({centre.x_mm + r * std::cos(start), centre.y_mm + r * std::sin(start)});
    const int n = r > 0 ? std::max(3, int(std::lround(r * kPi / 2 / spacing))) : 0;
    for (int i = 1; i <= n; ++i) {
      const double angle = start + kPi / 2 * i / n;
      out.push_back({centre.x_mm + r * std::cos(angle), centre.y_mm + r * std::sin(angle)});
    }
  }
  line_to({46, -offset});
  return out;
}

BoxLayer box_layer() {
  BoxLayer layer;
  for (const double offset : {0.75, 11.25}) layer.boundaries.push_back(box_contour(offset));
  for (const double offset : {3.0, 6.0, 9.0}) layer.contours.push_back(box_contour(offset));
  // Straight fill of the 9 mm between the boundaries, along x and 3 mm apart.
  const auto inner = box_contour(1.5), outer = box_contour(10.5);
  for (double y = -9.0; y < 102.5; y += 3.0) {
    std::vector<double> x = crossings(inner, y);
    for (const double at : crossings(outer, y)) x.push_back(at);
    std::sort(x.begin(), x.end());
    for (std::size_t i = 0; i + 1 < x.size(); i += 2) layer.lines.push_back({{x[i], y}, {x[i + 1], y}});
  }
  return layer;
}

}  // namespace firn::barnett
