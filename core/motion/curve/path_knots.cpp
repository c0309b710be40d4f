// Bounds of a curve's cells, the spline through the knots, and the speed limit of each cell.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/curve/constants.h"
#include "core/motion/curve/path_curve.h"

namespace firn::motion {
namespace {

using Joint = CurveWork::Joint;
using Mark = CurveWork::Mark;

/// Where the vertices of a dense polygon lie on a smooth curve, every second or fourth is knot enough: vertex
/// k is left out if the cubic through k - 3 d, k - d, k + d, k + 3 d passes it within kSmoothVertex_mm, first
/// for d = 1, then for d = 2.
void thin_vertices(const CurveOptions& spec, CurveWork& work) {
  const double smooth_mm =
      spec.hold_mm > 0.0 ? std::min(kSmoothVertex_mm, spec.exact_mm()) : kSmoothVertex_mm;
  auto& joints = work.joints;
  const auto& pieces = work.pieces;
  const auto dense = [&](std::size_t k) { return k > 0 && k + 1 < joints.size() && joints[k].interpolate; };
  for (std::size_t d = 1; d <= 2; d *= 2) {
    for (std::size_t k = 3 * d; k + 3 * d + 1 < joints.size(); ++k) {
      if ((k / d) % 2 == 0 || k % d != 0 || joints[k].smooth) continue;
      const double left = work.offset[k] - work.offset[k - d], right = work.offset[k + d] - work.offset[k];
      bool good = std::abs(left - right) < kUnevenChords * (left + right);
      for (std::size_t i = k - 3 * d; good && i <= k + 3 * d; ++i) good = dense(i);
      for (const std::size_t i : {k - 3 * d, k + d}) {
        const double chord = work.offset[i + 2 * d] - work.offset[i];
        good = good && std::abs(chord - left - right) < kUnevenChords * (chord + left + right);
      }
      good = good && !pieces[k - 1].given && !pieces[k].given;
      if (d == 2)
        good = good && joints[k - 1].smooth && joints[k + 1].smooth && left + right < kMaxVertexSpacing_mm;
      if (!good || left + right > kMaxVertexSpacing_mm) continue;
      const Point2 &a = pieces[k - 3 * d].start, &b = pieces[k - d].start, &c = pieces[k + d].start,
                   &e = pieces[k + 3 * d].start, &p = pieces[k].start;
      const double dx = p.x_mm - (9.0 * (b.x_mm + c.x_mm) - a.x_mm - e.x_mm) / 16.0;
      const double dy = p.y_mm - (9.0 * (b.y_mm + c.y_mm) - a.y_mm - e.y_mm) / 16.0;
      joints[k].smooth = dx * dx + dy * dy < smooth_mm * smooth_mm;
    }
  }
}

void set_marks(const CurveOptions& spec, CurveWork& work) {
  thin_vertices(spec, work);
  auto& marks = work.marks;
  const CellSizes& sizes = spec.sizes;
  marks.assign(1, {0.0, kAnySpacing_mm, sizes.growth});
  for (std::size_t k = 1; k + 1 < work.joints.size(); ++k) {
    const Joint& joint = work.joints[k];
    const double half = std::max(joint.half_ramp, joint.half_hat);
    if (joint.spacing > 0.0 && !joint.smooth) {
      marks.push_back({joint.s, joint.spacing, sizes.growth});
      continue;
    }
    if (joint.interpolate && !joint.smooth) marks.push_back({joint.s, kAnySpacing_mm, sizes.growth});
    if (half == 0.0) continue;
    const int cells =
        joint.half_hat > joint.half_ramp ? sizes.ramp_cells + sizes.ramp_cells % 2 : sizes.ramp_cells;
    const double wide = 2.0 * half / spec.ramp_mm;  // wide ramps need no finer cells beside them than inside
    const double exit = sizes.ramp_exit_mm * std::max(1.0, 0.5 * wide);
    for (int i = 0; i <= cells; ++i)
      marks.push_back({joint.s + half * (2.0 * i / cells - 1.0), i == 0 || i == cells ? exit : kAnySpacing_mm,
                       sizes.growth});
  }
  for (std::size_t i = 1; i + 1 < work.yaw_s.size(); ++i) {
    const double half = work.yaw_half[i], at = work.yaw_s[i];
    if (half == 0.0) marks.push_back({at, kAnySpacing_mm, sizes.growth});
    for (int k = 0; half > 0.0 && k <= sizes.ramp_cells; ++k)
      marks.push_back({at + half * (2.0 * k / sizes.ramp_cells - 1.0),
                       k == 0 || k == sizes.ramp_cells ? sizes.ramp_exit_mm : kAnySpacing_mm, sizes.growth});
  }
  // a ramp that is wider than the rest of the path ends with it
  std::erase_if(marks, [&](const Mark& mark) { return mark.s < 0.0 || mark.s > work.offset.back(); });
  marks.push_back({work.offset.back(), kAnySpacing_mm, sizes.growth});
  std::sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) { return a.s < b.s; });
}

