#include "drivers/laser_point/laser_point.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace firn::drivers {
namespace {

constexpr std::int64_t kMode_us = 3'000'000;  // Q0 and R0 take their time
constexpr int kStatusError = 1, kMaxDumps = 3;
constexpr std::int32_t kAny = -1;  // program

std::string command_of(const Request& r) { return "'" + std::string(r.text().substr(0, r.size - 1u)) + "'"; }

std::string_view line_of(std::span<const std::byte> frame) { return text_of(frame.first(frame.size() - 1)); }

std::string padded(int value) {
  std::string digits = std::to_string(value);
  return std::string(5 - std::min<std::size_t>(5, digits.size()), '0') + digits;
}

}  // namespace

LaserPoint::LaserPoint(LaserPointOptions config) : LaserPointDriver(dialect_), config_(std::move(config)) {
  check_options("laser_point", kLaserPointConfig, config_);
  check_options("laser_point", kLaserPointDialect, config_.dialect, "dialect.");
  dialect_.table = config_.dialect;
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "Keyence LK-G3001P";
  const auto* at = std::find(std::begin(lkg::kSampling_us), std::end(lkg::kSampling_us), config_.sampling_us);
  if (at == std::end(lkg::kSampling_us))
    throw std::invalid_argument("laser_point: sampling_us = " + std::to_string(config_.sampling_us) +
                                " is none of 20, 50, 100, 200, 500, 1000");
  sampling_code_ = int(at - std::begin(lkg::kSampling_us));
}

// Its program is a setting: only the model tells who it is.
void LaserPoint::service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
                         Effects& fx) {
  if (verb != "serial") return Driver::service(verb, values, now_us, fx);
  fx.events.emplace_back(
      Result{Outcome::kDone, -1, 0, 0, 0, kNoCode, identity_.substr(0, identity_.find(','))});
}

void LaserPoint::push(std::string_view command, Repeat repeat, Tag tag, std::int64_t reply_us) {
  link_.push(lkg::request(command, repeat, tag, reply_us));
}

// @param wanted the program that it must be in by now, or kAny
void LaserPoint::push_selected(std::int32_t wanted) {
  Request r = lkg::request(config_.dialect.selected, Repeat::kRead, kProgram, 0);
  r.argument = wanted;
  link_.push(r);
}

void LaserPoint::push_mode(const std::string& command) { push(command, Repeat::kSetup, kMode, kMode_us); }

void LaserPoint::refuse(std::int32_t code, std::string text, Effects& fx) {
  fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, std::move(text)});
}

void LaserPoint::finish(Outcome outcome, std::int64_t counted, std::int32_t code, std::string text,
                        Effects& fx) {
  op_ = Op::kNone;
  ending_.clear();
  ending_code_ = kNoCode;
  fx.events.emplace_back(Result{outcome, counted, expected_, 0, 0, code, std::move(text)});
}

bool LaserPoint::accept(bool armed_too, Effects& fx) {
  if (busy()) {
    refuse(kNoCode, "the laser is busy with another command", fx);
    return false;
  }
  if (phase_ != Phase::kReady && !(armed_too && phase_ == Phase::kArmed)) {
    refuse(kNoCode, std::string("the laser is ") + standing(), fx);
    return false;
  }
  return true;
}

void LaserPoint::arm(int material, int samples, double period_s, std::int64_t now_us, Effects& fx) {
  const double cycle = period_s * 1e6 / config_.sampling_us;
  const int code = std::abs(cycle) < 1e6 ? lkg::cycle_code(int(std::lround(cycle))) : -1;
  if (accept(true, fx)) {
    if (material < 0 || material > 1) {
      refuse(kLimit, "material " + std::to_string(material) + " is neither 0 nor 1", fx);
    } else if (samples < 1 || samples > config_.dialect.most_stored) {
      refuse(kLimit,
             std::to_string(samples) + " samples are outside [1, " +
                 std::to_string(config_.dialect.most_stored) + "]",
             fx);
    } else if (code < 0 || std::abs(cycle - std::round(cycle)) > 1e-6) {
      refuse(kLimit,
             "a period of " + std::to_string(period_s) + " s is none of 1, 2, 5, 10 ... times " +
                 std::to_string(config_.sampling_us) + " us",
             fx);
    } else {
      op_ = Op::kArm;
      material_ = material;
      expected_ = samples;
      period_s_ = period_s;
      cycle_ = code;
      phase_ = Phase::kSetting;
      if (in_force_ != InForce{material, code}) push_settings();
      set_state(DeviceState::kStaged, "settings of material " + std::to_string(material), fx);
    }
  }
  pump(now_us, fx);
}

