// Stops of the motion, and corners that are rolled within the tolerance; of each segment the shape that is
// fastest.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/motion/certified/certified.h"
#include "core/motion/certified/path_corners.h"
#include "core/motion/curve/frechet.h"
#include "core/motion/curve/polyline_thinning.h"

namespace firn::motion {
namespace {

constexpr double kRollableCosine = -0.9;  ///< sharper corners (154 degrees and more) are never rolled
constexpr double kTrialMm = 15.0;  ///< most of the path to either side of a corner on which rolling is tried,
constexpr double kLeastTrialMm = 2.0,
                 kTrialStops = 3.0;  ///< which is so many times the cost of stopping there, and this
/// A curve within the tolerance is shorter than the polygon by less than this share, where time is saved by
/// it.
constexpr double kShorter = 0.98;
constexpr double kFastEnough =
    1.002;  ///< of the minimum time on a line within all limits: no other shape is tried

constexpr double kLikely =
    0.998;  ///< of the fastest shape so far: who is no faster before it is checked will not win
constexpr double kNever_s = 1e300;
constexpr std::size_t kLeastFreeChords = 6, kLeastHeldChords = 3;  ///< of a free-form curve
constexpr double kMostHeldChord_mm = 5.0;  ///< median: farther points are no samples of a curve
constexpr double kLeastBend = 1e-3;        ///< 1/mm^2, of the speed limit's jerk at 125 mm/s a half

std::span<const Point2> part(const CleanPath& path, std::size_t from, std::size_t to) {
  return std::span<const Point2>(path.points).subspan(from, to - from + 1);
}

std::span<const double> speed_limits(const CleanPath& path, std::size_t from, std::size_t to) {
  return std::span<const double>(path.speed_limit_mm_s).subspan(from, to - from);
}

std::span<const double> yaws(const CleanPath& path, std::size_t from, std::size_t to) {
  const std::span<const double> all(path.yaw_rad);
  return all.empty() ? all : all.subspan(from, to - from + 1);
}

/// The curves given between two points; valid until the next call.
std::span<const GivenCurve> given_curves(const CleanPath& path, std::size_t from, std::size_t to,
                                         CertifiedWork& work) {
  given_between(path.given, from, to, work.given);
  return work.given;
}

/// Time between two rests if the path were straight, `scale` times as long.
double straight_time_s(const CleanPath& path, std::size_t from, std::size_t to, double scale,
                       const CertifiedTask& task, CertifiedWork& work) {
  const RateLimits& limit = task.limits.position;
  double length = 0.0, cruise_s = 0.0, fastest = 0.0;
  for (std::size_t i = from; i < to; ++i) {
    const double dx = path.points[i + 1].x_mm - path.points[i].x_mm,
                 dy = path.points[i + 1].y_mm - path.points[i].y_mm;
    const double step = scale * std::sqrt(dx * dx + dy * dy),
                 speed_limit = std::min(path.speed_limit_mm_s[i], limit.rate);
    length += step;
    cruise_s += step / speed_limit;
    fastest = std::max(fastest, speed_limit);
  }
  straight_motion(length, fastest, limit.acceleration, limit.jerk, work.straight);
  return std::max(cruise_s, work.straight.duration_s() + cruise_s - length / fastest);
}

/// True if the points between two rests are samples of a free-form curve: few of them lie on lines and arcs
/// that are meant. Only a spline fitted inside the tolerance or the points' rounding is good there.
bool free_form(const CleanPath& path, std::size_t from, std::size_t to, const CertifiedTask& task,
               CertifiedWork& work) {
  constexpr double kMeantShare = 0.5;
  const PlanOptions& options = task.options;
  const double noise = options.point_noise_mm;
  const bool held = path.given.empty() && hold_mm(options) > 0.0;  // samples of given curves are not rounded
  if (options.curve_rule == CurveRule::kRamped || !path.yaw_rad.empty() ||
      to - from < (held ? kLeastHeldChords : kLeastFreeChords))
    return false;
  if (!(options.tolerance_mm > 0.0)) {
    if (noise == 0.0 && !held) return false;
    std::vector<double> chords;
    for (std::size_t i = from; i < to; ++i) chords.push_back(distance(path.points[i], path.points[i + 1]));
    if (held) {
      const auto middle = chords.begin() + std::ptrdiff_t(chords.size() / 2);
      std::nth_element(chords.begin(), middle, chords.end());
      return *middle <= kMostHeldChord_mm;
    }
    // does the rounding bend the curve through the points? its third derivative is some 8 noise / chord^3
    const double chord = 0.5 * std::accumulate(chords.begin(), chords.end(), 0.0) / double(chords.size());
    return 8.0 * noise > kLeastBend * chord * chord * chord;
  }
  recognise(part(path, from, to), given_curves(path, from, to, work), kSagittaMm, true, 0.0,
            work.curve.pieces);
  std::size_t meant = 0;
  for (const CurvePiece& piece : work.curve.pieces)
    if (!piece.chord || piece.length_mm > kDenseWidths * options.curvature_ramp_mm)
      meant += piece.last - piece.first;
  return double(meant) < kMeantShare * double(to - from);
}

void plan_part(const CleanPath& path, std::size_t from, std::size_t to, Shape shape, double most_s,
               const CertifiedTask& task, CertifiedWork& work, StopSegment& segment) {
  segment.first = from;
  segment.last = to;
  plan_segment(part(path, from, to), speed_limits(path, from, to), yaws(path, from, to),
               given_curves(path, from, to, work), shape, most_s, task, work, segment);
}

/// CurveRule::kRamped.
void plan_as_recorded(const CleanPath& path, std::size_t from, std::size_t to, const CertifiedTask& task,
                      CertifiedWork& work, StopSegment& out) {
  const auto plan = [&](Shape shape, double most_s, StopSegment& segment) {
    plan_part(path, from, to, shape, most_s, task, work, segment);
  };
  plan(Shape::kRamped, kNever_s, out);
  const PlanOptions& options = task.options;
  if (!(options.tolerance_mm > 0.0)) return;
  if (out.deviation_mm <= options.tolerance_mm &&
      out.duration_s() <= (kFastEnough + options.slack) * straight_time_s(path, from, to, 1.0, task, work))
    return;
  const bool dense = has_dense_run(work.curve.pieces, kDenseWidths * options.curvature_ramp_mm);
  const auto try_shape = [&](Shape shape) {
    const bool compares = out.deviation_mm <= options.tolerance_mm;
    plan(shape, compares ? kLikely * out.duration_s() : kNever_s, work.shape_trial);
    if (work.shape_trial.deviation_mm <= options.tolerance_mm &&
        work.shape_trial.duration_s() < out.duration_s())
      std::swap(work.shape_trial, out);
  };
  if (!(options.slack > 0.0 && out.deviation_mm <= options.tolerance_mm))
    try_shape(Shape::kPlain);  // it seldom wins, and by little
  if (dense) try_shape(Shape::kSmoothed);
}

void plan_between(const CleanPath& path, std::size_t from, std::size_t to, const CertifiedTask& task,
                  CertifiedWork& work, StopSegment& out) {
  const PlanOptions& options = task.options;
  if (options.curve_rule == CurveRule::kRamped) return plan_as_recorded(path, from, to, task, work, out);
  const bool free = free_form(path, from, to, task, work);
  const bool moves = path.yaw_rad.empty() && (within_tolerance(options) ||
                                              (options.slack == 0.0 && options.method == Method::kOptimal));
  const auto plan_shape = [&](Shape shape, double most_s, StopSegment& segment) {
    if (shape != Shape::kFitted || !moves)
      return plan_part(path, from, to, shape, most_s, task, work, segment);
    segment.first = from;
    segment.last = to;
    plan_fitted(part(path, from, to), speed_limits(path, from, to), given_curves(path, from, to, work), task,
                work, segment);
  };
  plan_shape(free ? Shape::kFitted : Shape::kRamped, kNever_s, out);
  if (free && hold_mm(options) > 0.0) {
    StopSegment& other = work.other_shape;
    plan_shape(Shape::kRamped, kNever_s, other);
    const bool other_holds = holds(other, options), out_holds = holds(out, options);
    if (other_holds != out_holds ? other_holds : other.duration_s() < out.duration_s()) std::swap(other, out);
  }
  if (!(options.tolerance_mm > 0.0) || !path.yaw_rad.empty()) return prove(task, work, out);
  const bool inside = out.deviation_mm <= options.tolerance_mm;
  if (inside &&
      out.duration_s() <= (kFastEnough + options.slack) * straight_time_s(path, from, to, 1.0, task, work))
    return;
  if (options.slack > 0.0 && inside &&
      (free || !has_dense_run(work.curve.pieces, kDenseWidths * options.curvature_ramp_mm)))
    return;
  const auto take_better = [&](StopSegment& other) {
    const bool other_inside = other.deviation_mm <= options.tolerance_mm,
               out_inside = out.deviation_mm <= options.tolerance_mm;
    if (other_inside != out_inside ? other_inside : other.duration_s() < out.duration_s())
      std::swap(other, out);
  };
  for (const Shape shape : {free ? Shape::kRamped : Shape::kFitted, Shape::kPlain}) {
    const bool compares = out.deviation_mm <= options.tolerance_mm;
    StopSegment& other = work.other_shape;
    plan_shape(shape, compares ? out.duration_s() : kNever_s, other);
    take_better(other);
  }
}

/// True where the path turns from a-b to b-c by less than 154 degrees.
bool rollable(Point2 a, Point2 b, Point2 c) {
  const double ux = b.x_mm - a.x_mm, uy = b.y_mm - a.y_mm, vx = c.x_mm - b.x_mm, vy = c.y_mm - b.y_mm;
  return ux * vx + uy * vy > kRollableCosine * std::sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy));
}

