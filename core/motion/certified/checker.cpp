#include "core/motion/certified/checker.h"

#include <cmath>
#include <string>

namespace firn::motion {
namespace {

/// Largest norms of the first three differences of up to two coordinates given as (first entry, stride).
void largest_differences(const double* a, const double* b, std::size_t stride, std::size_t count, double tick,
                         const RateLimits& limit, double* ratio, double* time) {
  const double limits[3] = {limit.rate * tick, limit.acceleration * tick * tick,
                            limit.jerk * tick * tick * tick};
  const std::ptrdiff_t last = std::ptrdiff_t(count) - 1;
  const auto value = [&](const double* p, std::ptrdiff_t n) {
    return p[std::size_t(n < 0 ? 0 : n > last ? last : n) * stride];
  };
  const double* const coordinate[2] = {a, b};
  const int coordinates = b ? 2 : 1;
  double first[2], second[2], end[2], most[3] = {0.0, 0.0, 0.0};  // first differences; squares of the largest
  for (int c = 0; c < coordinates; ++c) {
    first[c] = second[c] = 0.0;
    end[c] = value(coordinate[c], 0);
  }
  for (std::ptrdiff_t n = -2; n <= std::ptrdiff_t(count); ++n) {
    double square[3] = {0.0, 0.0, 0.0};
    for (int c = 0; c < coordinates; ++c) {
      const double next = value(coordinate[c], n + 2), third = next - end[c];
      const double bend = second[c] - first[c], d3 = (third - second[c]) - bend;
      square[0] += second[c] * second[c];
      square[1] += bend * bend;
      square[2] += d3 * d3;
      first[c] = second[c];
      second[c] = third;
      end[c] = next;
    }
    for (int k = 0; k < 3; ++k) {
      if (!(square[k] > most[k])) continue;
      most[k] = square[k];
      const double r = std::sqrt(square[k]) / limits[k];
      if (r > ratio[k]) {
        ratio[k] = r;
        time[k] = tick * double(n < 0 ? 0 : n);
      }
    }
  }
}

}  // namespace

RatioTable difference_ratios(const Trajectory& trajectory, std::span<const Point2> tool,
                             std::span<const double> yaw_rad, const RowGroups& groups) {
  RatioTable table;
  static_assert(sizeof(Point2) == 2 * sizeof(double));
  const std::size_t count = trajectory.samples(), axes = std::size_t(trajectory.axes);
  if (count == 0) return table;
  largest_differences(&tool[0].x_mm, &tool[0].y_mm, 2, count, trajectory.tick_s, groups.group[0].limit,
                      table.ratio[0], table.time_s[0]);
  for (int g = 1; g < groups.count; ++g) {
    const RowGroup& group = groups.group[g];
    if (group.of == Quantity::kJoint)
      largest_differences(trajectory.positions.data() + group.joint, nullptr, axes, count, trajectory.tick_s,
                          group.limit, table.ratio[g], table.time_s[g]);
    else if (!yaw_rad.empty())
      largest_differences(yaw_rad.data(), nullptr, 1, count, trajectory.tick_s, group.limit, table.ratio[g],
                          table.time_s[g]);
  }
  return table;
}

void fill_certificate(const RatioTable& table, const RowGroups& groups, const Arm& arm,
                      Certificate& certificate) {
  static const char* const total[3] = {"total speed", "total acceleration", "total jerk"};
  static const char* const other[3] = {" rate", " acceleration", " jerk"};
  certificate.limits.clear();
  for (int g = 0; g < groups.count; ++g) {
    const RowGroup& group = groups.group[g];
    const RateLimits& limit = group.limit;
    const std::string whose = group.of == Quantity::kJoint ? arm.joint_name(group.joint) : "orientation";
    const double limits[3] = {limit.rate, limit.acceleration, limit.jerk};
    for (int k = 0; k < 3; ++k)
      if (limits[k] < kUnlimited)
        certificate.limits.push_back({group.of == Quantity::kTotal ? total[k] : whose + other[k],
                                      table.ratio[g][k], table.time_s[g][k]});
  }
  if (table.speed_limit > 0.0) certificate.limits.push_back({"speed ceiling", table.speed_limit, 0.0});
}

}  // namespace firn::motion
