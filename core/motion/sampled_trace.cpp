#include "core/motion/sampled_trace.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

/// Rate, acceleration and jerk at sample n of a coordinate, whose ends are repeated.
template <typename Value>
std::array<double, 3> differences(Value value, std::ptrdiff_t n, std::ptrdiff_t count, double h) {
  const auto at = [&](std::ptrdiff_t i) {
    return value(std::size_t(std::clamp<std::ptrdiff_t>(i, 0, count - 1)));
  };
  const double a = at(n - 1), b = at(n), c = at(n + 1), d = at(n + 2);
  return {(c - a) / (2.0 * h), (c - 2.0 * b + a) / (h * h), (d - 3.0 * c + 3.0 * b - a) / (h * h * h)};
}

}  // namespace

std::vector<TraceSample> sampled_trace(const Trajectory& trajectory, std::span<const Point2> tool) {
  const std::size_t axes = std::size_t(trajectory.axes);
  const auto count = std::ptrdiff_t(trajectory.samples());
  const double h = trajectory.tick_s;
  std::vector<TraceSample> trace(std::size_t(count), TraceSample{});
  for (std::ptrdiff_t n = 0; n < count; ++n) {
    TraceSample& sample = trace[std::size_t(n)];
    sample.t_s = double(n) * h;
    sample.at = tool[std::size_t(n)];
    if (n > 0) {
      const Point2 before = tool[std::size_t(n - 1)];
      const double dx = sample.at.x_mm - before.x_mm, dy = sample.at.y_mm - before.y_mm;
      sample.s_mm = trace[std::size_t(n - 1)].s_mm + std::sqrt(dx * dx + dy * dy);
    }
    const auto x = differences([&](std::size_t i) { return tool[i].x_mm; }, n, count, h);
    const auto y = differences([&](std::size_t i) { return tool[i].y_mm; }, n, count, h);
    for (std::size_t k = 0; k < 3; ++k) sample.total[k] = std::sqrt(x[k] * x[k] + y[k] * y[k]);
    for (std::size_t j = 0; j < axes; ++j)
      sample.joint[j] =
          differences([&](std::size_t i) { return trajectory.positions[i * axes + j]; }, n, count, h);
  }
  return trace;
}

}  // namespace firn::motion
