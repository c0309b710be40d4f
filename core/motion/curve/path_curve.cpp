#include "core/motion/curve/path_curve.h"

#include <algorithm>
#include <cmath>

#include "core/exact/exact_math.h"

namespace firn::motion {
namespace {

using Joint = CurveWork::Joint;

double norm(double x, double y) { return std::sqrt(x * x + y * y); }

double sagitta_mm(const CurveOptions& spec) {
  return spec.held_sagitta_mm > 0.0 ? spec.held_sagitta_mm : kSagittaMm;
}

/// Half length of the ramp of a jump: w / 2, or by the tolerance, w = sqrt(24 R tolerance).
double half_ramp(const CurveOptions& spec, double curvature) {
  if (spec.tolerance_mm <= 0.0 || curvature <= 0.0) return 0.5 * spec.ramp_mm;
  const double allowed = std::sqrt(24.0 * spec.tolerance_mm / curvature);
  return 0.5 * (spec.held_sagitta_mm > 0.0 ? allowed : std::max(spec.ramp_mm, allowed));
}

/// Pieces between two long lines share one ramp length, the smallest that any of them requires: the
/// convolution has one width wherever it moves the base.
void set_ramps(const CurveOptions& spec, CurveWork& work) {
  const auto& pieces = work.pieces;
  for (std::size_t from = 0; from < pieces.size();) {
    if (pieces[from].curvature == 0.0) {
      ++from;
      continue;
    }
    std::size_t to = from;
    double half = half_ramp(spec, std::abs(pieces[from].curvature));
    while (to + 1 < pieces.size() && pieces[to + 1].curvature != 0.0)
      half = std::min(half, half_ramp(spec, std::abs(pieces[++to].curvature)));
    // half of the lines on both sides, so that the ramps of two groups never meet
    if (from > 0) half = std::min(half, std::max(0.5 * pieces[from - 1].length_mm, 1e-3));
    if (to + 1 < pieces.size()) half = std::min(half, std::max(0.5 * pieces[to + 1].length_mm, 1e-3));
    for (std::size_t k = from; k <= to + 1; ++k) work.joints[k].half_ramp = half;
    from = to + 1;
  }
}

/// Length of the cells beside a joint of lines and arcs. Beside an arc that is shorter than two of them they
/// are shorter, unless it is a mere turn.
double spacing_mm(const CurveOptions& spec, const CurvePiece& a, const CurvePiece& b, double jump,
                  double turn) {
  const double alone = exact_spacing_mm(jump, turn, spec.ramp_mm, spec.exact_mm());
  double beside_arcs = 1e300;
  for (const CurvePiece* arc : {&a, &b}) {
    if (arc->curvature == 0.0) continue;
    const double turns = std::abs(arc->curvature) * arc->length_mm + turn;
    const double as_turn = 0.5 * exact_spacing_mm(0.0, turns, spec.ramp_mm, spec.exact_mm());
    beside_arcs = std::min(beside_arcs, std::max(std::min(alone, 0.5 * arc->length_mm), as_turn));
  }
  return beside_arcs < 1e300 ? beside_arcs : alone;
}

/// A joint of an exact path. Chords of sampled curves are interpolated; the lines beside them begin with
/// cells as short as these chords.
void set_exact_joint(const CurveOptions& spec, const CurvePiece& a, const CurvePiece& b, Joint& joint) {
  constexpr double kNone = 1e300;  // not sampled
  const auto sampled_mm = [&](const CurvePiece& p) {
    return p.chord && (p.given || p.length_mm < kDenseWidths * spec.ramp_mm) ? p.length_mm : kNone;
  };
  const double turn = norm(joint.turn_x, joint.turn_y), jump = b.curvature - a.curvature;
  const double sampled = std::min(sampled_mm(a), sampled_mm(b));
  if (sampled < kNone && turn * std::min(a.length_mm, b.length_mm) < 8.0 * sagitta_mm(spec)) {
    joint.interpolate = true;
    joint.spacing = sampled;
  } else if (turn > kSmoothTurn || std::abs(jump) > kSmoothJump) {
    joint.spacing = spacing_mm(spec, a, b, jump, turn);
  }
}

/// Cells that grow from one joint on do not yet have the length that another wishes close to it.
void grade_joints(const CurveOptions& spec, std::vector<Joint>& joints) {
  const auto pass = [&](auto from, auto to) {
    const Joint* before = nullptr;
    for (auto joint = from; joint != to; ++joint) {
      if (!(joint->spacing > 0.0)) continue;
      if (before)
        joint->spacing = std::min(
            joint->spacing, before->spacing + (spec.sizes.growth - 1.0) * std::abs(joint->s - before->s));
      before = &*joint;
    }
  };
  pass(joints.begin(), joints.end());
  pass(joints.rbegin(), joints.rend());
}

/// Joint k is where piece k starts; joints 0 and n are the ends.
void set_joints(const CurveOptions& spec, CurveWork& work) {
  const auto& pieces = work.pieces;
  const std::size_t n = pieces.size();
  work.joints.assign(n + 1, {});
  work.offset.resize(n + 1);
  work.offset[0] = 0.0;
  for (std::size_t k = 0; k < n; ++k) work.offset[k + 1] = work.offset[k] + pieces[k].length_mm;
  if (!spec.exact()) set_ramps(spec, work);
  for (std::size_t k = 0; k <= n; ++k) {
    Joint& joint = work.joints[k];
    joint.s = work.offset[k];
    if (k == 0 || k == n) {
      joint.interpolate = true;
      continue;
    }
    const CurvePiece &a = pieces[k - 1], &b = pieces[k];
    const Point2 t = a.tangent(a.length_mm);
    joint.turn_x = b.tx - t.x_mm;
    joint.turn_y = b.ty - t.y_mm;
    if (spec.exact()) {
      set_exact_joint(spec, a, b, joint);
      continue;
    }
    const double turn = norm(joint.turn_x, joint.turn_y), room = std::min(a.length_mm, b.length_mm);
    if ((a.chord || b.chord) && room < kDenseWidths * spec.ramp_mm && turn * room < 8.0 * sagitta_mm(spec)) {
      joint = {joint.s};
      joint.interpolate = true;
      continue;
    }
    const double jump = b.curvature - a.curvature;
    if (jump == 0.0) joint.half_ramp = 0.0;
    if (turn > kSmoothTurn) {
      const double within = 6.0 * spec.tolerance_mm / turn,
                   allowed = spec.held_sagitta_mm > 0.0 ? within : std::max(spec.ramp_mm, within);
      joint.half_hat = std::min(allowed, 0.5 * room);
    }
  }
  if (spec.exact()) grade_joints(spec, work.joints);
}

/// Mean position of the base over [s - half, s + half]: Gauss's rule of four points on the part of each piece
/// in it.
Point2 mean_position(const CurveWork& work, std::size_t k, double s, double half) {
  static constexpr double at[4] = {0.069431844202973714, 0.33000947820757187, 0.66999052179242813,
                                   0.93056815579702629};
  static constexpr double weight[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                       0.17392742256872693};
  const double from = s - half, to = s + half;
  std::size_t first = k;
  while (first > 0 && work.offset[first] > from) --first;
  Point2 sum;
  for (std::size_t p = first; p < work.pieces.size() && work.offset[p] < to; ++p) {
    // the first and last piece go on beyond the ends of the path
    const double low = p == 0 ? from : std::max(from, work.offset[p]);
    const double high = p + 1 == work.pieces.size() ? to : std::min(to, work.offset[p + 1]);
    if (high <= low) continue;
    const double share = (high - low) / (to - from);
    for (int g = 0; g < 4; ++g) {
      const Point2 q = work.pieces[p].at(low + at[g] * (high - low) - work.offset[p]);
      sum.x_mm += share * weight[g] * q.x_mm;
      sum.y_mm += share * weight[g] * q.y_mm;
    }
  }
  return sum;
}

/// A share of how far an arc of the base moves towards its centre under a box of half width `half`: kappa
/// half^2 / 6 to first order.
double box_shift(double share, double curvature, double half) {
  const double angle = half * curvature, r = 1.0 / curvature;
  return share * r * (1.0 - exact::sin(angle) / angle);
}

/// Position of the ramped curve at s in piece k.
Point2 ramped(const CurveWork& work, std::size_t k, double s) {
  const CurvePiece& piece = work.pieces[k];
  const Joint &a = work.joints[k], &b = work.joints[k + 1];
  const double local = s - work.offset[k], rest = work.offset[k + 1] - s;
  Point2 p = piece.at(local);
  double half = 0.0;
  if (piece.curvature != 0.0)
    half = std::max(a.half_ramp, b.half_ramp);
  else if (local < a.half_ramp)
    half = a.half_ramp;
  else if (rest < b.half_ramp)
    half = b.half_ramp;
  if (half > 0.0) {
    // the shift of an arc is gone where the path ends and at interpolated vertices
    const double left = a.interpolate ? 0.0 : 1.0, right = b.interpolate ? 0.0 : 1.0;
    const double fade = piece.curvature == 0.0 ? 1.0 : left + (right - left) * (local / piece.length_mm);
    if (local >= half && rest >= half) {
      const double shift = box_shift(fade, piece.curvature, half);
      const Point2 t = piece.tangent(local);
      p = {p.x_mm - shift * t.y_mm, p.y_mm + shift * t.x_mm};
    } else {
      const Point2 mean = mean_position(work, k, s, half);
      p = {p.x_mm + fade * (mean.x_mm - p.x_mm), p.y_mm + fade * (mean.y_mm - p.y_mm)};
    }
  }
  for (std::size_t j = k < 2 ? 0 : k - 2; j < work.joints.size() && j < k + 4; ++j) {
    const Joint& joint = work.joints[j];
    if (!(joint.half_hat > 0.0)) continue;
    const double e = hat_shift(s - joint.s, joint.half_hat);
    p.x_mm += e * joint.turn_x;
    p.y_mm += e * joint.turn_y;
  }
  return p;
}

}  // namespace

double hat_shift(double x, double half) {
  const double y = half - std::abs(x);
  return y > 0.0 ? y * y * y / (6.0 * half * half) : 0.0;
}

void build_curve(std::span<const Point2> points, const CurveOptions& spec, CurveWork& work) {
  recognise(points, spec.given, sagitta_mm(spec), spec.exact() ? spec.ramp_mm : 0.0, work.pieces);
  set_joints(spec, work);
  Curve& coarse = work.coarse;
  place_yaw(points, spec, work);
  place_knots(spec, work, coarse.s);
  const std::size_t n = coarse.s.size();
  coarse.x.resize(n);
  coarse.y.resize(n);
  std::size_t k = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (k + 1 < work.pieces.size() && coarse.s[i] >= work.offset[k + 1]) ++k;
    const Point2 p = ramped(work, k, coarse.s[i]);
    coarse.x[i] = p.x_mm;
    coarse.y[i] = p.y_mm;
  }
  coarse.x[0] = points.front().x_mm;
  coarse.y[0] = points.front().y_mm;
  coarse.x[n - 1] = points.back().x_mm;
  coarse.y[n - 1] = points.back().y_mm;
  const CurvePiece &a = work.pieces.front(), &b = work.pieces.back();
  const Point2 t = b.tangent(b.length_mm);
  Point2 start{-a.curvature * a.ty, a.curvature * a.tx}, end{-b.curvature * t.y_mm, b.curvature * t.x_mm};
  if (spec.exact()) {  // an arc that is shorter than its cell is a mere turn
    if (coarse.s[1] > work.offset[1]) start = {};
    if (coarse.s[n - 2] < work.offset[work.pieces.size() - 1]) end = {};
  }
  const auto bezier = [](const GivenCurve& g) { return g.kind == GivenCurve::Kind::kBezier; };
  if (a.given && bezier(spec.given.front())) start = spec.given.front().bend(spec.given.front().from);
  if (b.given && bezier(spec.given.back())) end = spec.given.back().bend(spec.given.back().to);
  spline(coarse.s, coarse.x, start.x_mm, end.x_mm, coarse.xx, work.sweep);
  spline(coarse.s, coarse.y, start.y_mm, end.y_mm, coarse.yy, work.sweep);
  sample_yaw(spec, work, coarse);
  coarse.straight = work.pieces.size() == 1 && a.curvature == 0.0;
  if (coarse.straight) {
    std::fill(coarse.xx.begin(), coarse.xx.end(), 0.0);
    std::fill(coarse.yy.begin(), coarse.yy.end(), 0.0);
  }
}

