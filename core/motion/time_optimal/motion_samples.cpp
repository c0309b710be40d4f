#include "core/motion/time_optimal/motion_samples.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/exact/exact_math.h"

namespace firn::motion {

double factor_of(const double* ratio) {
  return exact::max_with_cbrt(std::max(ratio[0], std::sqrt(ratio[1])), ratio[2]);
}

double RatioTable::time_factor() const {
  double factor = speed_limit;
  for (const auto& group : ratio) factor = std::max(factor, factor_of(group));
  return factor;
}

void RatioTable::scale_time(double factor) {
  const double over = 1.0 / factor;
  speed_limit *= over;
  for (auto& group : ratio) {
    group[0] *= over;
    group[1] *= over * over;
    group[2] *= over * over * over;
  }
  for (auto& group : time_s)
    for (double& t : group) t *= factor;
}

void RatioTable::merge(const RatioTable& other, double shift) {
  speed_limit = std::max(speed_limit, other.speed_limit);
  for (int g = 0; g < kMaxGroups; ++g)
    for (int k = 0; k < 3; ++k)
      if (other.ratio[g][k] > ratio[g][k]) {
        ratio[g][k] = other.ratio[g][k];
        time_s[g][k] = other.time_s[g][k] + shift;
      }
}

namespace {

/// Two doubles side by side.
using Pair = double __attribute__((vector_size(16)));

/// A coordinate of the curve in time, or two: value and three derivatives, at the cell's ends 0 and 1.
template <class Value>
struct InTime {
  Value at, d1, d2, d3;
  InTime(Value f0, Value f1, Value m0, Value m1, double h, double over, const PathState& q, double u) {
    const double w = h - u;
    const Value left = m0 * over, right = m1 * over;  // r'' = left w + right u
    const Value r1 = (f1 - f0) * over + (left * (h * h - 3.0 * w * w) + right * (3.0 * u * u - h * h)) / 6.0;
    const Value r2 = left * w + right * u, r3 = right - left;
    at = (w * f0 + u * f1) * over + (left * w * (w * w - h * h) + right * u * (u * u - h * h)) / 6.0;
    d1 = r1 * q.v;
    d2 = r2 * q.v * q.v + r1 * q.a;
    d3 = r3 * q.v * q.v * q.v + 3.0 * r2 * q.v * q.a + r1 * q.j;
  }
};

void sample_plane(const Curve& c, const StateBatch& batch, const Placement& place, Jets& out) {
  double* to[2][4];
  for (int order = 0; order < 4; ++order) {
    to[0][order] = out.of(kX, order);
    to[1][order] = out.of(kY, order);
  }
  const double *const s = c.s.data(), *const x = c.x.data(), *const y = c.y.data(), *const xx = c.xx.data(),
                      *const yy = c.yy.data();
  const Pair shift{place.flange_x_mm, place.flange_y_mm};
  for (std::size_t n = 0; n < batch.size(); ++n) {
    const std::size_t i = batch.cell[n];
    const PathState& q = batch.state[n];
    const double h = s[i + 1] - s[i];
    InTime<Pair> p(Pair{x[i], y[i]}, Pair{x[i + 1], y[i + 1]}, Pair{xx[i], yy[i]}, Pair{xx[i + 1], yy[i + 1]},
                   h, 1.0 / h, q, q.s - s[i]);
    p.at += shift;
    for (int k = 0; k < 2; ++k) {
      to[k][0][n] = p.at[k];
      to[k][1][n] = p.d1[k];
      to[k][2][n] = p.d2[k];
      to[k][3][n] = p.d3[k];
    }
  }
}

void sample_yaw(const Curve& c, const StateBatch& batch, Jets& out) {
  for (std::size_t n = 0; n < batch.size(); ++n) {
    const std::size_t i = batch.cell[n];
    const double h = c.s[i + 1] - c.s[i];
    const InTime<double> p(c.yaw[i], c.yaw[i + 1], c.yaw2[i], c.yaw2[i + 1], h, 1.0 / h, batch.state[n],
                           batch.state[n].s - c.s[i]);
    out.of(kYaw, 0)[n] = p.at;
    out.of(kYaw, 1)[n] = p.d1;
    out.of(kYaw, 2)[n] = p.d2;
    out.of(kYaw, 3)[n] = p.d3;
  }
}

}  // namespace

std::optional<Fault> sample_motion(const Curve& curve, const StateBatch& batch, const Arm& arm,
                                   const Placement& place, int joints, bool positions, Jets& tool,
                                   Jets& joint, Jets& flange) {
  const std::size_t count = batch.size();
  tool.resize(kTaskAxes, count);
  for (int order = 0; order < 4; ++order) {
    std::fill_n(tool.of(kZ, order), count, order == 0 ? place.z_mm + place.flange_z_mm : 0.0);
    std::fill_n(tool.of(kYaw, order), count, order == 0 ? place.yaw_rad : 0.0);
  }
  sample_plane(curve, batch, place, tool);
  if (place.turning) sample_yaw(curve, batch, tool);
  joint.resize(std::max(joints, 1), count);
  const Jets& pose = flange_of(place, tool, flange);
  auto fault = positions ? arm.inverse(pose, place.configuration, joint)
                         : arm.inverse_derivatives(pose, place.configuration, joint);
  if (fault && place.turning) fault->at = {tool.of(kX, 0)[fault->index], tool.of(kY, 0)[fault->index]};
  return fault;
}

namespace {

/// The derivative that a group limits; the second coordinate of the total motion, else nullptr.
std::pair<const double*, const double*> limited(const RowGroup& group, int order, const Jets& tool,
                                                const Jets& joint) {
  if (group.of == Quantity::kTotal) return {tool.of(kX, order), tool.of(kY, order)};
  return {group.of == Quantity::kJoint ? joint.of(group.joint, order) : tool.of(kYaw, order), nullptr};
}

/// Largest a^2 + b^2 (b may be null), by four maxima side by side: one waits for the comparison before.
double largest_square(const double* a, const double* b, std::size_t count) {
  double most[4] = {0.0, 0.0, 0.0, 0.0};
  const std::size_t whole = count - count % 4;
  const auto raise = [&](std::size_t n, std::size_t lane) {
    const double square = a[n] * a[n] + (b ? b[n] * b[n] : 0.0);
    most[lane] = square > most[lane] ? square : most[lane];
  };
  for (std::size_t n = 0; n < whole; n += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) raise(n + lane, lane);
  for (std::size_t n = whole; n < count; ++n) raise(n, n - whole);
  return std::max({most[0], most[1], most[2], most[3]});
}

}  // namespace

void add_ratios(const Curve& curve, const StateBatch& batch, const Jets& tool, const Jets& joint,
                const RowGroups& groups, RatioTable& table) {
  const std::size_t count = batch.size();
  for (int g = 0; g < groups.count; ++g) {
    const RowGroup& group = groups.group[g];
    const double limit[3] = {group.limit.rate, group.limit.acceleration, group.limit.jerk};
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = limited(group, k + 1, tool, joint);
      const double most = b ? largest_square(a, b, count) : largest_square(a, nullptr, count);
      const double ratio = std::sqrt(most) / limit[k];
      if (!(ratio > table.ratio[g][k])) continue;
      std::size_t where = 0;
      while (where + 1 < count && !(a[where] * a[where] + (b ? b[where] * b[where] : 0.0) >= most)) ++where;
      table.ratio[g][k] = ratio;
      table.time_s[g][k] = batch.time[where];
    }
  }
  for (std::size_t n = 0; n < count; ++n)
    if (batch.state[n].v > table.speed_limit * curve.speed_limit[batch.cell[n]])
      table.speed_limit = batch.state[n].v / curve.speed_limit[batch.cell[n]];
}

