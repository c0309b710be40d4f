// With alpha = theta_1, beta = theta_1 + theta_2, A = l1 exp(i alpha), B = l2 exp(i beta) the flange is p = A
// + B and
//   p'   = i (alpha' A + beta' B)
//   p''  = i (alpha'' A + beta'' B) - alpha'^2 A - beta'^2 B
//   p''' = i (alpha''' A + beta''' B) - 3 (alpha' alpha'' A + beta' beta'' B) - i (alpha'^3 A + beta'^3 B)
// Each order is one linear system i (a A + b B) = R with a = R.B / det, b = -R.A / det, det = l1 l2
// sin(theta_2).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/exact/exact_math.h"
#include "core/grid/avx2.h"
#include "core/motion/kinematics/arm.h"

namespace firn::motion {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kSingularCosine =
    1e-12;  ///< 1 - |cos theta_2| below this: within 2e-10 mm of full stretch or fold

class Scara final : public Arm {
 public:
  explicit Scara(const ScaraConfig& spec)
      : spec_(spec), over_links_(1.0 / (2.0 * spec.link_1_mm * spec.link_2_mm)) {}
  int joints() const override { return 4; }
  bool turns() const override { return true; }
  std::string joint_name(int joint) const override {
    return std::string("J").append(std::to_string(joint + 1));
  }
  std::string joint_unit(int joint) const override { return joint == 2 ? "mm" : "rad"; }
  JointRange range(int joint) const override { return spec_.ranges[std::size_t(joint)]; }

  std::optional<Fault> inverse(const Jets& task, const ArmConfiguration& configuration,
                               Jets& out) const override;
  std::optional<Fault> inverse_derivatives(const Jets& task, const ArmConfiguration& configuration,
                                           Jets& out) const override;
  bool bound_higher(const FlangeBounds& flange, std::span<const JointJet> samples,
                    std::array<JointVector, 2>& bounds) const override;
  void forward(const Jets& joints, Jets& out) const override;
  Jacobian jacobian(const JointVector& q) const override;
  Jacobian jacobian_rate(const JointVector& q, const JointVector& rate) const override;
  std::optional<Fault> choose_configuration(const Jets& task, const ArmConfiguration& preferred,
                                            ArmConfiguration& chosen) const override;

 private:
  double cosine(double x, double y) const {
    return (x * x + y * y - spec_.link_1_mm * spec_.link_1_mm - spec_.link_2_mm * spec_.link_2_mm) /
           (2.0 * spec_.link_1_mm * spec_.link_2_mm);
  }
  std::optional<Fault> reach_fault(const Jets& task) const;
  std::optional<Fault> range_fault(const Jets& task, std::size_t n, int joint, double value) const;
  std::optional<Fault> ranges_fault(const Jets& task, const double* theta_1, const double* theta_2) const;
  std::optional<Fault> wrist_fault(const Jets& task, const double* theta_1, const double* theta_2,
                                   int turns) const;
  void angles(const Jets& task, int elbow, double* theta_1, double* theta_2) const;
  void derivatives(const Jets& task, int elbow, Jets& out) const;

