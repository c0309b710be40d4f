#include "core/motion/certified/stop_choice.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/motion/certified/path_corners.h"
#include "core/motion/curve/polyline_thinning.h"

namespace firn::motion {
namespace {

using Stops = std::vector<std::size_t>;  ///< ascending indices of points, both ends among them

/// True where the path turns from a-b to b-c by less than 154 degrees.
bool rollable(Point2 a, Point2 b, Point2 c) {
  const double ux = b.x_mm - a.x_mm, uy = b.y_mm - a.y_mm, vx = c.x_mm - b.x_mm, vy = c.y_mm - b.y_mm;
  return ux * vx + uy * vy > kRollableCosine * std::sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy));
}

/// Returns the distance from a corner, on either side, up to which a stop there changes the profile [mm].
double trial_mm(const CleanPath& path, std::size_t corner, const RateLimits& limit) {
  const double v =
      std::min(limit.rate, std::max(path.speed_limit_mm_s[corner - 1], path.speed_limit_mm_s[corner]));
  const double stop_s = v * limit.jerk > limit.acceleration * limit.acceleration
                            ? v / limit.acceleration + limit.acceleration / limit.jerk
                            : 2.0 * std::sqrt(v / limit.jerk);
  return std::min(kMaxTrial_mm, kMinTrial_mm + kTrialStops * 0.5 * v * stop_s);
}