/// How far from a corner on either side stopping there still shows.
double trial_mm(const CleanPath& path, std::size_t corner, const CertifiedTask& task) {
  const RateLimits& limit = task.limits.position;
  const double v =
      std::min(limit.rate, std::max(path.speed_limit_mm_s[corner - 1], path.speed_limit_mm_s[corner]));
  const double stop_s = v * limit.jerk > limit.acceleration * limit.acceleration
                            ? v / limit.acceleration + limit.acceleration / limit.jerk
                            : 2.0 * std::sqrt(v / limit.jerk);
  return std::min(kTrialMm, kLeastTrialMm + kTrialStops * 0.5 * v * stop_s);
}

/// True if rolling the corner at stops[k] is faster than stopping there, estimated on the path near it.
bool rolls_faster(const CleanPath& path, const std::vector<std::size_t>& stops, std::size_t k,
                  const CertifiedTask& task, CertifiedWork& work) {
  const std::size_t corner = stops[k];
  const double most_mm = trial_mm(path, corner, task);
  const auto far = [&](std::size_t i) {
    const double dx = path.points[i].x_mm - path.points[corner].x_mm,
                 dy = path.points[i].y_mm - path.points[corner].y_mm;
    return dx * dx + dy * dy > most_mm * most_mm;
  };
  std::size_t from = corner - 1, to = corner + 1;
  while (from > stops[k - 1] && !far(from)) --from;
  while (to < stops[k + 1] && !far(to)) ++to;
  const auto plan = [&](std::size_t a, std::size_t b) {
    work.corner_trial.first = a;
    const Shape shape = free_form(path, a, b, task, work) ? Shape::kFitted : Shape::kRamped;
    plan_segment(part(path, a, b), speed_limits(path, a, b), yaws(path, a, b), given_curves(path, a, b, work),
                 shape, 0.0, task, work, work.corner_trial);
    return work.corner_trial.duration_s();
  };
  const double rolling = plan(from, to);
  if (work.corner_trial.deviation_mm > task.options.tolerance_mm) return false;
  if (rolling < straight_time_s(path, from, corner, kShorter, task, work) +
                    straight_time_s(path, corner, to, kShorter, task, work))
    return true;
  return rolling < plan(from, corner) + plan(corner, to);
}

