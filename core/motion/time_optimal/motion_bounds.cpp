#include "core/motion/time_optimal/motion_bounds.h"

#include <algorithm>
#include <cmath>

#include "core/motion/time_optimal/constants.h"

namespace firn::motion {
namespace {

constexpr double kSixth = 1.0 / 6.0;

using Interval = BoundWork::Interval;

/// Largest |ds/dt| and so on, orders 1 to 5, in an interval of one quintic.
struct PathBounds {
  double v, a, j, k, l;
  bool forward;  ///< v stays positive
};

PathBounds path_bounds(const TimedMotion& motion, const Interval& in, const PathState* state) {
  const double width = (in.to - in.from) / double(in.steps), square = width * width / 8.0;
  const auto [left, right, fifth] = motion.higher(in.piece, in.from, in.to);
  PathBounds b{};
  b.forward = true;
  b.l = std::abs(fifth);
  b.k = std::max(std::abs(left), std::abs(right));
  for (std::size_t i = 0; i < in.steps; ++i) {
    const PathState &p = state[i], &q = state[i + 1];
    const double less_j = std::min(std::abs(p.j), std::abs(q.j)),
                 less_a = std::min(std::abs(p.a), std::abs(q.a));
    const double j = std::max(std::abs(p.j), std::abs(q.j)) + square * b.l;
    // a derivative that keeps its sign makes the quantity monotone: its largest value is at an end
    const bool a_monotone = p.j * q.j >= 0.0 && less_j >= square * b.l;
    const bool v_monotone = p.a * q.a >= 0.0 && (a_monotone || less_a >= square * b.k);
    double bow = v_monotone ? 0.0 : square * j;
    if (a_monotone) bow = std::min(bow, less_a * width);  // a turns beside the end where it is less
    b.j = std::max(b.j, j);
    b.a = std::max(b.a, std::max(std::abs(p.a), std::abs(q.a)) + (a_monotone ? 0.0 : square * b.k));
    b.v = std::max(b.v, std::max(std::abs(p.v), std::abs(q.v)) + bow);
    b.forward = b.forward && std::min(p.v, q.v) >= bow;
  }
  return b;
}

/// Orders 1 to 3 along the path at both ends, of one coordinate or two; with bounds over the interval.
struct CoordinateBounds {
  double d1 = 0.0, d2 = 0.0, d3 = 0.0;

  double third(const PathBounds& b) const { return d3 * b.v * b.v * b.v + 3.0 * d2 * b.v * b.a + d1 * b.j; }
  double second(const PathBounds& b) const { return d2 * b.v * b.v + d1 * b.a; }
  double fourth(const PathBounds& b) const {
    return 6.0 * d3 * b.v * b.v * b.a + d2 * (3.0 * b.a * b.a + 4.0 * b.v * b.j) + d1 * b.k;
  }
  double fifth(const PathBounds& b) const {
    return d3 * (15.0 * b.v * b.a * b.a + 10.0 * b.v * b.v * b.j) +
           d2 * (10.0 * b.a * b.j + 5.0 * b.v * b.k) + d1 * b.l;
  }
};

/// Of coordinates that are cubic in the cell.
CoordinateBounds cubic_bounds(const Curve& c, std::size_t cell, bool yaw, double s0, double s1, double reach,
                              bool forward) {
  const double h = c.s[cell + 1] - c.s[cell], over = 1.0 / h;
  double first[2] = {}, second[2] = {}, third = 0.0;
  const auto add = [&](const std::vector<double>& f, const std::vector<double>& m) {
    const double left = m[cell] * over, right = m[cell + 1] * over;
    for (const int end : {0, 1}) {
      const double u = (end ? s1 : s0) - c.s[cell], w = h - u;
      const double d1 = (f[cell + 1] - f[cell]) * over +
                        kSixth * (left * (h * h - 3.0 * w * w) + right * (3.0 * u * u - h * h));
      const double d2 = left * w + right * u;
      first[end] += d1 * d1;
      second[end] += d2 * d2;
    }
    third += (right - left) * (right - left);
  };
  if (yaw) {
    add(c.yaw, c.yaw2);
  } else {
    add(c.x, c.xx);
    add(c.y, c.yy);
  }
  CoordinateBounds b;
  b.d3 = std::sqrt(third);
  b.d2 = std::sqrt(std::max(second[0], second[1])) + (forward ? 0.0 : b.d3 * reach);
  b.d1 = std::sqrt(std::max(first[0], first[1])) + (forward ? reach * reach / 8.0 * b.d3 : reach * b.d2);
  return b;
}

class Bounder {
 public:
  Bounder(const BoundedMotion& m, MotionSamples& samples, double sharpness, std::vector<Arm::JointJet>& jets)
      : m_(m), work_(samples), sharpness_(sharpness), jets_(jets) {}

