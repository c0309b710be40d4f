#include "drivers/robot/robot.h"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace firn::drivers {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string joint_text(std::size_t joint, double value) {
  char text[48];
  if (joint == 2)
    std::snprintf(text, sizeof text, "%.3f mm", value);
  else
    std::snprintf(text, sizeof text, "%.4f deg", value / kDegree);
  return text;
}

// Why a trajectory is not for this robot [interlock 8]; empty = it is.
std::string broken_limit(const RobotConfig& c, double tick_s, int axes, std::span<const double> positions) {
  if (axes != 4 || positions.size() < 8 || positions.size() % 4 != 0)
    return "the robot has 4 joints and needs two points, not " + std::to_string(axes) + " axes with " +
           std::to_string(positions.size()) + " positions";
  if (tick_s != c.tick_s)
    return "its tick is " + std::to_string(tick_s) + " s, the robot's " + std::to_string(c.tick_s) + " s";
  for (std::size_t n = 0; n < positions.size() / 4; ++n)
    for (std::size_t j = 0; j < 4; ++j) {
      const double q = positions[4 * n + j];
      const JointLimit& limit = c.limits[j];
      if (!(q >= limit.low && q <= limit.high))  // also NaN
        return "sample " + std::to_string(n) + ": J" + std::to_string(j + 1) + " = " + joint_text(j, q) +
               " is outside [" + joint_text(j, limit.low) + ", " + joint_text(j, limit.high) + "]";
      const double rate = n == 0 ? 0.0 : std::abs(q - positions[4 * (n - 1) + j]) / tick_s;
      if (rate > limit.most_rate)
        return "sample " + std::to_string(n) + ": J" + std::to_string(j + 1) + " would turn at " +
               joint_text(j, rate) + "/s, more than " + joint_text(j, limit.most_rate) + "/s";
    }
  return {};
}

}  // namespace

// Ranges and rates: Table 2-1. What a path may use is less (4.10); the planner's certificate holds it to
// that.
RobotConfig::RobotConfig()
    : limits{{{-105.0 * kDegree, 105.0 * kDegree, 360.0 * kDegree, 360.0 * kDegree},
              {-150.0 * kDegree, 150.0 * kDegree, 672.0 * kDegree, 672.0 * kDegree},
              {0.0, 210.0, 1100.0, 1100.0},
              {-360.0 * kDegree, 360.0 * kDegree, 1200.0 * kDegree, 1200.0 * kDegree}}} {}

Robot::Robot(RobotConfig config) : Driver(dialect_), config_(std::move(config)) {
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "Adept Cobra 600, C40";
}

std::optional<fvp::Joints> Robot::joints() const {
  return where_ ? std::optional(fvp::joints_of(*where_)) : std::nullopt;
}

void Robot::refuse(std::int32_t code, std::string text, Effects& fx) {
  Result r;
  r.outcome = Outcome::kRefused;
  r.code = code;
  r.text = std::move(text);
  fx.events.emplace_back(std::move(r));
}

void Robot::finish(Result result, Effects& fx) {
  op_ = Op::kNone;
  launched_ = false;
  ending_.clear();
  ending_code_ = kNoCode;
  way_.clear();
  fx.events.emplace_back(std::move(result));
}

void Robot::add_path(std::int64_t path, double tick_s, int axes, std::span<const double> positions,
                     std::int64_t now_us, Effects& fx) {
  if (!paths_.contains(path)) {
    Kept kept;
    kept.refusal = broken_limit(config_, tick_s, axes, positions);
    if (kept.refusal.empty()) {
      auto points = std::make_shared<std::vector<fvp::Counts>>(positions.size() / 4);
      for (std::size_t n = 0; n < points->size(); ++n)
        (*points)[n] = fvp::counts_of(
            {positions[4 * n], positions[4 * n + 1], positions[4 * n + 2], positions[4 * n + 3]});
      kept.points = std::move(points);
    } else {
      fault(1, kUnreachable, "robot: path " + std::to_string(path) + " is refused: " + kept.refusal, fx);
    }
    paths_.emplace(path, std::move(kept));
  }
  pump(now_us, fx);
}

bool Robot::accept(Op op, Effects& fx) {
  if (busy()) return refuse(kNoCode, "the robot is busy with another command", fx), false;
  if (op == Op::kHome && phase_ == Phase::kDead && link_.idle()) return true;  // the operator's reset
  if (phase_ != Phase::kReady)
    return refuse(kNoCode, std::string("the robot is ") + name(state()), fx), false;
  if ((op == Op::kRun || op == Op::kMove) && !(status_.power && status_.calibrated))
    return refuse(kLimit, status_.power ? "the robot is not calibrated" : "the robot has no arm power", fx),
           false;
  if (op == Op::kRun && status_.speed_percent != 100)
    return refuse(kTimeSlip, "monitor SPEED is " + std::to_string(status_.speed_percent) + ", not 100", fx),
           false;
  return true;
}