/// Drops marks nearer than `least` to the mark before or to an end. @param inherits the mark beside a dropped
/// one takes its spacing
void thin_marks(double least, bool inherits, std::vector<Mark>& marks) {
  const double total = marks.back().s;
  std::size_t kept = 1;
  for (std::size_t i = 1; i + 1 < marks.size(); ++i) {
    const bool far_from_end = total - marks[i].s >= least;
    if (marks[i].s - marks[kept - 1].s >= least && far_from_end) {
      marks[kept++] = marks[i];
    } else if (inherits) {
      double& spacing = (far_from_end ? marks[kept - 1] : marks.back()).spacing;
      spacing = std::min(spacing, marks[i].spacing);
    }
  }
  marks[kept++] = marks.back();
  marks.resize(kept);
}

/// Knots strictly between two marks: cells grow from both of them up to `largest`.
void fill(Mark from, Mark to, double largest, std::vector<double>& tail, std::vector<double>& knots) {
  double left = from.s, right = to.s, h_left = std::min(from.spacing, largest),
         h_right = std::min(to.spacing, largest);
  tail.clear();
  while (right - left > 1.5 * std::min(h_left, h_right)) {
    if (h_left <= h_right) {
      knots.push_back(left += h_left);
      h_left = std::min(h_left * from.growth, largest);
    } else {
      tail.push_back(right -= h_right);
      h_right = std::min(h_right * to.growth, largest);
    }
  }
  knots.insert(knots.end(), tail.rbegin(), tail.rend());
}

/// Turn of a cell on a given arc: the spline is off by R angle^4 / 384 between its knots, and some cells are
/// half as long again: a nanometre at most.
double exact_angle(double curvature, const CellSizes& sizes) {
  return std::min(sizes.arc_angle_rad, std::sqrt(std::sqrt(384.0 * kArcCellError_mm * curvature)));
}

}  // namespace

void place_knots(const CurveOptions& spec, CurveWork& work, std::vector<double>& knots) {
  set_marks(spec, work);
  const double total = work.offset.back();
  double shortest = spec.ramp_mm;
  if (spec.held_sagitta_mm > 0.0)
    for (const Joint& joint : work.joints)
      if (const double half = std::max(joint.half_ramp, joint.half_hat); half > 0.0)
        shortest = std::min(shortest, 2.0 * half);
  if (spec.exact())
    for (const Joint& joint : work.joints)
      if (joint.spacing > 0.0) shortest = std::min(shortest, joint.spacing);
  thin_marks(std::min(0.5 * shortest / spec.sizes.ramp_cells, 0.05 * total), spec.exact(), work.marks);
  knots.assign(1, 0.0);
  const auto& joints = work.joints;
  std::size_t k = 0;
  for (std::size_t i = 0; i + 1 < work.marks.size(); ++i) {
    const Mark &a = work.marks[i], &b = work.marks[i + 1];
    const double middle = 0.5 * (a.s + b.s);
    while (k + 1 < work.pieces.size() && middle >= work.offset[k + 1]) ++k;
    const CurvePiece& piece = work.pieces[k];
    // between interpolated vertices the spline alone decides; a knot on the chord would bend it
    const bool vertex =
        (k > 0 && joints[k].interpolate) || (k + 2 < joints.size() && joints[k + 1].interpolate);
    const bool meant = spec.exact() && !piece.given && piece.length_mm >= kDenseWidths * spec.ramp_mm;
    if (!piece.chord || !vertex || meant) {
      const double curvature = std::abs(piece.curvature);
      double largest = std::min(spec.sizes.largest_mm, 0.125 * total);
      if (curvature > 0.0)
        largest =
            std::min(largest, (spec.exact() ? exact_angle(curvature, spec.sizes) : spec.sizes.arc_angle_rad) /
                                  curvature);
      fill(a, b, largest, work.sweep, knots);
    }
    knots.push_back(b.s);
  }
}