  /// Bounds of all groups in an interval. Returns in how many parts each of its steps must be divided, 1 =
  /// not.
  std::size_t bound(const Interval& in, double lower, bool last, RatioTable& table) {
    const std::size_t n = in.sample;
    const PathState *state = work_.batch.state.data() + n, &p = state[0], &q = state[in.steps];
    const double width = (in.to - in.from) / double(in.steps), square = width * width / 8.0;
    const PathBounds path = path_bounds(m_.motion, in, state);
    const double reach = path.v * (in.to - in.from);
    const CoordinateBounds tool = cubic_bounds(m_.curve, in.cell, false, p.s, q.s, reach, path.forward);
    const double sharp = (1.0 + sharpness_) * lower,
                 enough[3] = {sharp, sharp * sharp, sharp * sharp * sharp};
    double here[kMaxGroups][3];
    double rest = 0.0;  // largest share of a ratio that is not seen at the samples, as a factor of time
    // bounds by the chord are sharp where the quantity bends little, those by the chain rule on lines
    const auto raise = [&](int g, const double* seen, double fourth, double fifth,
                           const CoordinateBounds* chain) {
      const RateLimits& limit = m_.groups.group[g].limit;
      double jerk = seen[2] + square * fifth, acceleration = seen[1] + square * fourth,
             rate = seen[0] + square * jerk;
      if (chain) {
        rate = std::min(rate, chain->d1 * path.v);
        acceleration = std::min(acceleration, chain->second(path));
        jerk = std::min(jerk, chain->third(path));
      }
      double* value = here[g];
      value[0] = rate / limit.rate;
      value[1] = acceleration / limit.acceleration;
      value[2] = jerk / limit.jerk;
      if (value[0] <= enough[0] && value[1] <= enough[1] && value[2] <= enough[2]) return;
      const double ratio[3] = {seen[0] / limit.rate, seen[1] / limit.acceleration, seen[2] / limit.jerk};
      rest = std::max(rest, factor_of(value) - std::max(lower, factor_of(ratio)));
    };
    CoordinateBounds yaw;
    if (m_.placement.turning) yaw = cubic_bounds(m_.curve, in.cell, true, p.s, q.s, reach, path.forward);
    double joint[kMaxJoints][3];
    for (int j = 0; j < m_.joints; ++j)
      for (int order = 0; order < 3; ++order) joint[j][order] = largest(work_.joint.of(j, order + 1) + n, in);
    std::array<JointVector, 2> higher{};
    if (m_.joints > 0 && !bound_joints(in, path, tool, yaw, reach, higher)) {
      if (!last) return kUnboundedParts;
      for (auto& order : higher) order.fill(kUnlimited);
    }
    for (int g = 0; g < m_.groups.count; ++g) {
      const RowGroup& group = m_.groups.group[g];
      double seen[3];
      if (group.of == Quantity::kJoint) {
        const std::size_t j = std::size_t(group.joint);
        raise(g, joint[j], higher[0][j], higher[1][j], nullptr);
      } else if (group.of == Quantity::kTotal) {
        for (int order = 0; order < 3; ++order)
          seen[order] = largest_norm(work_.tool.of(kX, order + 1) + n, work_.tool.of(kY, order + 1) + n, in);
        raise(g, seen, tool.fourth(path), tool.fifth(path), &tool);
      } else {
        for (int order = 0; order < 3; ++order) seen[order] = largest(work_.tool.of(kYaw, order + 1) + n, in);
        raise(g, seen, yaw.fourth(path), yaw.fifth(path), &yaw);
      }
    }
    const double speed = path.v / m_.curve.speed_limit[in.cell];
    if (speed > sharp) {
      double fastest = 0.0;
      for (std::size_t i = 0; i <= in.steps; ++i) fastest = std::max(fastest, state[i].v);
      rest = std::max(rest, speed - std::max(lower, fastest / m_.curve.speed_limit[in.cell]));
    }
    const double allowed = sharpness_ * lower;
    if (rest > allowed && !last)
      return std::size_t(std::clamp(std::ceil(std::sqrt(rest / allowed)), 2.0, kMaxIntervalParts));
    table.speed_limit = std::max(table.speed_limit, speed);
    for (int g = 0; g < m_.groups.count; ++g)
      for (int k = 0; k < 3; ++k)
        if (here[g][k] > table.ratio[g][k]) {
          table.ratio[g][k] = here[g][k];
          table.time_s[g][k] = in.from;
        }
    return 1;
  }

 private:
  /// Returns the largest size of a derivative at the samples of an interval.
  static double largest(const double* a, const Interval& in) {
    double most = 0.0;
    for (std::size_t i = 0; i <= in.steps; ++i) most = std::max(most, std::abs(a[i]));
    return most;
  }
  static double largest_norm(const double* a, const double* b, const Interval& in) {
    double most = 0.0;
    for (std::size_t i = 0; i <= in.steps; ++i) most = std::max(most, a[i] * a[i] + b[i] * b[i]);
    return std::sqrt(most);
  }