/// Plans between the stops into `out`. Segments that another candidate has planned are reused. Returns the
/// duration, or at once something larger than `most_s` where it takes longer.
double plan_all(const CleanPath& path, const std::vector<std::size_t>& stops, const CertifiedTask& task,
                CertifiedWork& work, std::vector<StopSegment>& out, double most_s = kUnlimited,
                const std::vector<StopSegment>* planned = nullptr, std::size_t planned_count = 0) {
  if (out.size() + 1 < stops.size()) out.resize(stops.size() - 1);
  double total = 0.0;
  std::size_t at = 0;
  for (std::size_t k = 0; k + 1 < stops.size() && total <= most_s; ++k) {
    while (at < planned_count && (*planned)[at].first < stops[k]) ++at;
    if (at < planned_count && (*planned)[at].first == stops[k] && (*planned)[at].last == stops[k + 1])
      out[k] = (*planned)[at];
    else
      plan_between(path, stops[k], stops[k + 1], task, work, out[k]);
    total += out[k].duration_s();
  }
  return total;
}

/// Parts each chord of a thinned polygon whose ends are one point, a loop smaller than the tolerance, at the
/// farthest vertex.
void open_loops(std::span<const Point2> points, std::vector<std::size_t>& kept) {
  constexpr double kSame_mm = 1e-9;
  for (std::size_t k = 0; k + 1 < kept.size(); ++k) {
    const Point2 start = points[kept[k]];
    if (distance(points[kept[k + 1]], start) > kSame_mm) continue;
    const auto farthest = std::max_element(
        points.begin() + std::ptrdiff_t(kept[k]), points.begin() + std::ptrdiff_t(kept[k + 1]),
        [&](Point2 a, Point2 b) { return distance(start, a) < distance(start, b); });
    kept.insert(kept.begin() + std::ptrdiff_t(k) + 1, std::size_t(farthest - points.begin()));
    ++k;
  }
}

