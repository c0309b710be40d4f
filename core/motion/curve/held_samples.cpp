#include "core/motion/curve/held_samples.h"

#include <algorithm>
#include <cmath>

#include "core/exact/exact_math.h"
#include "core/motion/curve/constants.h"
#include "core/motion/curve/in_order.h"

namespace firn::motion {
namespace {

/// Length of the step from a to b in the direction from `from` to `to`; 0 where these are one point.
double along_mm(Point2 a, Point2 b, Point2 from, Point2 to) {
  const double x = to.x_mm - from.x_mm, y = to.y_mm - from.y_mm, far = std::sqrt(x * x + y * y);
  return far > 0.0 ? ((b.x_mm - a.x_mm) * x + (b.y_mm - a.y_mm) * y) / far : 0.0;
}

/// Returns true if the points beyond a chord's end lie on a curve of which the chord is a sample interval:
/// the angle between the chord and the curve's tangent at its end is curvature x length / 2. Beside a line it
/// is 0, at a corner larger.
/// @param end vertex of the chord @param step +1 at its last vertex, -1 at its first
bool continues(std::span<const Point2> line, const std::vector<double>& length, std::size_t end, int step) {
  const auto next = [step](std::size_t k) { return step > 0 ? k + 1 : k - 1; };
  const Point2 from = line[step > 0 ? end - 1 : end + 1], at = line[end];
  const double own = distance(from, at);
  const auto beyond = [&](std::size_t k, double far) {
    while (k != 0 && k + 1 != line.size() && std::abs(length[k] - length[end]) < far) k = next(k);
    return k;
  };
  const std::size_t middle = beyond(end, 0.5 * kLookAhead * own);
  if (middle == 0 || middle + 1 == line.size()) return false;
  const std::size_t last = beyond(next(middle), kLookAhead * own);
  const double near = distance(at, line[middle]), far = distance(line[middle], line[last]);
  const double bend = turn_at(at, line[middle], line[last]) / (near + far);  // half of the curvature
  const double share = (turn_at(from, at, line[middle]) - bend * near) / (bend * own);
  return share > kMinContinuation && share < kMaxContinuation;
}

}  // namespace

double turn_at(Point2 a, Point2 b, Point2 c) {
  const double ux = b.x_mm - a.x_mm, uy = b.y_mm - a.y_mm, vx = c.x_mm - b.x_mm, vy = c.y_mm - b.y_mm;
  return exact::atan2(ux * vy - uy * vx, ux * vx + uy * vy);
}

void held_lengths(std::span<const Point2> line, double radius, std::vector<double>& length) {
  length.assign(1, 0.0);
  for (std::size_t i = 1; i < line.size(); ++i) {
    std::size_t from = i - 1, to = i;
    for (int more = 0;
         more < kMaxDirectionPoints && distance(line[from], line[to]) < kDirectionRadii * radius; ++more) {
      if (from > 0) --from;
      if (to + 1 < line.size()) ++to;
    }
    const double step = distance(line[i - 1], line[i]);
    const double along = along_mm(line[i - 1], line[i], line[from], line[to]);
    const bool near_end = from == 0 || to + 1 == line.size();
    length.push_back(length.back() + (near_end && along > kForwardCosine * step ? step : along));
  }
  put_in_order(length);
  double own = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    own += kOwnLengthShare * distance(line[i - 1], line[i]);
    length[i] = std::max(0.0, length[i]) + own;
  }
}

bool is_line(std::span<const Point2> line, const std::vector<double>& length, std::size_t chord) {
  const double own = length[chord + 1] - length[chord];
  const auto longer = [&](std::size_t k) { return own >= kLineOverNeighbour * (length[k + 1] - length[k]); };
  const bool first = chord == 0, last = chord + 2 == length.size();
  const bool before = !first && longer(chord - 1), after = !last && longer(chord + 1);
  if (own < kMinLineChord_mm || !(before || after)) return false;
  if (own > kMaxSampleChord_mm) return true;
  // beside one short chord alone it may be the flat part of a curve
  return (first || before) && (last || after) &&
         !(continues(line, length, chord, -1) || continues(line, length, chord + 1, 1));
}

double bulge_mm(std::span<const Point2> line, std::size_t chord, double max_mm) {
  const bool first = chord == 0, last = chord + 2 == line.size();
  const double own = distance(line[chord], line[chord + 1]);
  const auto turn = [&](std::size_t k) {
    return k == 0 || k + 1 >= line.size() ? 0.0 : std::abs(turn_at(line[k - 1], line[k], line[k + 1]));
  };
  const auto bulge = [&](double turned, double other) {  // beside a line that of the arc
    const double curvature = 2.0 * turned / (own + std::min(own, other));
    return turned < kMaxSampledTurn ? kBulgeFactor * 0.125 * curvature * own * own : 0.0;
  };
  const double before = turn(chord), after = turn(chord + 1);
  const double start = first ? 0.0 : bulge(before, distance(line[chord - 1], line[chord])),
               end = last ? 0.0 : bulge(after, distance(line[chord + 1], line[chord + 2]));
  if (first || last) return std::min(max_mm, start + end);
  // an end that does not turn is beside a line where the next vertex does not either, else an inflection
  const bool line_before = before < kStraightEnd * after && turn(chord - 1) < kStraightEnd * after,
             line_after = after < kStraightEnd * before && turn(chord + 2) < kStraightEnd * before;
  return std::min(max_mm, line_before || line_after ? std::min(start, end) : 0.5 * (start + end));
}

}  // namespace firn::motion