  ScaraConfig spec_;
  double over_links_;
};

Fault at(const Jets& task, std::size_t n, Reason reason, int joint, double value, double bound) {
  Fault fault{reason};
  fault.index = n;
  fault.axis = joint;
  fault.value = value;
  fault.bound = bound;
  fault.at = {task.of(kX, 0)[n], task.of(kY, 0)[n]};
  return fault;
}

std::optional<Fault> Scara::reach_fault(const Jets& task) const {
  const double* x = task.of(kX, 0);
  const double* y = task.of(kY, 0);
  for (std::size_t n = 0; n < task.samples(); ++n) {
    const double c = cosine(x[n], y[n]);
    if (std::abs(c) < 1.0 - kSingularCosine) continue;
    const double reach = std::sqrt(x[n] * x[n] + y[n] * y[n]);
    const double far = spec_.link_1_mm + spec_.link_2_mm, near = std::abs(spec_.link_1_mm - spec_.link_2_mm);
    if (!std::isfinite(c)) return at(task, n, Reason::kNotFinite, -1, reach, far);
    if (std::abs(c) <= 1.0 + kSingularCosine)
      return at(task, n, Reason::kSingular, 1, reach, c > 0 ? far : near);
    return at(task, n, c > 0 ? Reason::kReachFar : Reason::kReachNear, -1, reach, c > 0 ? far : near);
  }
  return std::nullopt;
}

std::optional<Fault> Scara::range_fault(const Jets& task, std::size_t n, int joint, double value) const {
  const JointRange r = range(joint);
  if (value < r.low) return at(task, n, Reason::kJointLow, joint, value, r.low);
  if (value > r.high) return at(task, n, Reason::kJointHigh, joint, value, r.high);
  return std::nullopt;
}

std::optional<Fault> Scara::ranges_fault(const Jets& task, const double* theta_1,
                                         const double* theta_2) const {
  for (std::size_t n = 0; n < task.samples(); ++n) {
    if (auto fault = range_fault(task, n, 0, theta_1[n])) return fault;
    if (auto fault = range_fault(task, n, 1, theta_2[n])) return fault;
    if (auto fault = range_fault(task, n, 2, task.of(kZ, 0)[n])) return fault;
  }
  return std::nullopt;
}

std::optional<Fault> Scara::wrist_fault(const Jets& task, const double* theta_1, const double* theta_2,
                                        int turns) const {
  for (std::size_t n = 0; n < task.samples(); ++n)
    if (auto fault = range_fault(task, n, 3, task.of(kYaw, 0)[n] + turns * kTurn - theta_1[n] - theta_2[n]))
      return fault;
  return std::nullopt;
}

void Scara::angles(const Jets& task, int elbow, double* theta_1, double* theta_2) const {
  const double* x = task.of(kX, 0);
  const double* y = task.of(kY, 0);
  double before = 0.0;
  for (std::size_t n = 0; n < task.samples(); ++n) {
    const double c = cosine(x[n], y[n]), s = elbow * std::sqrt(1.0 - c * c);
    const double d = spec_.link_1_mm + spec_.link_2_mm * c, e = spec_.link_2_mm * s;
    theta_2[n] = exact::atan2(s, c);
    double turn = exact::atan2(y[n] * d - x[n] * e, x[n] * d + y[n] * e);
    if (n > 0)
      turn += kTurn * std::nearbyint((before - turn) / kTurn);  // continuous along the path
    else if (turn < range(0).low && turn + kTurn <= range(0).high)
      turn += kTurn;
    else if (turn > range(0).high && turn - kTurn >= range(0).low)
      turn -= kTurn;
    theta_1[n] = before = turn;
  }
}

/// Joint derivatives from the flange's, element-wise: all instruction sets give the same bytes.
FIRN_CLONES void derivative_loop(double l1, double l2, const Jets& task, int elbow, Jets& out) {
  const double *x = task.of(kX, 0), *x1 = task.of(kX, 1), *x2 = task.of(kX, 2), *x3 = task.of(kX, 3);
  const double *y = task.of(kY, 0), *y1 = task.of(kY, 1), *y2 = task.of(kY, 2), *y3 = task.of(kY, 3);
  double *u1 = out.of(0, 1), *u2 = out.of(0, 2), *u3 = out.of(0, 3);
  double *w1 = out.of(1, 1), *w2 = out.of(1, 2), *w3 = out.of(1, 3);
  const double inverse_links = 1.0 / (2.0 * l1 * l2), square_sum = l1 * l1 + l2 * l2;
  const std::size_t count = task.samples();
#pragma GCC ivdep
  for (std::size_t n = 0; n < count; ++n) {
    const double r2 = x[n] * x[n] + y[n] * y[n];
    const double c = (r2 - square_sum) * inverse_links, s = elbow * std::sqrt(1.0 - c * c);
    const double d = l1 + l2 * c, e = l2 * s, scale = l1 / r2;
    const double ax = (x[n] * d + y[n] * e) * scale, ay = (y[n] * d - x[n] * e) * scale;
    const double bx = x[n] - ax, by = y[n] - ay, over_det = 1.0 / (l1 * e);
    const double a1 = (x1[n] * bx + y1[n] * by) * over_det, b1 = -(x1[n] * ax + y1[n] * ay) * over_det;
    const double a11 = a1 * a1, b11 = b1 * b1;
    double rx = x2[n] + a11 * ax + b11 * bx, ry = y2[n] + a11 * ay + b11 * by;
    const double a2 = (rx * bx + ry * by) * over_det, b2 = -(rx * ax + ry * ay) * over_det;
    const double a12 = 3.0 * a1 * a2, b12 = 3.0 * b1 * b2, a111 = a11 * a1, b111 = b11 * b1;
    rx = x3[n] + a12 * ax + b12 * bx - a111 * ay - b111 * by;
    ry = y3[n] + a12 * ay + b12 * by + a111 * ax + b111 * bx;
    const double a3 = (rx * bx + ry * by) * over_det, b3 = -(rx * ax + ry * ay) * over_det;
    u1[n] = a1;
    u2[n] = a2;
    u3[n] = a3;
    w1[n] = b1 - a1;
    w2[n] = b2 - a2;
    w3[n] = b3 - a3;
  }
}

void Scara::derivatives(const Jets& task, int elbow, Jets& out) const {
  derivative_loop(spec_.link_1_mm, spec_.link_2_mm, task, elbow, out);
}

std::optional<Fault> Scara::inverse(const Jets& task, const ArmConfiguration& configuration,
                                    Jets& out) const {
  if (auto fault = reach_fault(task)) return fault;
  const std::size_t count = task.samples();
  if (out.axes() < 2) {  // ranges of the angles are checked in any case
    Jets both(2, count);
    auto fault = inverse(task, configuration, both);
    if (out.axes() == 1) std::copy_n(both.of(0, 0), 4 * count, out.of(0, 0));
    return fault;
  }
  angles(task, configuration.elbow, out.of(0, 0), out.of(1, 0));
  derivatives(task, configuration.elbow, out);
  if (out.axes() > 2) std::copy_n(task.of(kZ, 0), 4 * count, out.of(2, 0));
  if (out.axes() > 3)
    for (int order = 0; order < 4; ++order)
      for (std::size_t n = 0; n < count; ++n)
        out.of(3, order)[n] = task.of(kYaw, order)[n] + (order == 0 ? configuration.yaw_turns * kTurn : 0.0) -
                              out.of(0, order)[n] - out.of(1, order)[n];
  if (auto fault = ranges_fault(task, out.of(0, 0), out.of(1, 0))) return fault;
  return wrist_fault(task, out.of(0, 0), out.of(1, 0), configuration.yaw_turns);
}

std::optional<Fault> Scara::inverse_derivatives(const Jets& task, const ArmConfiguration& configuration,
                                                Jets& out) const {
  if (out.axes() != 2) return inverse(task, configuration, out);
  if (auto fault = reach_fault(task)) return fault;
  derivatives(task, configuration.elbow, out);
  return std::nullopt;
}

std::optional<Fault> Scara::choose_configuration(const Jets& task, const ArmConfiguration& preferred,
                                                 ArmConfiguration& chosen) const {
  if (auto fault = reach_fault(task)) return fault;
  const std::size_t count = task.samples();
  std::vector<double> theta_1(count), theta_2(count);
  std::optional<Fault> first;
  for (const int elbow : {preferred.elbow < 0 ? -1 : 1, preferred.elbow < 0 ? 1 : -1}) {
    angles(task, elbow, theta_1.data(), theta_2.data());
    std::optional<Fault> fault = ranges_fault(task, theta_1.data(), theta_2.data());
    for (int step = 0; !fault && step < 8; ++step) {  // 0, +1, -1, +2, ... turns from the preferred
      const int turns = preferred.yaw_turns + (step % 2 ? (step + 1) / 2 : -step / 2);
      if (wrist_fault(task, theta_1.data(), theta_2.data(), turns)) continue;
      chosen = {elbow, turns};
      return std::nullopt;
    }
    if (!fault) {
      fault = wrist_fault(task, theta_1.data(), theta_2.data(), preferred.yaw_turns);
      fault->reason = Reason::kDespin;
    }
    if (!first) first = fault;
  }
  return first;
}

/// Orders 1 to 3 inside of the interval follow from their values at the samples and the next order, which
/// follows from them: bounds that contain what they lead to hold, since the derivatives are continuous.
bool Scara::bound_higher(const FlangeBounds& flange, std::span<const JointJet> samples,
                         std::array<JointVector, 2>& bounds) const {
  constexpr int kRounds = 4;
  const double l1 = spec_.link_1_mm, l2 = spec_.link_2_mm, half = 0.5 * flange.width;
  const double reach = std::sqrt(flange.x_mm * flange.x_mm + flange.y_mm * flange.y_mm);
  const double low = std::max(0.0, reach - flange.radius_mm), high = reach + flange.radius_mm;
  const auto cosine_at = [&](double r) { return (r * r - l1 * l1 - l2 * l2) * over_links_; };
  const double cosine_low = cosine_at(low), cosine_high = cosine_at(high);
  const double square = std::min(1.0 - cosine_low * cosine_low, 1.0 - cosine_high * cosine_high);
  if (!(square > 0.0)) return false;
  const double sine = std::sqrt(square), over_a = 1.0 / (l1 * sine), over_b = 1.0 / (l2 * sine);
  double a[3] = {}, b[3] = {};  // of alpha and beta, at the samples
  for (const JointJet& jet : samples)
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = std::max(a[k], std::abs(jet[k][0]));
      b[k] = std::max(b[k], std::abs(jet[k][0] + jet[k][1]));
    }
  double a3 = a[2], b3 = b[2], a4 = 0.0, b4 = 0.0, a1 = 0.0, a2 = 0.0, b1 = 0.0, b2 = 0.0;
  bool holds = false;
  double more = 1.02;
  for (int round = 0; round < kRounds && !holds; ++round, more = 1.0 + 4.0 * (more - 1.0)) {
    const double tried_a = more * a3 + 1e-12, tried_b = more * b3 + 1e-12;
    a2 = a[1] + half * tried_a;
    b2 = b[1] + half * tried_b;
    a1 = a[0] + half * a2;
    b1 = b[0] + half * b2;
    const double r4 =
        flange.position[0] + l1 * rotation_rest_4(a1, a2, tried_a) + l2 * rotation_rest_4(b1, b2, tried_b);
    a4 = r4 * over_a;
    b4 = r4 * over_b;
    a3 = a[2] + half * a4;
    b3 = b[2] + half * b4;
    holds = a3 <= tried_a && b3 <= tried_b;
    if (holds) {
      a3 = tried_a;
      b3 = tried_b;
    }
  }
  if (!holds) return false;
  const double r5 =
      flange.position[1] + l1 * rotation_rest_5(a1, a2, a3, a4) + l2 * rotation_rest_5(b1, b2, b3, b4);
  const double a5 = r5 * over_a, b5 = r5 * over_b;
  bounds[0] = {a4, a4 + b4, 0.0, flange.yaw[0] + b4};
  bounds[1] = {a5, a5 + b5, 0.0, flange.yaw[1] + b5};
  return true;
}

