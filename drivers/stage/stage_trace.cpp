// Stage: following a way of X and Y by the controller's own program, the shutter switched by the way
// travelled.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "drivers/stage/stage.h"

namespace firn::drivers {
namespace {

constexpr std::size_t kMostKnots = 3000;  // 5 doubles each of the controller's DGLOBAL [P]
constexpr std::size_t kDglobals = 16384;  // the samples take those behind the knots
constexpr double kAfterTheEnd_s = 0.1;    // the program records so much longer than the way is planned
constexpr double kPlausible_mm = 0.02;    // beyond what the way's acceleration explains
constexpr double kSettlePoll_s = 0.005;

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
  followed_ = {};
  counted_ = 0;
  sampling_ = config_.path_sample_s > 0.0;
  if (sampling_) {
    // Whole milliseconds, so many that the samples of the whole way find room.
    const double room = double((kDglobals - 5 * way_.knots.size()) / 2);
    const double least_s = (way_.knots.back().t_s + kAfterTheEnd_s) / room;
    const auto period_ms = std::int64_t(std::ceil(std::max(config_.path_sample_s, least_s) * 1e3 - 1e-9));
    followed_.period_s = double(period_ms) * 1e-3;
    link_.push(set("IGLOBAL", config_.dialect.path_period_iglobal).integer(period_ms));
    link_.push(set("IGLOBAL", config_.dialect.path_samples_iglobal).integer(0));
  }
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

// Status says "no motion" before the servo has settled on its target. A controller that never reports it
// does not begin.
bool Stage::settled(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kArming) {
    if (!(config_.settle_s > 0.0)) return true;
    phase_ = Phase::kSettling;
    move_limit_us_ = now_us + std::int64_t((config_.settle_s + 2.0 * config_.host_latency_s) * 1e6);
    poll_at_us_ = now_us;
    asked_ = false;
  }
  if (!asked_) {
    if (now_us < poll_at_us_) return false;
    for (const int axis : {0, 1}) read("AXISSTATUS(@)", axis, kStatus);
    asked_ = true;
    return false;
  }
  if (status_[0] & status_[1] & ensemble::kInPosition) return true;
  if (now_us >= move_limit_us_) {
    const std::string why = std::string("axis ") + (status_[0] & ensemble::kInPosition ? "Y" : "X") +
                            " does not settle at the start of the path";
    fault(Severity::kStop, kStall, "stage: " + why, fx);
    begin_stop(now_us, fx, why, kStall);
    return false;
  }
  asked_ = false;
  poll_at_us_ = now_us + std::int64_t(kSettlePoll_s * 1e6);
  return false;
}

// One question at a time, and none while the state of the motion is due: a stop is never behind them.
bool Stage::read_samples() {
  if (!sampling_) return false;
  const auto read_so_far = std::int32_t(followed_.x_mm.size() + followed_.y_mm.size());
  const auto ask = [&](const char* name, std::int64_t index, Tag tag) {
    Request r = Line(config_.table, Repeat::kRead, tag, ensemble::kValue)
                    .text(name)
                    .text("(")
                    .integer(index)
                    .text(")");
    r.argument = read_so_far;
    link_.push(r);
    return true;
  };
  if (read_so_far < 2 * counted_)
    return ask("DGLOBAL", std::int64_t(5 * way_.knots.size()) + read_so_far, kSample);
  if (counted_for_ == poll_at_us_) return false;
  counted_for_ = poll_at_us_;
  return ask("IGLOBAL", config_.dialect.path_samples_iglobal, kSamples);
}

// The same once the motion is over, until nothing is left.
bool Stage::read_last_samples() {
  poll_at_us_ = -1;
  return read_samples();
}

void Stage::take_sample(std::int32_t index, double value_mm) {
  std::vector<float>& held = index % 2 == 0 ? followed_.x_mm : followed_.y_mm;
  if (index != std::int32_t(followed_.x_mm.size() + followed_.y_mm.size())) return;
  const WayKnot& start = way_.knots.front();
  const std::size_t n = held.size();
  const double last = n > 0 ? double(held[n - 1]) : index % 2 == 0 ? start.x_mm : start.y_mm;
  const double foreseen = n > 1 ? 2.0 * last - double(held[n - 2]) : last;
  const bool far = std::abs(value_mm - foreseen) > plausible_mm_;
  if (far && !std::exchange(sample_again_, true)) return;  // perhaps a damaged digit: asked once more
  sample_again_ = false;
  held.push_back(float(value_mm));
}

void Stage::report_followed(Effects& fx) {
  if (!(config_.path_sample_s > 0.0)) return;
  followed_.x_mm.resize(followed_.y_mm.size());
  fx.measured(std::exchange(followed_, {}));
}

void Stage::follow(std::int64_t now_us) {
  followed_.begin_us = now_us;
  double steepest = 0.0;
  for (std::size_t k = 1; k < way_.knots.size(); ++k) {
    const WayKnot &a = way_.knots[k - 1], &b = way_.knots[k];
    const double change = std::abs(b.vx_mm_s - a.vx_mm_s) + std::abs(b.vy_mm_s - a.vy_mm_s);
    steepest = std::max(steepest, change / (b.t_s - a.t_s));
  }
  plausible_mm_ = steepest * followed_.period_s * followed_.period_s + kPlausible_mm;
  counted_for_ = 0;
  sample_again_ = false;
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
