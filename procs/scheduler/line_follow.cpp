// The path that the stage followed, of the line loop: awaited after each way, compared with the plan,
// reported.
#include <cstdio>
#include <limits>
#include <utility>

#include "firn/path_report_t.hpp"
#include "procs/scheduler/line_loop.h"

namespace firn {
namespace {

std::vector<Point2> points_of(const std::optional<followed_path_t>& followed) {
  std::vector<Point2> points;
  if (followed)
    for (std::size_t k = 0; k < followed->x_mm.size(); ++k)
      points.push_back({double(followed->x_mm[k]), double(followed->y_mm[k])});
  return points;
}

}  // namespace

bool LineLoop::path_recorded() const { return experiment().stage.path_sample_s > 0.0; }

// It can overtake the answer, or arrive after a stop has ended the phase.
void LineLoop::on(const followed_path_t& m, Time now, Outbox& out) {
  if (m.path != way_.path) return;
  followed_ = m;
  if (phase_ == Phase::kRunPath && act_answer_) path_over(now, out);
}

void LineLoop::path_over(Time now, Outbox& out) {
  if (path_recorded() && !followed_)
    return out.wake_at(kDeadline, now.after_s(kSlackWall_s * experiment().run.time_scale));
  if (path_recorded()) out.cancel(kDeadline);
  const PathErrors errors = errors_of_way();
  const std::string off = off_path(errors);
  settle(errors, out);
  if (off.empty()) return proceed(Phase::kArmProfiler, now, out);
  phase_ = Phase::kArmProfiler;  // a resume measures what lies there
  fail(17, off, now, out);
}

PathErrors LineLoop::errors_of_way() const {
  const std::vector<Point2> followed = points_of(followed_);
  if (followed.empty() || way_.t_s.empty()) return {};
  std::vector<PathKnot> knots;
  for (std::size_t k = 0; k < way_.t_s.size(); ++k)
    knots.push_back({way_.t_s[k], way_.x_mm[k], way_.y_mm[k], way_.vx_mm_s[k], way_.vy_mm_s[k]});
  return path_errors(TimedPath(std::move(knots)), followed_->period_s, followed, way_.switch_mm);
}

std::string LineLoop::off_path(const PathErrors& e) const {
  const double most = experiment().process.most_path_error_mm;
  char text[240];
  if (e.contour_max_mm > most) {
    std::snprintf(
        text, sizeof text,
        "layer %d: the stage was %.3f mm off its path at (%.3f, %.3f) mm, %.2f s after the beginning; "
        "process.most_path_error_mm is %g",
        way_.layer, e.contour_max_mm, e.worst.x_mm, e.worst.y_mm, e.worst_s, most);
    return text;
  }
  if (e.stall_max_mm > most) {
    std::snprintf(
        text, sizeof text,
        "layer %d: the stage was %.3f mm from its place %.2f s after the beginning of its path: an axis "
        "drags or stands; process.most_path_error_mm is %g",
        way_.layer, e.stall_max_mm, e.stall_s, most);
    return text;
  }
  if (e.switch_max_mm > most) {
    std::snprintf(text, sizeof text,
                  "layer %d: switch %d of the shutter came %.3f mm from its place along the path; "
                  "process.most_path_error_mm is %g",
                  way_.layer, e.worst_switch + 1, e.switch_max_mm, most);
    return text;
  }
  return {};
}

// The layer counts as printed, whole or not: the way is not followed again.
void LineLoop::settle(const PathErrors& errors, Outbox& out) {
  if (!act_answer_) return;
  const answer_t a = *std::exchange(act_answer_, std::nullopt);
  const bool off = !off_path(errors).empty();
  way_done_ = Outcome(a.outcome) == Outcome::kDone && !off;
  if (!way_done_) {
    in_doubt_ = true;
    doubt_accepted_ = false;
  }
  ++layers_done_;
  scan_attempt_ = 0;
  path_report_t r{};
  r.path = r.batch = way_.path;
  r.layer = layers_done_;
  r.attempt = way_.attempt;
  r.outcome = off ? std::int8_t(Outcome::kUnknown) : a.outcome;
  r.pulses_commanded = way_.switches;
  r.pulses_counted = a.counted;
  r.planned_s = way_.duration_s;
  r.measured_s = std::numeric_limits<double>::quiet_NaN();
  r.begin_utime_us = way_began_us_;
  r.volume_mm3 = experiment().aerosol.flow_mm3_s * way_.open_s;
  r.samples = std::int32_t(errors.samples);
  r.contour_max_mm = errors.contour_max_mm;
  r.contour_rms_mm = errors.contour_rms_mm;
  r.following_max_mm = errors.following_max_mm;
  r.lag_max_s = errors.lag_max_s;
  r.switch_max_mm = errors.switch_max_mm;
  r.offset_rms_mm = station_offset_rms_mm(points_of(followed_), stations_);
  switches_total_ += std::max<std::int64_t>(0, a.counted);
  out.send(channels::kPathReport, r);
  followed_.reset();
}

}  // namespace firn
