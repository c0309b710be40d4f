#include "core/motion/time_optimal/motion_bounds.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

constexpr int kRounds = 8;  ///< of dividing
constexpr double kMostParts = 8.0;
constexpr std::size_t kUntold = 4;  ///< parts of an interval that is too long to tell

using Interval = BoundWork::Interval;

/// Largest |ds/dt| and so on, orders 1 to 5, in an interval of one quintic.
struct PathBounds {
  double v, a, j, k, l;
  bool forward;  ///< v stays positive
};

PathBounds path_bounds(const TimedMotion& motion, const Interval& in, const PathState& p,
                       const PathState& q) {
  const double square = (in.to - in.from) * (in.to - in.from) / 8.0;
  const auto [left, right, fifth] = motion.higher(in.piece, in.from, in.to);
  PathBounds b{};
  b.l = std::abs(fifth);
  b.k = std::max(std::abs(left), std::abs(right));
  b.j = std::max(std::abs(p.j), std::abs(q.j)) + square * b.l;
  // a derivative that keeps its sign makes the quantity monotone: its largest value is at an end
  const bool a_monotone = p.j * q.j >= 0.0 && std::min(std::abs(p.j), std::abs(q.j)) >= square * b.l;
  const double less_a = std::min(std::abs(p.a), std::abs(q.a));
  const bool v_monotone = p.a * q.a >= 0.0 && (a_monotone || less_a >= square * b.k);
  double bow = v_monotone ? 0.0 : square * b.j;
  if (a_monotone) bow = std::min(bow, less_a * (in.to - in.from));  // a turns beside the end where it is less
  b.a = std::max(std::abs(p.a), std::abs(q.a)) + (a_monotone ? 0.0 : square * b.k);
  b.v = std::max(std::abs(p.v), std::abs(q.v)) + bow;
  b.forward = std::min(p.v, q.v) >= bow;
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
                        (left * (h * h - 3.0 * w * w) + right * (3.0 * u * u - h * h)) / 6.0;
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
  Bounder(const BoundedMotion& m, MotionSamples& samples, double most) : m_(m), work_(samples), most_(most) {}

  /// Bounds of all groups in an interval. Returns in how many parts it must be divided, 1 = not.
  std::size_t bound(const Interval& in, double lower, bool last, RatioTable& table) {
    const std::size_t n = in.sample;
    const PathState &p = work_.batch.state[n], &q = work_.batch.state[n + 1];
    const double width = in.to - in.from, square = width * width / 8.0;
    const PathBounds path = path_bounds(m_.motion, in, p, q);
    const double reach = path.v * width;
    const CoordinateBounds tool = cubic_bounds(m_.curve, in.cell, false, p.s, q.s, reach, path.forward);
    const double sharp = (1.0 + most_) * lower, enough[3] = {sharp, sharp * sharp, sharp * sharp * sharp};
    RatioTable here;
    double rest = 0.0;  // largest share of a ratio that is not seen at the ends, as a factor of time
    // bounds by the chord are sharp where the quantity bends little, those by the chain rule on lines
    const auto raise = [&](int g, double d1, double d2, double d3, double fourth, double fifth,
                           const CoordinateBounds* chain) {
      const RateLimits& limit = m_.groups.group[g].limit;
      double jerk = d3 + square * fifth, acceleration = d2 + square * fourth, rate = d1 + square * jerk;
      if (chain) {
        rate = std::min(rate, chain->d1 * path.v);
        acceleration = std::min(acceleration, chain->second(path));
        jerk = std::min(jerk, chain->third(path));
      }
      const double value[3] = {rate / limit.rate, acceleration / limit.acceleration, jerk / limit.jerk};
      const double seen[3] = {d1 / limit.rate, d2 / limit.acceleration, d3 / limit.jerk};
      for (int k = 0; k < 3; ++k) {
        here.ratio[g][k] = value[k];
        here.time_s[g][k] = in.from;
      }
      if (value[0] <= enough[0] && value[1] <= enough[1] && value[2] <= enough[2]) return;
      rest = std::max(rest, factor_of(value) - std::max(lower, factor_of(seen)));
    };
    const auto largest = [&](const Jets& jets, int axis, int second_axis, int order) {
      double most = 0.0;
      for (const std::size_t i : {n, n + 1}) {
        const double a = jets.of(axis, order)[i], b = second_axis < 0 ? 0.0 : jets.of(second_axis, order)[i];
        most = std::max(most, a * a + b * b);
      }
      return std::sqrt(most);
    };
    CoordinateBounds yaw;
    if (m_.placement.turning) yaw = cubic_bounds(m_.curve, in.cell, true, p.s, q.s, reach, path.forward);
    std::array<JointVector, 2> higher{};
    if (m_.joints > 0 && !bound_joints(in, n, path, tool, yaw, reach, higher)) {
      if (!last) return kUntold;
      for (auto& order : higher) order.fill(kUnlimited);
    }
    for (int g = 0; g < m_.groups.count; ++g) {
      const RowGroup& group = m_.groups.group[g];
      if (group.of == Quantity::kJoint) {
        const int j = group.joint;
        raise(g, largest(work_.joint, j, -1, 1), largest(work_.joint, j, -1, 2),
              largest(work_.joint, j, -1, 3), higher[0][std::size_t(j)], higher[1][std::size_t(j)], nullptr);
      } else {
        const bool total = group.of == Quantity::kTotal;
        const int axis = total ? kX : kYaw, second = total ? int(kY) : -1;
        const CoordinateBounds& own = total ? tool : yaw;
        raise(g, largest(work_.tool, axis, second, 1), largest(work_.tool, axis, second, 2),
              largest(work_.tool, axis, second, 3), own.fourth(path), own.fifth(path), &own);
      }
    }
    here.speed_limit = path.v / m_.curve.speed_limit[in.cell];
    rest = std::max(rest,
                    here.speed_limit - std::max(lower, std::max(p.v, q.v) / m_.curve.speed_limit[in.cell]));
    const double allowed = most_ * lower;
    if (rest > allowed && !last)
      return std::size_t(std::clamp(std::ceil(std::sqrt(rest / allowed)), 2.0, kMostParts));
    table.merge(here, 0.0);
    return 1;
  }

 private:
  bool bound_joints(const Interval& in, std::size_t n, const PathBounds& path, const CoordinateBounds& tool,
                    const CoordinateBounds& yaw, double reach, std::array<JointVector, 2>& higher) const {
    const Placement& place = m_.placement;
    FlangeBounds flange;
    flange.width = in.to - in.from;
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
      flange.radius_mm += offset * y1 * flange.width;
      flange.position[0] += offset * (y4 + rotation_rest_4(y1, y2, y3));
      flange.position[1] += offset * (y5 + rotation_rest_5(y1, y2, y3, y4));
    }
    Arm::JointJet left{}, right{};
    for (int order = 0; order < 3; ++order)
      for (int j = 0; j < m_.joints; ++j) {
        left[std::size_t(order)][std::size_t(j)] = work_.joint.of(j, order + 1)[n];
        right[std::size_t(order)][std::size_t(j)] = work_.joint.of(j, order + 1)[n + 1];
      }
    return m_.arm.bound_higher(flange, left, right, higher);
  }

  const BoundedMotion& m_;
  MotionSamples& work_;
  double most_;
};

}  // namespace