void cell_factors(const Curve& curve, const StateBatch& batch, const Jets& tool, const Jets& joint,
                  const RowGroups& groups, std::vector<double>& factor) {
  factor.assign(curve.cells(), 0.0);
  for (std::size_t n = 0; n < batch.size(); ++n) {
    double& most = factor[batch.cell[n]];
    most = std::max(most, batch.state[n].v / curve.speed_limit[batch.cell[n]]);
    for (int g = 0; g < groups.count; ++g) {
      double size[3];
      for (int k = 0; k < 3; ++k) {
        const auto [a, b] = limited(groups.group[g], k + 1, tool, joint);
        size[k] = b ? std::sqrt(a[n] * a[n] + b[n] * b[n]) : std::abs(a[n]);
      }
      const RateLimits& limit = groups.group[g].limit;
      most = std::max({most, size[0] / limit.rate, std::sqrt(size[1] / limit.acceleration)});
      most = exact::max_with_cbrt(most, size[2] / limit.jerk);
    }
  }
}

void check_states(const Curve& curve, const TimedMotion& motion, int inner, StateBatch& batch) {
  batch.clear();
  std::size_t cell = 0;
  for (std::size_t k = 0; k < motion.pieces(); ++k) {
    const double from = motion.t[k], span = motion.t[k + 1] - from;
    const std::size_t first = batch.size();
    motion.states(k, std::size_t(inner) + 1, batch.state);
    for (int i = 0; i <= inner + 1; ++i) {
      const double s = batch.state[first + std::size_t(i)].s;
      // from the left, the state at a knot belongs to the cell after it; from the right, to the cell before
      if (i == 0)
        while (cell + 1 < curve.cells() && s >= curve.s[cell + 1]) ++cell;
      if (i > 0)
        while (cell + 1 < curve.cells() && s > curve.s[cell + 1] && i <= inner) ++cell;
      batch.cell.push_back(cell);
      batch.time.push_back(i > inner ? motion.t[k + 1] : from + span * i / (inner + 1));
    }
  }
}

}  // namespace firn::motion
