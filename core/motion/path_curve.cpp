#include "core/motion/path_curve.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

using Joint = CurveWork::Joint;

constexpr double kSmallTurn = 1e-9;

double norm(double x, double y) { return std::sqrt(x * x + y * y); }

/// Half length of the ramp of a jump: w / 2, or what the tolerance allows, w = sqrt(24 R tolerance).
double half_ramp(const CurveSpec& spec, double curvature) {
  if (spec.tolerance_mm <= 0.0 || curvature <= 0.0) return 0.5 * spec.ramp_mm;
  return 0.5 * std::max(spec.ramp_mm, std::sqrt(24.0 * spec.tolerance_mm / curvature));
}

/// Pieces between two long lines share one ramp length, the smallest that any of them asks for: the
/// convolution has one width wherever it moves the base.
void set_ramps(const CurveSpec& spec, CurveWork& work) {
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

/// Joint k is where piece k starts; joints 0 and n are the ends.
void set_joints(const CurveSpec& spec, CurveWork& work) {
  const auto& pieces = work.pieces;
  const std::size_t n = pieces.size();
  work.joints.assign(n + 1, {});
  work.offset.resize(n + 1);
  work.offset[0] = 0.0;
  for (std::size_t k = 0; k < n; ++k) work.offset[k + 1] = work.offset[k] + pieces[k].length_mm;
  set_ramps(spec, work);
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
    const double turn = norm(joint.turn_x, joint.turn_y), room = std::min(a.length_mm, b.length_mm);
    if ((a.chord || b.chord) && room < 2.0 * spec.ramp_mm && spec.tolerance_mm <= 0.0) {
      joint = {joint.s};
      joint.interpolate = true;
      continue;
    }
    const double jump = b.curvature - a.curvature;
    joint.jump_x = -jump * b.ty;
    joint.jump_y = jump * b.tx;
    if (jump == 0.0) joint.half_ramp = 0.0;
    if (turn > kSmallTurn) {
      const double allowed =
          spec.tolerance_mm > 0.0 ? std::max(spec.ramp_mm, 6.0 * spec.tolerance_mm / turn) : spec.ramp_mm;
      joint.half_hat = std::min(allowed, 0.5 * room);
    }
  }
}

double ramp_shift(double x, double half) {  // e(x)
  const double y = half - std::abs(x);
  if (y <= 0.0) return 0.0;
  const double e = y * y * y / (12.0 * half);
  return x < 0.0 ? e : -e;
}

double hat_shift(double x, double half) {
  const double y = half - std::abs(x);
  return y > 0.0 ? y * y * y / (6.0 * half * half) : 0.0;
}

/// Whether the shift of the arcs beside a joint must be gone there.
bool pinned(const Joint& joint) { return joint.interpolate; }

/// Position of the ramped curve at s in piece k.
Point2 ramped(const CurveWork& work, std::size_t k, double s) {
  const CurvePiece& piece = work.pieces[k];
  const double local = s - work.offset[k];
  Point2 p = piece.at(local);
  if (piece.curvature != 0.0) {
    const Joint &a = work.joints[k], &b = work.joints[k + 1];
    const double half = std::max(a.half_ramp, b.half_ramp);
    const double left = pinned(a) ? 0.0 : 1.0, right = pinned(b) ? 0.0 : 1.0;
    const double fade = left + (right - left) * (local / piece.length_mm);
    const double shift = fade * piece.curvature * half * half / 6.0;  // kappa w^2 / 24
    const Point2 t = piece.tangent(local);
    p.x_mm -= shift * t.y_mm;
    p.y_mm += shift * t.x_mm;
  }
  const auto add = [&](const Joint& joint) {
    const double x = s - joint.s;
    if (joint.half_ramp > 0.0) {
      const double e = ramp_shift(x, joint.half_ramp);
      p.x_mm += e * joint.jump_x;
      p.y_mm += e * joint.jump_y;
    }
    if (joint.half_hat > 0.0) {
      const double e = hat_shift(x, joint.half_hat);
      p.x_mm += e * joint.turn_x;
      p.y_mm += e * joint.turn_y;
    }
  };
  const auto reaches = [&](const Joint& j) { return std::abs(s - j.s) < std::max(j.half_ramp, j.half_hat); };
  for (std::size_t j = k + 1; j-- > 0 && k - j < 3;)
    if (reaches(work.joints[j])) add(work.joints[j]);
  for (std::size_t j = k + 1; j < work.joints.size() && j - k < 4; ++j)
    if (reaches(work.joints[j])) add(work.joints[j]);
  return p;
}

}  // namespace

void build_curve(std::span<const Point2> points, std::span<const double> ceiling, const CurveSpec& spec,
                 CurveWork& work, Curve& curve) {
  recognise(points, work.pieces);
  set_joints(spec, work);
  place_knots(spec, work, curve.s);
  const std::size_t n = curve.s.size();
  curve.x.resize(n);
  curve.y.resize(n);
  std::size_t k = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (k + 1 < work.pieces.size() && curve.s[i] >= work.offset[k + 1]) ++k;
    const Point2 p = ramped(work, k, curve.s[i]);
    curve.x[i] = p.x_mm;
    curve.y[i] = p.y_mm;
  }
  curve.x[0] = points.front().x_mm;
  curve.y[0] = points.front().y_mm;
  curve.x[n - 1] = points.back().x_mm;
  curve.y[n - 1] = points.back().y_mm;
  const CurvePiece &a = work.pieces.front(), &b = work.pieces.back();
  const Point2 t = b.tangent(b.length_mm);
  spline(curve.s, curve.x, -a.curvature * a.ty, -b.curvature * t.y_mm, curve.xx, work.sweep);
  spline(curve.s, curve.y, a.curvature * a.tx, b.curvature * t.x_mm, curve.yy, work.sweep);
  curve.straight = work.pieces.size() == 1 && a.curvature == 0.0;
  if (curve.straight) {
    std::fill(curve.xx.begin(), curve.xx.end(), 0.0);
    std::fill(curve.yy.begin(), curve.yy.end(), 0.0);
  }
  set_ceiling(points, ceiling, work, curve);
}

Point2 Curve::at(std::size_t i, double at_mm) const {
  const double h = s[i + 1] - s[i], u = at_mm - s[i], v = s[i + 1] - at_mm, over = 1.0 / h;
  // cubic with second derivatives xx at both ends: linear interpolation less the two bows
  const double bow_left = v * (v * v * over - h) / 6.0, bow_right = u * (u * u * over - h) / 6.0;
  return {(v * x[i] + u * x[i + 1]) * over + bow_left * xx[i] + bow_right * xx[i + 1],
          (v * y[i] + u * y[i + 1]) * over + bow_left * yy[i] + bow_right * yy[i + 1]};
}

}  // namespace firn::motion