Point2 Curve::at(std::size_t i, double at_mm) const {
  const double h = s[i + 1] - s[i], u = at_mm - s[i], v = s[i + 1] - at_mm, over = 1.0 / h;
  // cubic with second derivatives xx at both ends: linear interpolation less the two bows
  const double bow_left = v * (v * v * over - h) / 6.0, bow_right = u * (u * u * over - h) / 6.0;
  return {(v * x[i] + u * x[i + 1]) * over + bow_left * xx[i] + bow_right * xx[i + 1],
          (v * y[i] + u * y[i + 1]) * over + bow_left * yy[i] + bow_right * yy[i + 1]};
}

void place_yaw(std::span<const Point2> points, const CurveOptions& spec, CurveWork& work) {
  work.yaw_s.clear();
  work.yaw_half.clear();
  if (spec.yaw.empty()) return;
  auto& s = work.yaw_s;
  s.assign(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double dx = points[i].x_mm - points[i - 1].x_mm, dy = points[i].y_mm - points[i - 1].y_mm;
    s[i] = s[i - 1] + std::sqrt(dx * dx + dy * dy);
  }
  const double scale = work.offset.back() / s.back();
  for (double& at : s) at *= scale;
  work.yaw_half.assign(points.size(), 0.0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double room = std::min(s[i] - s[i - 1], s[i + 1] - s[i]);
    const double before = (spec.yaw[i] - spec.yaw[i - 1]) / (s[i] - s[i - 1]),
                 after = (spec.yaw[i + 1] - spec.yaw[i]) / (s[i + 1] - s[i]);
    if (before != after && room >= 2.0 * spec.ramp_mm) work.yaw_half[i] = std::min(spec.ramp_mm, 0.5 * room);
  }
}

void sample_yaw(const CurveOptions& spec, CurveWork& work, Curve& curve) {
  curve.yaw.clear();
  curve.yaw2.clear();
  if (spec.yaw.empty()) return;
  const auto& s = work.yaw_s;
  const auto slope = [&](std::size_t i) { return (spec.yaw[i + 1] - spec.yaw[i]) / (s[i + 1] - s[i]); };
  std::size_t i = 0;
  for (const double at : curve.s) {
    while (i + 2 < s.size() && at >= s[i + 1]) ++i;
    double yaw = spec.yaw[i] + slope(i) * (at - s[i]);
    for (std::size_t k = std::max<std::size_t>(i, 1); k <= i + 1 && k + 1 < s.size(); ++k)
      if (work.yaw_half[k] > 0.0) yaw += (slope(k) - slope(k - 1)) * hat_shift(at - s[k], work.yaw_half[k]);
    curve.yaw.push_back(yaw);
  }
  spline(curve.s, curve.yaw, 0.0, 0.0, curve.yaw2, work.sweep);
}

}  // namespace firn::motion
