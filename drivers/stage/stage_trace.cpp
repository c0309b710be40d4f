// Stage: following a way of X and Y by the controller's own program, the shutter switched by the way
// travelled.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "drivers/stage/stage.h"

namespace firn::drivers {
namespace {

constexpr std::size_t kMostKnots = 3000;  // 5 doubles each of the controller's DGLOBAL [P]

}  // namespace

using ensemble::Line;

std::optional<std::string> Stage::way_refused(const StageWay& way) const {
  char text[160];
  const auto said = [&](std::size_t k, const std::string& what) {
    return "knot " + std::to_string(k) + ": " + what;
  };
  if (way.knots.size() < 2 || way.knots.size() > kMostKnots)
    return "a way of " + std::to_string(way.knots.size()) + " knots; 2 to " + std::to_string(kMostKnots) +
           " can be followed";
  if (way.switch_mm.size() % 2 != 0 ||
      way.switch_mm.size() > std::size_t(std::max(0, config_.table.increments())))
    return std::to_string(way.switch_mm.size()) + " switches of the shutter; an even number up to " +
           std::to_string(config_.table.increments()) + " can be held";
  for (std::size_t k = 0; k < way.knots.size(); ++k) {
    const WayKnot& at = way.knots[k];
    if (const auto why = limit_broken('X', at.x_mm, limits_[0])) return said(k, *why);
    if (const auto why = limit_broken('Y', at.y_mm, limits_[1])) return said(k, *why);
    const double speed = std::sqrt(at.vx_mm_s * at.vx_mm_s + at.vy_mm_s * at.vy_mm_s);
    if (!(speed <= limits_[0].max_speed_mm_s)) {
      std::snprintf(text, sizeof text, "speed %.4f mm/s is above %.4f mm/s", speed,
                    limits_[0].max_speed_mm_s);
      return said(k, text);
    }
    if (k == 0 ? at.t_s != 0.0 : !(at.t_s > way.knots[k - 1].t_s))
      return said(k, "times do not ascend from 0");
  }
  std::int64_t before = 0;
  for (std::size_t n = 0; n < way.switch_mm.size(); ++n) {
    const auto counts = std::int64_t(std::llround(way.switch_mm[n] * config_.counts_per_mm));
    if (counts <= before)
      return "switch " + std::to_string(n) + " of the shutter is not behind the one before";
    before = counts;
  }
  return std::nullopt;
}

void Stage::begin_trace(StageWay way, double z_mm, std::int64_t now_us, Effects& fx) {
  if (!accept(Op::kTrace, fx)) return;
  if (const auto why = way_refused(way)) return refuse(kLimit, *why, fx);
  if (auto why = std::isnan(z_mm) ? std::nullopt : limit_broken('Z', z_mm, limits_[2]))
    return refuse(kLimit, *why, fx);
  op_ = Op::kTrace;
  runs_.clear();
  start_mm_ = {way.knots[0].x_mm, way.knots[0].y_mm, z_mm};
  expected_ = std::int64_t(way.switch_mm.size());
  way_ = std::move(way);
  start_operation(now_us, fx);
}

void Stage::push_way() {
  pulses_set_up_[0] = false;  // a pass would need the output's other mode
  std::fill(increments_held_.begin(), increments_held_.end(), -1);
  const auto set = [&](const char* name, std::int64_t index) -> Line {
    return Line(config_.table, Repeat::kSetup, kPlain).text(name).text("(").integer(index).text(")=");
  };
  link_.push(set("IGLOBAL", config_.dialect.path_count_iglobal).integer(std::int64_t(way_.knots.size())));
  for (std::size_t k = 0; k < way_.knots.size(); ++k) {
    const WayKnot& at = way_.knots[k];
    // The start is where the stage stands, to the rounding of its target.
    const double numbers[] = {at.t_s, at.x_mm, at.y_mm, at.vx_mm_s, at.vy_mm_s};
    for (std::size_t n = 0; n < 5; ++n)
      link_.push(set("DGLOBAL", std::int64_t(5 * k + n)).fixed9(numbers[n]));
  }
  setup("PSOCONTROL @", 0, " RESET");
  if (on(config_.pulse_terminal)) setup("PSOOUTPUT @", 0, " CONTROL 1");
  setup("PSOOUTPUT @", 0, " TOGGLE");
  setup(config_.dialect.path_track, 0, "");
  if (way_.switch_mm.empty()) return;
  std::int64_t before = 0;
  for (std::size_t n = 0; n < way_.switch_mm.size(); ++n) {
    const auto counts = std::int64_t(std::llround(way_.switch_mm[n] * config_.counts_per_mm));
    link_.push(set("IGLOBAL", config_.table.first_iglobal + std::int64_t(n)).integer(counts - before));
    before = counts;
  }
  Line array(config_.table, Repeat::kSetup, kPlain);
  link_.push(array.text("PSOARRAY ")
                 .axis(0)
                 .text(",")
                 .integer(config_.table.first_iglobal)
                 .text(",")
                 .integer(std::int64_t(way_.switch_mm.size())));
  setup("PSODISTANCE @", 0, " ARRAY");
  Line arm(config_.table, Repeat::kNever, kMotion);
  link_.push(with_axis(arm, "PSOCONTROL @", 0).text(" ARM"));
}

void Stage::follow(std::int64_t now_us) {
  link_.push(Line(config_.table, Repeat::kNever, kMotion).text(config_.dialect.path_program));
  const WayKnot& end = way_.knots.back();
  target_mm_ = {end.x_mm, end.y_mm, std::numeric_limits<double>::quiet_NaN()};
  move_end_us_ = now_us + std::int64_t(end.t_s * 1e6) + 1000;
  move_limit_us_ =
      now_us +
      std::int64_t((end.t_s * config_.move_timeout_factor + 0.5 + 2.0 * config_.host_latency_s) * 1e6);
  poll_at_us_ = std::min(move_end_us_, now_us + std::int64_t(config_.poll_moving_s * 1e6));
  poll_ = Poll::kNone;
}

}  // namespace firn::drivers
