#include "drivers/stage/script_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace firn::drivers {
namespace {

constexpr double kNoPlace = std::numeric_limits<double>::quiet_NaN();

}  // namespace

ScriptStage::ScriptStage(ScriptOptions script, StageOptions config)
    : ScriptDriver(std::move(script), {"position", "move"}, std::move(config)) {
  position_mm_.fill(kNoPlace);
}

bool ScriptStage::lacks(const char* method, const char* what, Effects& fx) {
  if (has(method)) return false;
  refuse(kInstrument, script().class_name + " has no method " + method + "(): it " + what, fx);
  return true;
}

void ScriptStage::begin(Op op, const char* text, std::int64_t now_us, Effects& fx) {
  op_ = op;
  run_ = 0;
  before_ = 0;
  counts_ = true;
  launched_ = false;
  begin_command();
  acts();
  set_state(DeviceState::kActive, text, fx);
  if (op == Op::kHome) return call_for(config_.home_timeout_s, kHome, "home", {}, now_us);
  call(kPosition, "position", {}, now_us);  // how far it is tells how long a move may take
}

void ScriptStage::run_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s,
                           std::int64_t now_us, Effects& fx, double lead_mm, const Placement& placement) {
  PassPlan plan;
  if (accepts(fx) && !lacks("fire", "cannot trigger a jet", fx)) {
    if (auto why = plan_pass(pattern, pass, z_mm, speed_mm_s, lead_mm, placement, plan)) {
      refuse(why->code, std::move(why->text), fx);
    } else if (plan.runs.empty()) {
      fx.events.emplace_back(Result{Outcome::kDone, 0, 0, 0, 0, kNoCode, "no droplets in this pass"});
    } else {
      runs_ = std::move(plan.runs);
      expected_ = plan.expected;
      target_mm_ = {kNoPlace, kNoPlace, z_mm};
      begin(Op::kPass, "raster pass", now_us, fx);
    }
  }
  pump(now_us, fx);
}

void ScriptStage::scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
                       std::int64_t now_us, Effects& fx) {
  ScanPlan plan;
  if (accepts(fx) && !lacks("scan", "cannot trigger a profiler", fx)) {
    if (auto why = plan_scan(x_mm, y_mm, z_mm, pitch_mm, rows, speed_mm_s, plan)) {
      refuse(why->code, std::move(why->text), fx);
    } else {
      runs_.clear();
      expected_ = rows;
      speed_mm_s_ = plan.speed_mm_s;
      pitch_mm_ = plan.pitch_mm;
      target_mm_ = {x_mm, y_mm - plan.pitch_mm, z_mm};
      begin(Op::kScan, "scan", now_us, fx);
    }
  }
  pump(now_us, fx);
}

void ScriptStage::move_to(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
                          Effects& fx) {
  const std::array<double, 3> target{x_mm, y_mm, z_mm};
  double speed = speed_mm_s;
  if (accepts(fx)) {
    if (auto why = plan_move(target, speed)) {
      refuse(why->code, std::move(why->text), fx);
    } else if (std::ranges::all_of(target, [](double mm) { return std::isnan(mm); })) {
      fx.events.emplace_back(Result{Outcome::kDone, -1, 0, 0, 0, kNoCode, "no axis to move"});
    } else {
      runs_.clear();
      expected_ = 0;
      speed_mm_s_ = speed;
      target_mm_ = target;
      begin(Op::kMove, "move", now_us, fx);
    }
  }
  pump(now_us, fx);
}

void ScriptStage::trace(StageWay, double, std::int64_t now_us, Effects& fx) {
  refuse(kInstrument, script().class_name + " follows no ways: a driver in Python prints droplets, not lines",
         fx);
  pump(now_us, fx);
}

void ScriptStage::home(std::int64_t now_us, Effects& fx) {
  if (accepts(fx) && !lacks("home", "cannot home", fx)) begin(Op::kHome, "homing", now_us, fx);
  pump(now_us, fx);
}

double ScriptStage::way_s(double from_mm, double to_mm, double speed_mm_s) const {
  const double mm = std::isnan(to_mm) || std::isnan(from_mm) ? 0.0 : std::abs(to_mm - from_mm);
  return config_.move_timeout_factor * move_time_s(mm, speed_mm_s, config_.acceleration_mm_s2) + 0.5;
}

void ScriptStage::move(const std::array<double, 3>& target_mm, double speed_mm_s, std::int64_t now_us) {
  double longest_s = 0.0;
  for (std::size_t a = 0; a < 3; ++a)
    longest_s += way_s(position_mm_[a], target_mm[a], speed_mm_s);  // axes may move one after the other
  call_for(longest_s, kMove, "move",
           {{"x_mm", {target_mm[0]}},
            {"y_mm", {target_mm[1]}},
            {"z_mm", {target_mm[2]}},
            {"speed_mm_s", {speed_mm_s}}},
           now_us);
  for (std::size_t a = 0; a < 3; ++a)
    if (!std::isnan(target_mm[a])) position_mm_[a] = target_mm[a];
}

