#include "core/motion/certified/shape_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/motion/curve/frechet.h"

namespace firn::motion {
namespace {

/// Points of a path up to which the buffers of its fit are kept for the next path, 1 kB each.
constexpr std::size_t kMaxKeptTube = 20000;

/// Returns true if `a` keeps to the path where `b` does not, or if both do or neither does and it is faster.
bool better(const StopSegment& a, bool a_keeps, const StopSegment& b, bool b_keeps) {
  return a_keeps != b_keeps ? a_keeps : a.duration_s() < b.duration_s();
}

/// Returns true if rounding bends a curve through the points: its third derivative is some 8 noise / chord^3.
bool bent_by_rounding(const std::vector<double>& chords, double noise_mm) {
  const double chord = 0.5 * std::accumulate(chords.begin(), chords.end(), 0.0) / double(chords.size());
  return kRoundingBend * noise_mm > kMinRoundingBend * chord * chord * chord;
}

}  // namespace

double ShapeChoice::straight_time_s(std::size_t from, std::size_t to, double scale) {
  const RateLimits& limit = task_.limits.position;
  double length = 0.0, cruise_s = 0.0, fastest = 0.0;
  for (std::size_t i = from; i < to; ++i) {
    const double dx = path_.points[i + 1].x_mm - path_.points[i].x_mm,
                 dy = path_.points[i + 1].y_mm - path_.points[i].y_mm;
    const double step = scale * std::sqrt(dx * dx + dy * dy),
                 speed_limit = std::min(path_.speed_limit_mm_s[i], limit.rate);
    length += step;
    cruise_s += step / speed_limit;
    fastest = std::max(fastest, speed_limit);
  }
  straight_motion(length, fastest, limit.acceleration, limit.jerk, work_.straight);
  return std::max(cruise_s, work_.straight.duration_s() + cruise_s - length / fastest);
}

/// Returns true if the points are samples of a free-form curve: few of them lie on lines and arcs that are
/// meant. Only a spline fitted inside the tolerance or the points' rounding is good there.
bool ShapeChoice::free_form(const PathPart& part) {
  const PlanOptions& options = task_.options;
  const double noise_mm = options.point_noise_mm;
  const bool held = part.points_alone && hold_mm(options) > 0.0;  // samples of given curves are not rounded
  const std::size_t chord_count = part.points.size() - 1;
  if (!path_.yaw_rad.empty() || chord_count < (held ? kMinHeldChords : kMinFreeChords)) return false;
  if (!(options.tolerance_mm > 0.0)) {
    if (noise_mm == 0.0 && !held) return false;
    std::vector<double> chords;
    for (std::size_t i = 0; i < chord_count; ++i)
      chords.push_back(distance(part.points[i], part.points[i + 1]));
    if (!held) return bent_by_rounding(chords, noise_mm);
    const auto middle = chords.begin() + std::ptrdiff_t(chords.size() / 2);
    std::nth_element(chords.begin(), middle, chords.end());
    return *middle <= kMaxHeldChord_mm;
  }
  std::vector<CurvePiece>& pieces = work_.curve.curve.pieces;
  recognise(part.points, part.given, kSagittaMm, 0.0, pieces);
  std::size_t meant = 0;
  for (const CurvePiece& piece : pieces)
    if (!piece.chord || piece.length_mm > kDenseWidths * options.curvature_ramp_mm)
      meant += piece.last - piece.first;
  return double(meant) < kRecognisedShare * double(chord_count);
}

void ShapeChoice::plan_still(const PathPart& part, Shape shape, const MaxDuration& max, StopSegment& out) {
  out.first = part.first;
  out.last = part.last;
  const CellSizes sizes = SpeedPlanner::cell_sizes(part, task_);
  const bool built = work_.curve.build(part, shape, sizes, task_.options, out);
  if (part.points.size() > kMaxKeptTube) work_.curve.tube = {};
  if (built)
    work_.speed.plan(part, sizes, max, task_, work_.curve.curve, out);
  else
    give_up(out);
}

void ShapeChoice::plan_shape(const PathPart& part, Shape shape, const MaxDuration& max, StopSegment& out) {
  const PlanOptions& options = task_.options;
  const bool worth_it =
      moves_within_tolerance(options) || (options.slack == 0.0 && options.method == Method::kOptimal);
  if (shape != Shape::kFitted || !worth_it || !path_.yaw_rad.empty())
    return plan_still(part, shape, max, out);
  out.first = part.first;
  out.last = part.last;
  plan_by_descent(part, task_, work_.curve, work_.speed, work_.descent, out);
}

void ShapeChoice::plan_likely(std::size_t from, std::size_t to, StopSegment& out) {
  const PathPart part = part_of(from, to);
  plan_still(part, free_form(part) ? Shape::kFitted : Shape::kRamped, {.planned_s = 0.0}, out);
}

void ShapeChoice::plan_chord(std::size_t from, std::size_t to, StopSegment& out) {
  const PathPart part = part_of(from, to);
  const Point2 ends[2] = {part.points.front(), part.points.back()};
  const double limit = *std::min_element(part.speed_limit.begin(), part.speed_limit.end());
  plan_still({.points = ends, .speed_limit = {&limit, 1}, .first = from, .last = to}, Shape::kRamped, {},
             out);
  if (!std::isfinite(out.duration_s())) return;
  std::vector<Point2> samples;
  const GivenReference path = sample_given(part.points, part.given, samples);
  const double hold = hold_mm(task_.options);
  out.deviation_mm = frechet_bound(out.curve, path.points) + path.sagitta_mm;
  out.points_off_mm = hold > 0.0 ? farthest_point_mm(out.curve, part.points, hold) : 0.0;
}

ShapeChoice::Case ShapeChoice::case_of(bool free_form) const {
  if (task_.options.tolerance_mm > 0.0 && path_.yaw_rad.empty()) return Case::kWithinTolerance;
  return free_form && hold_mm(task_.options) > 0.0 ? Case::kHeldSamples : Case::kOneShape;
}

void ShapeChoice::plan(std::size_t from, std::size_t to, StopSegment& out, double max_s) {
  const PathPart part = part_of(from, to);
  const bool free = free_form(part);
  switch (case_of(free)) {
    case Case::kOneShape:
      plan_shape(part, free ? Shape::kFitted : Shape::kRamped, {.bound_s = max_s}, out);
      return work_.speed.prove(task_, out);
    case Case::kHeldSamples:
      plan_held(part, max_s, out);
      return work_.speed.prove(task_, out);
    case Case::kWithinTolerance:
      return plan_within_tolerance(part, free, out);
  }
}

/// Plans the spline inside the tube about the samples and the curve through them; keeps the one that holds
/// them, then the faster one.
void ShapeChoice::plan_held(const PathPart& part, double max_s, StopSegment& out) {
  StopSegment& other = work_.other;
  plan_shape(part, Shape::kFitted, {.bound_s = max_s}, out);
  const bool fits = holds(out, task_.options);
  plan_shape(part, Shape::kRamped, {.bound_s = fits ? std::min(max_s, out.duration_s()) : max_s}, other);
  if (better(other, holds(other, task_.options), out, fits)) std::swap(other, out);
}

/// The likeliest shape first; the others only where it is not near the fastest that can be: inside the
/// tolerance as fast as on a straight line, or with slack where there are no samples that a fit would smooth.
void ShapeChoice::plan_within_tolerance(const PathPart& part, bool free_form, StopSegment& out) {
  const PlanOptions& options = task_.options;
  plan_shape(part, free_form ? Shape::kFitted : Shape::kRamped, {}, out);
  if (inside_tolerance(out, options)) {
    const double straight_s = straight_time_s(part.first, part.last, 1.0);
    if (out.duration_s() <= (kAcceptedOverStraight + options.slack) * straight_s) return;
    const double dense_mm = kDenseWidths * options.curvature_ramp_mm;
    if (options.slack > 0.0 && (free_form || !has_dense_run(work_.curve.curve.pieces, dense_mm))) return;
  }
  for (const Shape shape : {free_form ? Shape::kRamped : Shape::kFitted, Shape::kPlain}) {
    StopSegment& other = work_.other;
    const double max_s = inside_tolerance(out, options) ? out.duration_s() : kNoMaxDuration_s;
    plan_shape(part, shape, {max_s, max_s}, other);
    if (better(other, inside_tolerance(other, options), out, inside_tolerance(out, options)))
      std::swap(other, out);
  }
}

}  // namespace firn::motion