// Between Q0 and R0 nothing is measured: R0 follows whatever happens between them.
void LaserPoint::push_settings() {
  const lkg::Table& t = config_.dialect;
  in_force_.reset();
  const int program = material_ == 0 ? config_.program_part : config_.program_scaffold;
  const int surface = material_ == 0 ? config_.surface_part : config_.surface_scaffold;
  push(t.select + "," + std::to_string(program), Repeat::kSetup);
  push_selected(program);
  push_mode(t.enter);
  push(t.sampling + std::to_string(sampling_code_), Repeat::kSetup);
  push(t.averaging + std::to_string(config_.averaging), Repeat::kSetup);
  push(t.material + std::to_string(surface), Repeat::kSetup);
  push(t.storage + padded(t.most_stored) + "," + std::to_string(cycle_), Repeat::kSetup);
  push_mode(t.leave);
}

void LaserPoint::collect(std::int64_t now_us, Effects& fx) {
  if (accept(true, fx)) {
    if (!storing_) {
      refuse(kNoCode, "nothing was armed", fx);
    } else {
      op_ = Op::kCollect;
      phase_ = Phase::kCollecting;
      dumps_ = 0;
      push(config_.dialect.stop, Repeat::kSetup);
      push(config_.dialect.stored, Repeat::kRead, kStored);
    }
  }
  pump(now_us, fx);
}

void LaserPoint::reading(std::int64_t now_us, Effects& fx) {
  if (accept(false, fx)) {
    op_ = Op::kReading;
    phase_ = Phase::kReading;
    expected_ = 1;
    push(config_.dialect.measure, Repeat::kRead, kValue);
  }
  pump(now_us, fx);
}

void LaserPoint::ask_dump() {
  ++dumps_;
  const double dump_s = double(stored_) * config_.dialect.value_bytes * config_.dialect.byte_s;
  push(config_.dialect.dump, Repeat::kRead, kDump, std::int64_t((1.0 + 1.2 * dump_s) * 1e6));
}

void LaserPoint::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kIdentifying;
  in_force_.reset();
  push_mode(config_.dialect.leave);  // it may have been left in communication mode, where it does not measure
  push_selected(kAny);
}

void LaserPoint::stop(std::int64_t, Effects& fx) {  // it moves, fires and lights nothing that could harm
  if (phase_ == Phase::kDown || phase_ == Phase::kIdentifying) return;
  link_.clear_queue();
  if (!measuring_ || phase_ == Phase::kSetting) {
    in_force_.reset();
    push_mode(config_.dialect.leave);
  }
  if (busy()) finish(Outcome::kNone, -1, kNoCode, "safe stop", fx);
  phase_ = Phase::kReady;
  set_state(DeviceState::kSafe, "stopped", fx);
}

void LaserPoint::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (busy() || phase_ == Phase::kArmed)
    fault(Severity::kWarning, kLinkLost, "laser_point: link lost while in use", fx);
  if (busy() && ending_.empty()) {
    ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  }
  phase_ = Phase::kDown;
  measuring_ = true;  // unknown: a connection begins with R0
}

void LaserPoint::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  reconnect(now_us, fx, "no good reply to " + command_of(request) + not_understood());
}

void LaserPoint::unsolicited(std::span<const std::byte> frame, std::int64_t, Effects&) {
  timing_values_ += line_of(frame).starts_with("TG,");
}

void LaserPoint::refused(const Request& request, int error, std::int64_t now_us, Effects& fx) {
  if (request.tag == kMode && error == kStatusError) {  // it is in that mode already
    measuring_ = request.text().starts_with(config_.dialect.leave);
    return;
  }
  give_up(request, "the laser answers " + command_of(request) + " with error " + std::to_string(error),
          now_us, fx);
}

void LaserPoint::give_up(const Request& request, const std::string& why, std::int64_t now_us, Effects& fx) {
  fault(Severity::kWarning, kCommandRejected, "laser_point: " + why, fx);
  if (request.tag == kMode) return reconnect(now_us, fx, why);
  if (!busy()) return;
  link_.clear_queue();
  in_force_.reset();
  push_mode(config_.dialect.leave);
  const bool collecting = op_ == Op::kCollect;
  phase_ = Phase::kReady;
  set_state(DeviceState::kSafe, why, fx);
  finish(collecting ? Outcome::kFailed : Outcome::kNone, -1, kCommandRejected, why, fx);
}