const Robot::Kept* Robot::runnable(const PathPart& part, Effects& fx) {
  const std::string which = "path " + std::to_string(part.path);
  const auto at = paths_.find(part.path);
  if (at == paths_.end()) return refuse(kNoCode, which + " has not been received", fx), nullptr;
  if (!at->second.refusal.empty())
    return refuse(kUnreachable, which + ": " + at->second.refusal, fx), nullptr;
  const auto n = std::int64_t(at->second.points->size());
  const std::int64_t last = part.to == 0 ? n - 1 : part.to;
  if (part.from < 0 || last >= n || last <= part.from)
    return refuse(kLimit,
                  which + ": samples " + std::to_string(part.from) + " to " + std::to_string(last) +
                      " are not within its " + std::to_string(n),
                  fx),
           nullptr;
  if (last - part.from + 1 > fvp::kMostPoints)
    return refuse(kLimit,
                  which + ": " + std::to_string(last - part.from + 1) + " points are more than the robot's " +
                      std::to_string(fvp::kMostPoints) + " (131.072 s)",
                  fx),
           nullptr;
  part_ = {part.path, part.from, std::int32_t(last)};
  part_points_ = std::size_t(last - part.from + 1);
  first_point_ = (*at->second.points)[std::size_t(part.from)];
  last_point_ = (*at->second.points)[std::size_t(last)];
  return &at->second;
}

void Robot::load(const PathPart& part, std::int64_t now_us, Effects& fx) {
  if (accept(Op::kLoad, fx) && runnable(part, fx)) {
    op_ = Op::kLoad;
    phase_ = Phase::kLoading;
    last_path_ = part.path;
  }
  pump(now_us, fx);
}

void Robot::run(const PathPart& part, int signals, std::int64_t now_us, Effects& fx) {
  const bool deposits = signals & (kSignalValveA | kSignalValveB);
  if (accept(Op::kRun, fx) && runnable(part, fx)) {
    if (spent_.contains(part_)) {
      refuse(kNoCode, "path " + std::to_string(part.path) + " was started before and is never run again", fx);
    } else {
      op_ = Op::kRun;
      signals_ = signals;
      path_over_ = false;
      last_path_ = part.path;
      if (deposits) forget_before(part.path);
      phase_ = Phase::kLoading;
      set_state(DriverState::kStaged, "path " + std::to_string(part.path), fx);
    }
  }
  pump(now_us, fx);
}

// Paths are printed in the order of their numbers: what lies before one that deposits is over.
void Robot::forget_before(std::int64_t path) {
  paths_.erase(paths_.begin(), paths_.lower_bound(path));
  spent_.erase(spent_.begin(), spent_.lower_bound(PathPart{path, 0, 0}));
}

void Robot::move_to(const fvp::Joints& target, int percent, std::int64_t now_us, Effects& fx) {
  if (accept(Op::kMove, fx)) {
    std::string why;
    for (std::size_t j = 0; j < 4; ++j)
      if (!(target[j] >= config_.limits[j].low && target[j] <= config_.limits[j].high))
        why = "J" + std::to_string(j + 1) + " = " + joint_text(j, target[j]) + " is outside [" +
              joint_text(j, config_.limits[j].low) + ", " + joint_text(j, config_.limits[j].high) + "]";
    if (percent < 0 || percent > 100)
      why = "a speed of " + std::to_string(percent) + " % is outside [0, 100]";
    if (!where_) why = "where the robot stands is not known";
    if (!why.empty()) {
      refuse(kUnreachable, why, fx);
    } else {
      op_ = Op::kMove;
      phase_ = Phase::kMoving;
      plan_way(fvp::counts_of(target), percent == 0 ? config_.approach_percent : percent);
      set_state(DriverState::kActive, "moving", fx);
    }
  }
  pump(now_us, fx);
}

void Robot::decline(const std::string& why, std::int64_t now_us, Effects& fx) {
  refuse(kUnreachable, why, fx);
  pump(now_us, fx);
}

void Robot::home(std::int64_t now_us, Effects& fx) {
  if (accept(Op::kHome, fx)) {
    op_ = Op::kHome;
    phase_ = Phase::kHoming;
    step_ = 0;
    set_state(DriverState::kActive, "power and calibration", fx);
  }
  pump(now_us, fx);
}

void Robot::drop(std::int64_t path, std::int64_t now_us, Effects& fx) {
  if (busy()) {
    refuse(kNoCode, "the robot is busy with another command", fx);
  } else {
    paths_.erase(path);  // its slot is freed when another path needs it
    fx.events.emplace_back(Result{});
  }
  pump(now_us, fx);
}

}  // namespace firn::drivers