std::optional<Fault> bound_motion(const BoundedMotion& m, double sharpness, BoundWork& work,
                                  RatioTable& table) {
  // the samples at the pieces' ends and between them, which the first intervals join
  const std::size_t each = work.samples.batch.size() / m.motion.pieces();
  work.now.clear();
  for (std::size_t n = 0; n + 1 < work.samples.batch.size(); ++n)
    if ((n + 1) % each != 0)
      work.now.push_back({n / each, work.samples.batch.cell[n / each * each], work.samples.batch.time[n],
                          work.samples.batch.time[n + 1], n});
  double lower = 0.0;
  RatioTable bounds;
  for (int round = 0; !work.now.empty(); ++round) {
    MotionSamples& samples = round == 0 ? work.samples : work.divided;
    if (round > 0) {
      samples.batch.clear();
      for (Interval& in : work.now) {
        in.sample = samples.batch.size();
        for (const double at : {in.from, in.to}) {
          samples.batch.state.push_back(m.motion.state(in.piece, at));
          samples.batch.cell.push_back(in.cell);
          samples.batch.time.push_back(at);
        }
      }
      if (auto fault = sample_motion(m.curve, samples.batch, m.arm, m.placement, m.joints, false,
                                     samples.tool, samples.joint, samples.flange))
        return fault;
    }
    RatioTable seen;
    add_ratios(m.curve, samples.batch, samples.tool, samples.joint, m.groups, seen);
    lower = std::max(lower, seen.time_factor());
    Bounder bounder(m, samples, sharpness);
    work.next.clear();
    for (const Interval in : work.now) {
      const std::size_t parts = bounder.bound(in, lower, round == kRounds, bounds);
      for (std::size_t k = 0; parts > 1 && k < parts; ++k) {
        const double x0 = double(k) / double(parts), x1 = double(k + 1) / double(parts);
        work.next.push_back({in.piece, in.cell, in.from + x0 * (in.to - in.from),
                             k + 1 == parts ? in.to : in.from + x1 * (in.to - in.from), 0});
      }
    }
    std::swap(work.now, work.next);
  }
  table = bounds;
  return std::nullopt;
}

}  // namespace firn::motion