void resample(const Curve& coarse, Curve& fine) {
  const std::size_t n = fine.s.size();
  for (auto* v : {&fine.x, &fine.y, &fine.xx, &fine.yy}) v->resize(n);
  std::size_t i = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double s = fine.s[k];
    while (i + 1 < coarse.cells() && s >= coarse.s[i + 1]) ++i;
    const double h = coarse.s[i + 1] - coarse.s[i], u = (s - coarse.s[i]) / h;
    const Point2 p = coarse.at(i, s);
    fine.x[k] = p.x_mm;
    fine.y[k] = p.y_mm;
    fine.xx[k] = (1.0 - u) * coarse.xx[i] + u * coarse.xx[i + 1];
    fine.yy[k] = (1.0 - u) * coarse.yy[i] + u * coarse.yy[i + 1];
  }
  fine.straight = coarse.straight;
  fine.yaw.clear();
  fine.yaw2.clear();
  i = 0;
  for (std::size_t k = 0; k < n && !coarse.yaw.empty(); ++k) {
    const double s = fine.s[k];
    while (i + 1 < coarse.cells() && s >= coarse.s[i + 1]) ++i;
    const double h = coarse.s[i + 1] - coarse.s[i], u = s - coarse.s[i], v = coarse.s[i + 1] - s;
    const double m = coarse.yaw2[i] / h, p = coarse.yaw2[i + 1] / h;
    fine.yaw.push_back((v * coarse.yaw[i] + u * coarse.yaw[i + 1]) / h +
                       (m * v * (v * v - h * h) + p * u * (u * u - h * h)) / 6.0);
    fine.yaw2.push_back(m * v + p * u);
  }
}

void divide(const CellSizes& sizes, CurveWork& work, std::span<const double> excess, double most,
            Curve& curve) {
  std::vector<double>& knots = work.sweep;
  const std::size_t cells = curve.cells();
  const auto bad = [&](std::size_t i) { return excess[i] > most; };
  knots.assign(1, 0.0);
  for (std::size_t i = 0; i < cells; ++i) {
    const double from = curve.s[i], h = curve.s[i + 1] - from;
    if (bad(i) || (i > 0 && bad(i - 1)) || (i + 1 < cells && bad(i + 1))) {
      if (i == 0 || i + 1 == cells) {  // a shorter rest cell and geometric growth up to the old one
        const std::size_t first = knots.size();
        for (double x = 0.3 * h; x < 0.95 * h; x *= sizes.rest_growth)
          knots.push_back(i == 0 ? x : from + h - x);
        if (i > 0) std::reverse(knots.begin() + std::ptrdiff_t(first), knots.end());
      } else {
        knots.push_back(from + h / 3.0);
        knots.push_back(from + h * 2.0 / 3.0);
      }
    }
    knots.push_back(curve.s[i + 1]);
  }
  curve.s = knots;
  resample(work.coarse, curve);
}