/// Parts each chord of a thinned polygon whose ends are one point, a loop smaller than the tolerance, at the
/// farthest vertex.
void open_loops(std::span<const Point2> points, std::vector<std::size_t>& kept) {
  for (std::size_t k = 0; k + 1 < kept.size(); ++k) {
    const Point2 start = points[kept[k]];
    if (distance(points[kept[k + 1]], start) > kSamePoint_mm) continue;
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
  const double x = q.x_mm - p.x_mm, y = q.y_mm - p.y_mm, step = std::sqrt(x * x + y * y);
  return step <= 2.0 * within_mm && (p.x_mm - before.x_mm) * x + (p.y_mm - before.y_mm) * y <
                                        kStepBackCosine * step * distance(before, p);
}

/// Returns the points between two rests that turn back by a step longer than twice `within_mm`, and the
/// rests.
Stops turning_points(const CleanPath& path, std::size_t from, std::size_t to, double within_mm) {
  const auto slight = [&](std::size_t i) { return i > from && steps_back(path.points, i, within_mm); };
  Stops stops{from};
  for (std::size_t i = from + 1; i < to; ++i) {
    const Point2 &a = path.points[i - 1], &b = path.points[i], &c = path.points[i + 1];
    if ((b.x_mm - a.x_mm) * (c.x_mm - b.x_mm) + (b.y_mm - a.y_mm) * (c.y_mm - b.y_mm) < 0.0 && !slight(i) &&
        !slight(i - 1))
      stops.push_back(i);
  }
  stops.push_back(to);
  return stops;
}

class StopChoice {
 public:
  StopChoice(const CleanPath& path, const CertifiedTask& task, StopWork& work)
      : path_(path),
        options_(task.options),
        limit_(task.limits.position),
        shapes_(path, task, work.segment),
        work_(work) {}

  /// Plans between the corners, or between some of them where rolling the others is faster. Returns the
  /// number of segments, 0 = without a tolerance they take longer than `max_s`.
  std::size_t choose(double max_s);

  /// Replaces each of `count` segments whose curve leaves the tolerance (a cusp, a spike, a tangle shorter
  /// than the tolerance) by a thinned polygon with rests at its vertices, held points first by segments
  /// between those that turn back. Returns the number of segments.
  std::size_t keep_inside(std::size_t count);

 private:
  bool rolls_faster(const Stops& stops, std::size_t k);
  double plan_all(const Stops& stops, std::vector<StopSegment>& out, double max_s = kUnlimited,
                  std::size_t planned_count = 0);
  void consider(const Stops& stops, bool fallback);
  void stop_at_turns(std::vector<StopSegment>& segments);
  void stop_at_vertices(const StopSegment& whole, std::vector<StopSegment>& out);
  bool inside(const StopSegment& segment) const;
  double allowed_mm() const;

  const CleanPath& path_;
  const PlanOptions& options_;
  const RateLimits& limit_;
  ShapeChoice shapes_;
  StopWork& work_;
  double min_s_ = kUnlimited;  ///< duration of the fastest candidate
  std::size_t count_ = 0;      ///< of its segments, 0 = no candidate yet
};

/// True if rolling the corner at stops[k] is faster than stopping there, estimated on the path near it.
bool StopChoice::rolls_faster(const Stops& stops, std::size_t k) {
  const std::size_t corner = stops[k];
  const double max_mm = trial_mm(path_, corner, limit_);
  const auto far = [&](std::size_t i) {
    const double dx = path_.points[i].x_mm - path_.points[corner].x_mm,
                 dy = path_.points[i].y_mm - path_.points[corner].y_mm;
    return dx * dx + dy * dy > max_mm * max_mm;
  };
  std::size_t from = corner - 1, to = corner + 1;
  while (from > stops[k - 1] && !far(from)) --from;
  while (to < stops[k + 1] && !far(to)) ++to;
  StopSegment& trial = work_.corner_trial;
  const auto planned_s = [&](std::size_t a, std::size_t b) {
    shapes_.plan_likely(a, b, trial);
    return trial.duration_s();
  };
  const double rolling_s = planned_s(from, to);
  if (!inside_tolerance(trial, options_)) return false;
  if (rolling_s < shapes_.straight_time_s(from, corner, kRolledLength) +
                      shapes_.straight_time_s(corner, to, kRolledLength))
    return true;
  return rolling_s < planned_s(from, corner) + planned_s(corner, to);
}

/// Plans between the stops into `out`. The first `planned_count` of work_.segments, which another candidate
/// has planned, are reused. Returns the duration, or at once something larger than `max_s` where it takes
/// longer.
double StopChoice::plan_all(const Stops& stops, std::vector<StopSegment>& out, double max_s,
                            std::size_t planned_count) {
  const std::vector<StopSegment>& planned = work_.segments;
  if (out.size() + 1 < stops.size()) out.resize(stops.size() - 1);
  double total_s = 0.0;
  std::size_t at = 0;
  for (std::size_t k = 0; k + 1 < stops.size() && total_s <= max_s; ++k) {
    while (at < planned_count && planned[at].first < stops[k]) ++at;
    if (at < planned_count && planned[at].first == stops[k] && planned[at].last == stops[k + 1])
      out[k] = planned[at];
    else
      shapes_.plan(stops[k], stops[k + 1], out[k], max_s - total_s);
    total_s += out[k].duration_s();
  }
  return total_s;
}

/// Takes a candidate that is faster than those before it and inside the tolerance.
/// @param fallback it is taken outside, too, if it is the first
void StopChoice::consider(const Stops& stops, bool fallback) {
  const double total_s = plan_all(stops, work_.candidate, min_s_, count_);
  const auto end = work_.candidate.begin() + std::ptrdiff_t(stops.size() - 1);
  const bool inside = total_s < min_s_ && std::all_of(work_.candidate.begin(), end, [&](const auto& s) {
                        return inside_tolerance(s, options_);
                      });
  if (!inside && !(fallback && count_ == 0)) return;
  min_s_ = total_s;
  count_ = stops.size() - 1;
  std::swap(work_.candidate, work_.segments);
}

std::size_t StopChoice::choose(double max_s) {
  Stops corners, kept;
  find_corners(path_, options_, kept, corners);
  corners = with_stops(corners, path_);
  if (!(options_.tolerance_mm > 0.0) || corners.size() == 2) {
    const double total_s = plan_all(corners, work_.segments, max_s);
    return total_s > max_s && max_s < kNoMaxDuration_s ? 0 : corners.size() - 1;
  }
  // three candidates: roll where the neighbourhood says so, roll every corner that can be, stop at every
  // corner
  Stops none{corners.front()}, some{corners.front()};
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    const bool asked = std::binary_search(path_.stops.begin(), path_.stops.end(), corners[k]);
    const auto at = std::lower_bound(kept.begin(), kept.end(), corners[k]);
    const bool can = !asked && at + 1 < kept.end() && *at == corners[k] &&
                     rollable(path_.points[*(at - 1)], path_.points[*at], path_.points[*(at + 1)]);
    if (!can) none.push_back(corners[k]);
    if (!can || !rolls_faster(corners, k)) some.push_back(corners[k]);
  }
  none.push_back(corners.back());
  some.push_back(corners.back());
  const auto stopping_s = [&] {
    double sum = 0.0;
    for (std::size_t k = 0; k + 1 < corners.size(); ++k)
      sum += shapes_.straight_time_s(corners[k], corners[k + 1], kRolledLength);
    return sum;
  };
  consider(some, false);
  if (none != some) consider(none, false);
  if (corners != some && (count_ == 0 || stopping_s() < min_s_)) consider(corners, true);
  if (count_ == 0) consider(some, true);  // some = corners, outside all the same
  return count_;
}

