// Where the cells of a curve begin and end, the spline through the knots, and the speed ceiling of each cell.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/path_curve.h"

namespace firn::motion {
namespace {

using Joint = CurveWork::Joint;
using Mark = CurveWork::Mark;

constexpr double kNoWish = std::numeric_limits<double>::max();

void set_marks(const CurveSpec& spec, CurveWork& work) {
  auto& marks = work.marks;
  const CellSizes& sizes = spec.sizes;
  const double total = work.offset.back(), rest = std::min(sizes.rest_mm, 0.05 * total);
  // beside a rest the knots grow geometrically with the distance from it
  const double ratio = sizes.rest_growth, beside = rest * (ratio - 1.0);
  marks.assign(1, {0.0, rest, 1.0});
  marks.push_back({rest, beside, ratio});
  for (std::size_t k = 1; k + 1 < work.joints.size(); ++k) {
    const Joint& joint = work.joints[k];
    const double half = std::max(joint.half_ramp, joint.half_hat);
    if (joint.interpolate) marks.push_back({joint.s, kNoWish, sizes.growth});
    if (half == 0.0) continue;
    const int cells =
        joint.half_hat > joint.half_ramp ? sizes.ramp_cells + sizes.ramp_cells % 2 : sizes.ramp_cells;
    const double wide = 2.0 * half / spec.ramp_mm;  // wide ramps need no finer cells beside them than inside
    const double exit = sizes.ramp_exit_mm * std::max(1.0, 0.5 * wide);
    for (int i = 0; i <= cells; ++i)
      marks.push_back(
          {joint.s + half * (2.0 * i / cells - 1.0), i == 0 || i == cells ? exit : kNoWish, sizes.growth});
  }
  marks.push_back({total - rest, beside, ratio});
  marks.push_back({total, rest, 1.0});
  std::sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) { return a.s < b.s; });
}

/// Drops marks nearer than `least` to the mark before or to an end.
void thin_marks(double least, std::vector<Mark>& marks) {
  const double total = marks.back().s;
  std::size_t kept = 1;
  for (std::size_t i = 1; i + 1 < marks.size(); ++i)
    if (marks[i].s - marks[kept - 1].s >= least && total - marks[i].s >= least) marks[kept++] = marks[i];
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

}  // namespace

void place_knots(const CurveSpec& spec, CurveWork& work, std::vector<double>& knots) {
  set_marks(spec, work);
  const double total = work.offset.back();
  thin_marks(std::min(0.5 * spec.ramp_mm / spec.sizes.ramp_cells, 0.05 * total), work.marks);
  knots.assign(1, 0.0);
  std::size_t k = 0;
  for (std::size_t i = 0; i + 1 < work.marks.size(); ++i) {
    const Mark &a = work.marks[i], &b = work.marks[i + 1];
    const double middle = 0.5 * (a.s + b.s);
    while (k + 1 < work.pieces.size() && middle >= work.offset[k + 1]) ++k;
    const double curvature = std::abs(work.pieces[k].curvature);
    double largest = std::min(spec.sizes.largest_mm, 0.125 * total);
    if (curvature > 0.0) largest = std::min(largest, spec.sizes.arc_angle_rad / curvature);
    fill(a, b, largest, work.sweep, knots);
    knots.push_back(b.s);
  }
}

void set_ceiling(std::span<const Point2> points, std::span<const double> ceiling, CurveWork& work,
                 Curve& curve) {
  const std::size_t cells = curve.cells();
  const double first = ceiling.empty() ? std::numeric_limits<double>::infinity() : ceiling[0];
  curve.ceiling.assign(cells, first);
  if (std::all_of(ceiling.begin(), ceiling.end(), [&](double c) { return c == first; })) return;
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
  // a segment's ceiling holds on every cell that it touches, with room for what the recognition moved
  const double room = 0.5;
  std::size_t from = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    while (from < cells && curve.s[from + 1] < at[i] - room) ++from;
    for (std::size_t c = from; c < cells && curve.s[c] < at[i + 1] + room; ++c)
      curve.ceiling[c] = std::min(curve.ceiling[c], ceiling[i]);
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