  bool bound_joints(const Interval& in, const PathBounds& path, const CoordinateBounds& tool,
                    const CoordinateBounds& yaw, double reach, std::array<JointVector, 2>& higher) const {
    const Placement& place = m_.placement;
    const std::size_t n = in.sample;
    FlangeBounds flange;
    flange.width = (in.to - in.from) / double(in.steps);
    flange.x_mm = work_.tool.of(kX, 0)[n];
    flange.y_mm = work_.tool.of(kY, 0)[n];
    flange.radius_mm = tool.d1 * reach;
    flange.position = {tool.fourth(path), tool.fifth(path)};
    if (place.turning) {
      const double offset = std::sqrt(place.tool.x_mm * place.tool.x_mm + place.tool.y_mm * place.tool.y_mm);
      const double y1 = yaw.d1 * path.v, y2 = yaw.second(path), y3 = yaw.third(path), y4 = yaw.fourth(path),
                   y5 = yaw.fifth(path);
      flange.yaw = {y4, y5};
      flange.x_mm = work_.flange.of(kX, 0)[n];
      flange.y_mm = work_.flange.of(kY, 0)[n];
      flange.radius_mm += offset * y1 * (in.to - in.from);
      flange.position[0] += offset * (y4 + rotation_rest_4(y1, y2, y3));
      flange.position[1] += offset * (y5 + rotation_rest_5(y1, y2, y3, y4));
    }
    jets_.resize(in.steps + 1);
    for (std::size_t i = 0; i <= in.steps; ++i)
      for (std::size_t order = 0; order < 3; ++order)
        for (int j = 0; j < m_.joints; ++j)
          jets_[i][order][std::size_t(j)] = work_.joint.of(j, int(order) + 1)[n + i];
    return m_.arm.bound_higher(flange, jets_, higher);
  }

  const BoundedMotion& m_;
  MotionSamples& work_;
  double sharpness_;
  std::vector<Arm::JointJet>& jets_;
};

/// Adds the parts of an interval, unless it is one.
void divide(const Interval& in, std::size_t parts, std::vector<Interval>& out) {
  for (std::size_t k = 0; parts > 1 && k < parts; ++k) {
    const double x0 = double(k) / double(parts), x1 = double(k + 1) / double(parts);
    out.push_back({in.piece, in.cell, in.from + x0 * (in.to - in.from),
                   k + 1 == parts ? in.to : in.from + x1 * (in.to - in.from)});
  }
}

}  // namespace

std::optional<Fault> bound_motion(const BoundedMotion& m, double sharpness, BoundWork& work,
                                  RatioTable& table) {
  double lower = table.time_factor();
  RatioTable bounds;
  // first the intervals between the samples that exist already
  const StateBatch& batch = work.samples.batch;
  const std::size_t each = batch.size() / m.motion.pieces();
  Bounder first(m, work.samples, sharpness, work.jets);
  work.now.clear();
  for (std::size_t n = 0; n < batch.size(); n += each) {
    const Interval whole{n / each, batch.cell[n], batch.time[n], batch.time[n + each - 1], n, each - 1};
    if (first.bound(whole, lower, false, bounds) == 1) continue;
    for (std::size_t i = n; i + 1 < n + each; ++i) {
      const Interval step{whole.piece, whole.cell, batch.time[i], batch.time[i + 1], i, 1};
      divide(step, first.bound(step, lower, false, bounds), work.now);
    }
  }
  for (int round = 1; !work.now.empty(); ++round) {
    MotionSamples& samples = work.divided;
    samples.batch.clear();
    for (Interval& in : work.now) {
      in.sample = samples.batch.size();
      for (const double at : {in.from, in.to}) {
        samples.batch.state.push_back(m.motion.state(in.piece, at));
        samples.batch.cell.push_back(in.cell);
        samples.batch.time.push_back(at);
      }
    }
    if (auto fault = sample_motion(m.curve, samples.batch, m.arm, m.placement, m.joints, false, samples.tool,
                                   samples.joint, samples.flange))
      return fault;
    RatioTable seen;
    add_ratios(m.curve, samples.batch, samples.tool, samples.joint, m.groups, seen);
    lower = std::max(lower, seen.time_factor());
    Bounder bounder(m, samples, sharpness, work.jets);
    work.next.clear();
    for (const Interval& in : work.now)
      divide(in, bounder.bound(in, lower, round == kMaxDivisionRounds, bounds), work.next);
    std::swap(work.now, work.next);
  }
  table = bounds;
  return std::nullopt;
}

}  // namespace firn::motion