void Scara::forward(const Jets& q, Jets& out) const {
  for (std::size_t n = 0; n < q.samples(); ++n) {
    const double a = q.of(0, 0)[n], b = a + q.of(1, 0)[n];
    const exact::SinCos of_a = exact::sincos(a), of_b = exact::sincos(b);
    const double ax = spec_.link_1_mm * of_a.cos, ay = spec_.link_1_mm * of_a.sin;
    const double bx = spec_.link_2_mm * of_b.cos, by = spec_.link_2_mm * of_b.sin;
    const double a1 = q.of(0, 1)[n], a2 = q.of(0, 2)[n], a3 = q.of(0, 3)[n];
    const double b1 = a1 + q.of(1, 1)[n], b2 = a2 + q.of(1, 2)[n], b3 = a3 + q.of(1, 3)[n];
    // factor of i A, of A in each derivative
    const double ai[4] = {0.0, a1, a2, a3 - a1 * a1 * a1}, ar[4] = {1.0, 0.0, -a1 * a1, -3.0 * a1 * a2};
    const double bi[4] = {0.0, b1, b2, b3 - b1 * b1 * b1}, br[4] = {1.0, 0.0, -b1 * b1, -3.0 * b1 * b2};
    for (int k = 0; k < 4; ++k) {
      out.of(kX, k)[n] = ar[k] * ax - ai[k] * ay + br[k] * bx - bi[k] * by;
      out.of(kY, k)[n] = ar[k] * ay + ai[k] * ax + br[k] * by + bi[k] * bx;
      out.of(kZ, k)[n] = q.of(2, k)[n];
      out.of(kYaw, k)[n] = q.of(0, k)[n] + q.of(1, k)[n] + q.of(3, k)[n];
    }
  }
}