void LaserPoint::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                       Effects& fx) {
  const lkg::Reply r = lkg::parse(line_of(frame), request.text().substr(0, request.size - 1u));
  if (r.kind == lkg::Reply::Kind::kError) return refused(request, r.error, now_us, fx);
  switch (request.tag) {
    case kMode:
      measuring_ = request.text().starts_with(config_.dialect.leave);
      return;
    case kProgram:
      if (phase_ == Phase::kSetting && request.argument != kAny && r.rest != std::to_string(request.argument))
        return give_up(
            request,
            "the laser is in program " + std::string(r.rest) + ", not in " + std::to_string(request.argument),
            now_us, fx);
      identity_ = "Keyence LK-G3001P, program " + std::string(r.rest);
      return;
    case kStored: {
      if (op_ != Op::kCollect) return;  // a stop came between
      const auto s = lkg::parse_stored(r.rest);
      if (!s || s->values > config_.dialect.most_stored)
        return give_up(request, "the laser says that '" + std::string(r.rest) + "' is what it has stored",
                       now_us, fx);
      stored_ = s->values;
      mm_.clear();
      if (stored_ > 0) ask_dump();
      return;
    }
    case kDump: {
      if (op_ != Op::kCollect) return;
      const auto damaged = lkg::parse_dump(r.rest, mm_, value_chars());
      if (damaged && mm_.size() == std::size_t(stored_)) {
        fx.measured<LaserPoint>(Samples{material_, expected_, *damaged, period_s_, mm_});
        if (*damaged > 0)
          fault(Severity::kWarning, kInstrument,
                "laser_point: " + std::to_string(*damaged) + " values of a dump are damaged", fx);
        return;
      }
      fault(Severity::kNotice, kInstrument,
            "laser_point: a dump of " + std::to_string(mm_.size()) + " values, " + std::to_string(stored_) +
                " stored",
            fx);
      mm_.clear();
      if (dumps_ < kMaxDumps) return ask_dump();
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "dump unreadable", fx);
      return finish(Outcome::kFailed, -1, kInstrument, "the dump cannot be read", fx);
    }
    case kValue: {
      if (op_ != Op::kReading) return;
      const lkg::Value v = lkg::parse_value(r.rest, value_chars());
      fx.measured<LaserPoint>(Samples{material_, 1, v.status == lkg::Status::kDamaged, 0.0, {float(v.mm)}});
      return;
    }
    default:
      return;
  }
}

bool LaserPoint::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kIdentifying:
      identified();
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "measuring", fx);
      if (busy())
        finish(op_ == Op::kCollect ? Outcome::kFailed : Outcome::kNone, -1, ending_code_, ending_, fx);
      return false;
    case Phase::kSetting:
      in_force_ = InForce{material_, cycle_};
      phase_ = Phase::kArming;
      push(config_.dialect.clear, Repeat::kSetup);
      push(config_.dialect.start, Repeat::kSetup);
      storing_ = true;
      return true;
    case Phase::kArming:
      phase_ = Phase::kArmed;
      set_state(DeviceState::kArmed, "storage waits for the signal", fx);
      finish(Outcome::kReady, -1, kNoCode, {}, fx);
      return false;
    case Phase::kCollecting:
      phase_ = Phase::kReady;
      storing_ = false;
      if (stored_ == 0) fx.measured<LaserPoint>(Samples{material_, expected_, 0, period_s_, {}});
      set_state(DeviceState::kSafe, "collected", fx);
      finish(Outcome::kDone, stored_, kNoCode, {}, fx);
      return false;
    case Phase::kReading:
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "read", fx);
      finish(Outcome::kDone, 1, kNoCode, {}, fx);
      return false;
    case Phase::kReady:
      if (now_us - link_.last_sent_us() < std::int64_t(config_.poll_idle_s * 1e6)) return false;
      push_selected(kAny);
      return true;
    default:
      return false;
  }
}

std::int64_t LaserPoint::device_wake_us() const {
  if (!link_.idle() || phase_ != Phase::kReady) return 0;
  return link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6);
}

}  // namespace firn::drivers