/// True where points[i + 1] lies behind or beside points[i] by no more than twice `within_mm`.
bool steps_back(std::span<const Point2> points, std::size_t i, double within_mm) {
  if (i == 0 || i + 2 >= points.size()) return false;
  const Point2 &before = points[i - 1], &p = points[i], &q = points[i + 1];
  constexpr double kCosine = 0.5;
  const double x = q.x_mm - p.x_mm, y = q.y_mm - p.y_mm, step = std::sqrt(x * x + y * y);
  return step <= 2.0 * within_mm &&
         (p.x_mm - before.x_mm) * x + (p.y_mm - before.y_mm) * y < kCosine * step * distance(before, p);
}

/// Returns the points between two rests that turn back by a step longer than twice `within_mm`, and the
/// rests.
std::vector<std::size_t> turning_points(const CleanPath& path, std::size_t from, std::size_t to,
                                        double within_mm) {
  const auto slight = [&](std::size_t i) { return i > from && steps_back(path.points, i, within_mm); };
  std::vector<std::size_t> stops{from};
  for (std::size_t i = from + 1; i < to; ++i) {
    const Point2 &a = path.points[i - 1], &b = path.points[i], &c = path.points[i + 1];
    if ((b.x_mm - a.x_mm) * (c.x_mm - b.x_mm) + (b.y_mm - a.y_mm) * (c.y_mm - b.y_mm) < 0.0 && !slight(i) &&
        !slight(i - 1))
      stops.push_back(i);
  }
  stops.push_back(to);
  return stops;
}

/// Replaces segments of held points by some between those that turn back by more than their rounding, where
/// that is faster or they are not inside, then where they are not inside between all that turn back.
template <class Inside>
void stop_at_turns(const CleanPath& path, const CertifiedTask& task, CertifiedWork& work,
                   const Inside& inside, std::vector<StopSegment>& segments) {
  constexpr double kShareOfHold = 0.95;
  for (const double within_mm : {kShareOfHold * hold_mm(task.options), 0.0}) {
    std::vector<StopSegment> all;
    for (StopSegment& whole : segments) {
      const bool held = inside(whole);
      std::vector<std::size_t> stops;
      if (!held || within_mm > 0.0) stops = turning_points(path, whole.first, whole.last, within_mm);
      std::vector<StopSegment> shorter;
      double total_s = 0.0;
      bool better = stops.size() > 2;
      for (std::size_t i = 0; better && i + 1 < stops.size(); ++i) {
        plan_between(path, stops[i], stops[i + 1], task, work, shorter.emplace_back());
        total_s += shorter.back().duration_s();
        better = !held || (inside(shorter.back()) && total_s < whole.duration_s());
      }
      if (better)
        all.insert(all.end(), std::make_move_iterator(shorter.begin()),
                   std::make_move_iterator(shorter.end()));
      else
        all.push_back(std::move(whole));
    }
    std::swap(segments, all);
  }
}