void refine(const CellSizes& sizes, CurveWork& work, Curve& fine) {
  const Curve& coarse = work.coarse;
  const double total = coarse.s.back(), ratio = sizes.rest_growth - 1.0, largest = 0.125 * total;
  const std::size_t cells = coarse.cells();
  // a short curve can have more cells than its geometry needs
  const double split = sizes.split * std::clamp(sizes.min_cells / double(cells), 1.0, 4.0);
  // a rest cell is one cell of the spline at most
  const double wanted = std::min(sizes.rest_mm, 0.005 * total);
  const double first = std::min(wanted, coarse.s[1]),
               last = total - std::min(wanted, total - coarse.s[cells - 1]);
  const auto curvature = [&](std::size_t k) {
    return std::sqrt(coarse.xx[k] * coarse.xx[k] + coarse.yy[k] * coarse.yy[k]);
  };
  // beside a rest, cells grow geometrically with the distance from it
  const auto wish = [&](double s) { return ratio * std::max(wanted, std::min(s, total - s)); };
  fine.s.assign({0.0, first});
  for (std::size_t i = 0; i < cells; ++i) {
    const double from = i == 0 ? first : coarse.s[i], to = i + 1 == cells ? last : coarse.s[i + 1];
    if (to <= from) continue;
    const double h = coarse.s[i + 1] - coarse.s[i];
    double parts = split * std::clamp(sizes.tight_mm * std::max(curvature(i), curvature(i + 1)), 1.0, 3.0);
    if (parts * sizes.min_mm > h) parts = std::max(1.0, h / sizes.min_mm);
    fill({from, wish(from), from < 0.5 * total ? sizes.rest_growth : 1.0},
         {to, wish(to), to > 0.5 * total ? sizes.rest_growth : 1.0}, std::min(h / parts, largest), work.sweep,
         fine.s);
    fine.s.push_back(to);
  }
  fine.s.push_back(total);
  resample(coarse, fine);
}

void set_speed_limit(std::span<const Point2> points, std::span<const double> speed_limit, CurveWork& work,
                     Curve& curve) {
  const std::size_t cells = curve.cells();
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double first = speed_limit.empty() ? kNone : speed_limit[0];
  const bool same = std::all_of(speed_limit.begin(), speed_limit.end(), [&](double c) { return c == first; });
  curve.speed_limit.assign(cells, same ? first : kNone);
  if (same) return;
  // position of every input point along the base: within a piece in proportion to the chords
  auto& at = work.point_s;
  at.assign(points.size(), 0.0);
  const auto chord = [&](std::size_t i) {
    const double dx = points[i + 1].x_mm - points[i].x_mm, dy = points[i + 1].y_mm - points[i].y_mm;
    return std::sqrt(dx * dx + dy * dy);
  };
  for (std::size_t i = 0; i + 1 < points.size(); ++i) at[i + 1] = at[i] + chord(i);
  const double scale = work.offset.back() / at.back();
  for (double& s : at) s *= scale;
  // a segment's speed limit holds on every cell that it touches, with room for the displacement by
  // recognition
  std::size_t from = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    while (from < cells && curve.s[from + 1] < at[i] - kSpeedLimitMargin_mm) ++from;
    for (std::size_t c = from; c < cells && curve.s[c] < at[i + 1] + kSpeedLimitMargin_mm; ++c)
      curve.speed_limit[c] = std::min(curve.speed_limit[c], speed_limit[i]);
  }
}

void spline(std::span<const double> s, std::span<const double> f, double m_first, double m_last,
            std::vector<double>& m, std::vector<double>& sweep) {
  const std::size_t n = s.size();
  m.resize(n);
  sweep.resize(n);
  m[0] = m_first;
  m[n - 1] = m_last;
  if (n < 3) return;
  // h_{i-1} m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_i m_{i+1} = 6 (slope_i - slope_{i-1}), Thomas's elimination
  double h = s[1] - s[0], slope = (f[1] - f[0]) / h, above = 0.0, value = m_first;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double next = s[i + 1] - s[i], next_slope = (f[i + 1] - f[i]) / next;
    const double pivot = 1.0 / (2.0 * (h + next) - h * above);
    value = (6.0 * (next_slope - slope) - h * value) * pivot;
    above = next * pivot;
    m[i] = value;
    sweep[i] = above;
    h = next;
    slope = next_slope;
  }
  for (std::size_t i = n - 2; i > 0; --i) m[i] -= sweep[i] * m[i + 1];
}

}  // namespace firn::motion
