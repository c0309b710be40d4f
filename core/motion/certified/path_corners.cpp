#include "core/motion/certified/path_corners.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/exact/exact_math.h"
#include "core/motion/certified/deviation_limits.h"
#include "core/motion/curve/given_curves.h"
#include "core/motion/curve/polyline_thinning.h"

namespace firn::motion {
namespace {

/// Samples of an arc turn, but an arc has no corner; at the ends of given curves their tangents decide, and
/// thinning may have moved a corner away from there.
void set_given_corners(const CleanPath& path, double cos_split, std::vector<std::size_t>& kept,
                       std::vector<std::size_t>& corners) {
  const auto insert = [](std::vector<std::size_t>& to, std::size_t i) {
    const auto at = std::lower_bound(to.begin(), to.end(), i);
    if (at == to.end() || *at != i) to.insert(at, i);
  };
  for (const GivenCurve& g : path.given) {
    if (g.kind == GivenCurve::Kind::kArc)
      std::erase_if(corners, [&](std::size_t c) { return g.first < c && c < g.last; });
    for (const std::size_t i : {g.first, g.last}) {
      if (i == 0 || i + 1 == path.points.size()) continue;
      const Point2 a = direction_at(path.points, path.given, i, false).tangent,
                   b = direction_at(path.points, path.given, i, true).tangent;
      std::erase(corners, i);
      if (a.x_mm * b.x_mm + a.y_mm * b.y_mm >= cos_split) continue;
      insert(corners, i);
      insert(kept, i);
    }
  }
}

/// True where the path turns at points[i] between places at least `reach_mm` before and behind it.
bool turns(std::span<const Point2> points, std::size_t i, double reach_mm, double cos_split) {
  std::size_t from = i - 1, to = i + 1;
  while (from > 0 && distance(points[from], points[i]) < reach_mm) --from;
  while (to + 1 < points.size() && distance(points[i], points[to]) < reach_mm) ++to;
  const Point2 &a = points[from], &b = points[i], &c = points[to];
  return (b.x_mm - a.x_mm) * (c.x_mm - b.x_mm) + (b.y_mm - a.y_mm) * (c.y_mm - b.y_mm) <
         cos_split * distance(a, b) * distance(b, c);
}

/// True where the chords at a vertex are samples of an arc: they turn as those beside them do, and their arc
/// passes no farther from them than a curve may pass from the polygon of its samples.
bool bends(std::span<const Point2> points, std::size_t i) {
  if (i < 2 || i + 2 >= points.size()) return false;
  const auto half_turn = [&](std::size_t k) {  // its tangent
    const double ux = points[k].x_mm - points[k - 1].x_mm, uy = points[k].y_mm - points[k - 1].y_mm;
    const double vx = points[k + 1].x_mm - points[k].x_mm, vy = points[k + 1].y_mm - points[k].y_mm;
    return (ux * vy - uy * vx) / (std::sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy)) + ux * vx + uy * vy);
  };
  const double own = half_turn(i), side = own > 0.0 ? 1.0 : -1.0,
               min_turn = kMinNeighbourTurn * std::abs(own);
  const double chord = std::max(distance(points[i - 1], points[i]), distance(points[i], points[i + 1]));
  return std::abs(own) < kMaxHalfTurnTangent && 0.25 * chord * std::abs(own) <= kSagittaMm &&
         side * half_turn(i - 1) >= min_turn && side * half_turn(i + 1) >= min_turn;
}

/// Rounded samples about a corner: the one farthest out, between two others and within reach of the corner.
/// A curve that ended at another would have to turn back for it.
std::size_t tip(std::span<const Point2> points, std::size_t before, std::size_t corner, std::size_t after,
                double reach_mm) {
  const Point2 &a = points[before], &b = points[corner], &c = points[after];
  const double in = distance(a, b), out = distance(b, c);
  const double x = (b.x_mm - a.x_mm) / in - (c.x_mm - b.x_mm) / out,
               y = (b.y_mm - a.y_mm) / in - (c.y_mm - b.y_mm) / out;
  const auto far_out = [&](std::size_t i) { return x * points[i].x_mm + y * points[i].y_mm; };
  std::size_t found = corner;
  for (std::size_t i = corner; i-- > before + 1 && distance(points[i], b) < reach_mm;)
    if (far_out(i) > far_out(found)) found = i;
  for (std::size_t i = corner + 1; i < after && distance(points[i], b) < reach_mm; ++i)
    if (far_out(i) > far_out(found)) found = i;
  return found;
}

}  // namespace

void find_corners(const CleanPath& path, const PlanOptions& options, std::vector<std::size_t>& kept,
                  std::vector<std::size_t>& corners) {
  const double within =
      std::max(kThinningNoises * options.point_noise_mm, kCornerThinningShare * options.tolerance_mm);
  const double cos_split = exact::cos(options.split_angle_rad);
  const bool held = hold_mm(options) > 0.0;
  if (within == 0.0) {
    kept.resize(path.points.size());
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    split_points(path.points, cos_split, corners);
    if (held) std::erase_if(corners, [&](std::size_t c) { return bends(path.points, c); });
  } else {
    thin_polyline(path.points, within, kept);
    std::vector<Point2> thinned;
    for (const std::size_t i : kept) thinned.push_back(path.points[i]);
    split_points(thinned, cos_split, corners);
    const double reach = kCornerReachNoises * options.point_noise_mm;
    std::erase_if(corners, [&](std::size_t c) {
      if (c == 0 || c + 1 == thinned.size()) return false;
      return (held && bends(thinned, c)) ||
             (!turns(thinned, c, 0.0, 0.0) && !turns(path.points, kept[c], reach, cos_split));
    });
    for (std::size_t& corner : corners) {
      if (options.tolerance_mm == 0.0 && corner > 0 && corner + 1 < kept.size())
        kept[corner] = tip(path.points, kept[corner - 1], kept[corner], kept[corner + 1], reach);
      corner = kept[corner];
    }
  }
  set_given_corners(path, cos_split, kept, corners);
}

}  // namespace firn::motion