/// Replaces each segment whose curve leaves the tolerance (a cusp, a spike, a tangle shorter than the
/// tolerance) by a thinned polygon with rests at its vertices, held points first by segments between those
/// that turn back. Returns the number of segments.
std::size_t keep_inside(const CleanPath& path, const CertifiedTask& task, CertifiedWork& work,
                        std::size_t count) {
  const PlanOptions& options = task.options;
  const double hold = hold_mm(options);
  const double allowed_mm = options.tolerance_mm > 0.0 ? options.tolerance_mm
                            : hold > 0.0               ? hold
                                                       : farthest_mm(options);
  const auto inside = [&](const StopSegment& s) {
    return hold > 0.0 ? holds(s, options) && s.deviation_mm <= farthest_mm(options)
                      : s.deviation_mm <= allowed_mm;
  };
  const auto end = work.segments.begin() + std::ptrdiff_t(count);
  if (options.curve_rule == CurveRule::kRamped || !path.yaw_rad.empty() ||
      (!(hold > 0.0) && std::all_of(work.segments.begin(), end, inside)))
    return count;
  std::vector<StopSegment> parts(std::make_move_iterator(work.segments.begin()),
                                 std::make_move_iterator(end)),
      all;
  if (hold > 0.0) stop_at_turns(path, task, work, inside, parts);
  for (StopSegment& whole : parts) {
    if (inside(whole)) {
      all.push_back(std::move(whole));
      continue;
    }
    std::vector<std::size_t> kept;
    thin_polyline(part(path, whole.first, whole.last), 0.45 * allowed_mm, kept);
    open_loops(part(path, whole.first, whole.last), kept);
    for (std::size_t i = 0; i + 1 < kept.size(); ++i) {
      const std::size_t from = whole.first + kept[i], to = whole.first + kept[i + 1];
      const Point2 ends[2] = {path.points[from], path.points[to]};
      const auto limits = speed_limits(path, from, to);
      const double limit = *std::min_element(limits.begin(), limits.end());
      StopSegment& segment = all.emplace_back();
      segment.first = from;
      segment.last = to;
      plan_segment(ends, {&limit, 1}, {}, {}, Shape::kRamped, kNever_s, task, work, segment);
      if (!std::isfinite(segment.duration_s())) continue;
      const auto reference =
          sample_given(part(path, from, to), given_curves(path, from, to, work), work.reference);
      segment.deviation_mm = frechet_bound(segment.curve, reference.points) + reference.sagitta_mm;
      segment.points_off_mm = hold > 0.0 ? farthest_point_mm(segment.curve, part(path, from, to), hold) : 0.0;
    }
  }
  work.segments = std::move(all);
  return work.segments.size();
}

std::size_t choose_segments(const CleanPath& path, const CertifiedTask& task, CertifiedWork& work) {
  std::vector<std::size_t> corners, kept;
  find_corners(path, task.options, kept, corners);
  corners = with_stops(corners, path);
  if (!(task.options.tolerance_mm > 0.0) || corners.size() == 2) {
    plan_all(path, corners, task, work, work.segments);
    return corners.size() - 1;
  }
  // three candidates: roll where the neighbourhood says so, roll every corner that can be, stop at every
  // corner
  std::vector<std::size_t> none{corners.front()}, some{corners.front()};
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    const bool asked = std::binary_search(path.stops.begin(), path.stops.end(), corners[k]);
    const auto at = std::lower_bound(kept.begin(), kept.end(), corners[k]);
    const bool can = !asked && at + 1 < kept.end() && *at == corners[k] &&
                     rollable(path.points[*(at - 1)], path.points[*at], path.points[*(at + 1)]);
    if (!can) none.push_back(corners[k]);
    if (!can || !rolls_faster(path, corners, k, task, work)) some.push_back(corners[k]);
  }
  none.push_back(corners.back());
  some.push_back(corners.back());
  double least = kUnlimited;
  std::size_t count = 0;
  const auto consider = [&](const std::vector<std::size_t>& stops, bool fallback) {
    const double total = plan_all(path, stops, task, work, work.candidate, least, &work.segments, count);
    const auto end = work.candidate.begin() + std::ptrdiff_t(stops.size() - 1);
    const bool inside = total < least && std::all_of(work.candidate.begin(), end, [&](const StopSegment& s) {
                          return s.deviation_mm <= task.options.tolerance_mm;
                        });
    if (!inside && !(fallback && count == 0)) return;
    least = total;
    count = stops.size() - 1;
    std::swap(work.candidate, work.segments);
  };
  const auto stopping_s = [&] {
    double sum = 0.0;
    for (std::size_t k = 0; k + 1 < corners.size(); ++k)
      sum += straight_time_s(path, corners[k], corners[k + 1], kShorter, task, work);
    return sum;
  };
  consider(some, false);
  if (none != some) consider(none, false);
  if (corners != some && (count == 0 || stopping_s() < least)) consider(corners, true);
  if (count == 0) consider(some, true);  // some = corners, outside all the same
  return count;
}

}  // namespace

std::size_t plan_segments(const CleanPath& path, const CertifiedTask& task, CertifiedWork& work) {
  const std::size_t count = keep_inside(path, task, work, choose_segments(path, task, work));
  for (std::size_t k = 0; k < count; ++k)
    if (!std::isfinite(work.segments[k].duration_s())) throw MotionError(Fault(Reason::kNoSolution));
  return count;
}

}  // namespace firn::motion