double StopChoice::allowed_mm() const {
  const double hold = hold_mm(options_);
  return hold > 0.0 ? hold : allowed_deviation_mm(options_);
}

bool StopChoice::inside(const StopSegment& s) const {
  return hold_mm(options_) > 0.0 ? holds(s, options_) && s.deviation_mm <= max_deviation_mm(options_)
                                 : s.deviation_mm <= allowed_mm();
}

/// Replaces segments of held points by some between those that turn back by more than their rounding, where
/// that is faster or they are not inside, then where they are not inside between all that turn back.
void StopChoice::stop_at_turns(std::vector<StopSegment>& segments) {
  for (const double within_mm : {kStepBackShare * hold_mm(options_), 0.0}) {
    std::vector<StopSegment> all;
    for (StopSegment& whole : segments) {
      const bool held = inside(whole);
      Stops stops;
      if (!held || within_mm > 0.0) stops = turning_points(path_, whole.first, whole.last, within_mm);
      std::vector<StopSegment> shorter;
      double total_s = 0.0;
      bool better = stops.size() > 2;
      for (std::size_t i = 0; better && i + 1 < stops.size(); ++i) {
        shapes_.plan(stops[i], stops[i + 1], shorter.emplace_back(),
                     held ? whole.duration_s() - total_s : kNoMaxDuration_s);
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

void StopChoice::stop_at_vertices(const StopSegment& whole, std::vector<StopSegment>& out) {
  const std::span<const Point2> points =
      std::span<const Point2>(path_.points).subspan(whole.first, whole.last - whole.first + 1);
  Stops kept;
  thin_polyline(points, kThinningShare * allowed_mm(), kept);
  open_loops(points, kept);
  for (std::size_t i = 0; i + 1 < kept.size(); ++i)
    shapes_.plan_chord(whole.first + kept[i], whole.first + kept[i + 1], out.emplace_back());
}

std::size_t StopChoice::keep_inside(std::size_t count) {
  const bool held = hold_mm(options_) > 0.0;
  const auto end = work_.segments.begin() + std::ptrdiff_t(count);
  const auto keeps = [&](const StopSegment& s) { return inside(s); };
  if (!path_.yaw_rad.empty() || (!held && std::all_of(work_.segments.begin(), end, keeps))) return count;
  std::vector<StopSegment> parts(std::make_move_iterator(work_.segments.begin()),
                                 std::make_move_iterator(end)),
      all;
  if (held) stop_at_turns(parts);
  for (StopSegment& whole : parts) {
    if (inside(whole))
      all.push_back(std::move(whole));
    else
      stop_at_vertices(whole, all);
  }
  work_.segments = std::move(all);
  return work_.segments.size();
}

}  // namespace

std::size_t plan_segments(const CleanPath& path, const CertifiedTask& task, StopWork& work, double max_s) {
  StopChoice choice(path, task, work);
  const std::size_t chosen = choice.choose(max_s), count = chosen > 0 ? choice.keep_inside(chosen) : 0;
  for (std::size_t k = 0; k < count; ++k)
    if (!std::isfinite(work.segments[k].duration_s())) throw MotionError(Fault(Reason::kNoSolution));
  return count;
}

}  // namespace firn::motion