/// The next part of the order, from a stage that stands.
void ScriptStage::go_on(std::int64_t now_us, Effects&) {
  switch (op_) {
    case Op::kPass:
      move({runs_[run_].start_x_mm, runs_[run_].y_mm, target_mm_[2]}, config_.move_speed_mm_s, now_us);
      target_mm_[2] = kNoPlace;  // it stands at its height from now on
      return;
    case Op::kScan:
      return move(target_mm_, config_.move_speed_mm_s, now_us);
    case Op::kMove:
      return move(target_mm_, speed_mm_s_, now_us);
    case Op::kHome:
    case Op::kNone:
      return;
  }
}

void ScriptStage::fire(std::int64_t now_us) {
  const RasterRun& run = runs_[run_];
  const double direction = run.end_x_mm >= run.start_x_mm ? 1.0 : -1.0;
  std::vector<double> at_mm;
  std::int64_t counts = 0;
  for (const std::int64_t increment : run.increments) {
    counts += increment;
    at_mm.push_back(run.start_x_mm + direction * double(counts) / config_.counts_per_mm);
  }
  launched_ = true;
  call_for(way_s(run.start_x_mm, run.end_x_mm, run.speed_mm_s), kFire, "fire",
           {{"y_mm", {run.y_mm}},
            {"start_x_mm", {run.start_x_mm}},
            {"end_x_mm", {run.end_x_mm}},
            {"speed_mm_s", {run.speed_mm_s}},
            {"*at_mm", std::move(at_mm)}},
           now_us);
  position_mm_[0] = run.end_x_mm;
}

void ScriptStage::start_scan(std::int64_t now_us) {
  const double start_y_mm = target_mm_[1], end_y_mm = start_y_mm + (double(expected_) + 0.5) * pitch_mm_;
  launched_ = true;
  call_for(way_s(start_y_mm, end_y_mm, speed_mm_s_), kScan, "scan",
           {{"x_mm", {target_mm_[0]}},
            {"start_y_mm", {start_y_mm}},
            {"end_y_mm", {end_y_mm}},
            {"speed_mm_s", {speed_mm_s_}},
            {"first_y_mm", {start_y_mm + pitch_mm_}},
            {"pitch_mm", {pitch_mm_}},
            {"rows", {double(expected_)}}},
           now_us);
  position_mm_[1] = end_y_mm;
}

void ScriptStage::arrived(const Line& line, std::int64_t now_us, Effects& fx) {
  const auto value = line.values.find("value");
  if (value == line.values.end() || value->second.size() != 3)
    return wrong("position", "it returns no three numbers", now_us, fx);
  std::ranges::copy(value->second, position_mm_.begin());
  go_on(now_us, fx);
}

void ScriptStage::counted(const Line& line, std::int64_t expected, std::int64_t now_us, Effects& fx) {
  launched_ = false;
  const double told = line.number("value");
  const char* method = op_ == Op::kScan ? "scan" : "fire";
  if (std::isnan(told)) {
    counts_ = false;  // the end of the move stands for the whole run
  } else if (told != double(expected)) {
    char text[120];
    std::snprintf(text, sizeof text, "%g of %lld pulses came", told, static_cast<long long>(expected));
    launched_ = true;  // which of them nobody knows
    fault(Severity::kStop, kPulseCount, blame(method, text), fx);
    return make_safe(text, kPulseCount, now_us, fx);
  }
  before_ += expected;
  if (op_ == Op::kPass && ++run_ < runs_.size()) return go_on(now_us, fx);
  end({Outcome::kDone, counts_ ? before_ : -1, expected_, 0, 0, kNoCode, ""}, fx);
}

void ScriptStage::returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
  switch (tag) {
    case kHome:
      position_mm_.fill(kNoPlace);
      return end({Outcome::kDone, -1, 0, 0, 0, kNoCode, ""}, fx);
    case kPosition:
      return arrived(line, now_us, fx);
    case kMove:
      if (op_ == Op::kPass) return fire(now_us);
      if (op_ == Op::kScan) return start_scan(now_us);
      return end({Outcome::kDone, -1, 0, 0, 0, kNoCode, ""}, fx);
    case kFire:
      return counted(line, std::int64_t(runs_[run_].increments.size()), now_us, fx);
    case kScan:
      return counted(line, expected_, now_us, fx);
    default:
      return;
  }
}

void ScriptStage::end(Result result, Effects& fx) {
  op_ = Op::kNone;
  end_acting();
  set_state(DeviceState::kSafe, "at rest", fx);
  finish(std::move(result), fx);
}

// The runs before are whole; of the one that went on any part may have been fired.
Result ScriptStage::broken_off(Outcome outcome, std::int32_t code, std::string text) {
  const std::int64_t run = op_ == Op::kPass   ? std::int64_t(runs_[run_].increments.size())
                           : op_ == Op::kScan ? expected_
                                              : 0;
  Result r{outcome, before_, expected_, 0, 0, code, std::move(text)};
  if (launched_) {
    r.outcome = Outcome::kUnknown;
    r.unknown_from = before_;
    r.unknown_to = before_ + run;
  } else if (run > 0) {  // it stood, or went to the start of its run
    r.outcome = before_ > 0 ? Outcome::kFailed : Outcome::kNone;
    r.unknown_from = r.unknown_to = before_;
  } else if (outcome == Outcome::kUnknown) {
    r.outcome = Outcome::kFailed;  // where it stands is asked before the next move
  }
  op_ = Op::kNone;
  return r;
}

}  // namespace firn::drivers