Arm::Jacobian Scara::jacobian(const JointVector& q) const {
  const double a = q[0], b = q[0] + q[1], l1 = spec_.link_1_mm, l2 = spec_.link_2_mm;
  const exact::SinCos of_a = exact::sincos(a), of_b = exact::sincos(b);
  Jacobian j{};
  j[kX] = {-l1 * of_a.sin - l2 * of_b.sin, -l2 * of_b.sin};
  j[kY] = {l1 * of_a.cos + l2 * of_b.cos, l2 * of_b.cos};
  j[kZ] = {0.0, 0.0, 1.0};
  j[kYaw] = {1.0, 1.0, 0.0, 1.0};
  return j;
}

Arm::Jacobian Scara::jacobian_rate(const JointVector& q, const JointVector& rate) const {
  const double a = q[0], b = q[0] + q[1], a1 = rate[0], b1 = rate[0] + rate[1];
  const double l1 = spec_.link_1_mm, l2 = spec_.link_2_mm;
  const exact::SinCos of_a = exact::sincos(a), of_b = exact::sincos(b);
  Jacobian j{};
  j[kX] = {-l1 * a1 * of_a.cos - l2 * b1 * of_b.cos, -l2 * b1 * of_b.cos};
  j[kY] = {-l1 * a1 * of_a.sin - l2 * b1 * of_b.sin, -l2 * b1 * of_b.sin};
  return j;
}

}  // namespace

ScaraConfig cobra600() {
  constexpr double degree = std::numbers::pi / 180.0;
  ScaraConfig spec;
  spec.ranges = {{{-105.0 * degree, 105.0 * degree},
                  {-150.0 * degree, 150.0 * degree},
                  {0.0, 210.0},
                  {-360.0 * degree, 360.0 * degree}}};
  return spec;
}

std::unique_ptr<Arm> make_scara(const ScaraConfig& spec) {
  Fault fault{Reason::kLimitNotPositive};
  fault.what = "link length";
  for (const double link : {spec.link_1_mm, spec.link_2_mm}) {
    fault.value = link;
    if (!(link > 0.0) || !std::isfinite(link)) throw MotionError(fault);
  }
  fault.reason = Reason::kOption;
  fault.what = "range";
  for (std::size_t i = 0; i < spec.ranges.size(); ++i) {
    fault.axis = int(i);
    fault.value = spec.ranges[i].low;
    fault.bound = spec.ranges[i].high;
    if (!(spec.ranges[i].low < spec.ranges[i].high)) throw MotionError(fault);
  }
  return std::make_unique<Scara>(spec);
}

}  // namespace firn::motion
