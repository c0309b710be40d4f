#include "drivers/valve/valve.h"

#include <algorithm>
#include <cmath>

namespace firn::drivers {

using fvb::Type;

namespace {

// Why a list is not for this valve and its microcontroller; empty = it is.
std::string broken_limit(const ValveConfig& c, double tick_s, double pulse_s,
                         std::span<const std::int32_t> ticks) {
  const double tick_us = std::round(tick_s * 1e6), pulse_us = std::round(pulse_s * 1e6);
  if (!(tick_us >= 1.0 && tick_us <= 65'535.0)) return "a tick of " + std::to_string(tick_s) + " s";
  if (!(pulse_us >= fvb::kMinPulse_us && pulse_us <= 65'535.0))
    return "a pulse of " + std::to_string(pulse_s * 1e3) + " ms is outside [0.5, 65.535] ms";
  if (ticks.empty() || ticks.size() > fvb::kMostEntries)
    return std::to_string(ticks.size()) + " pulses are outside [1, " + std::to_string(fvb::kMostEntries) +
           "]";
  for (std::size_t n = 0; n < ticks.size(); ++n) {
    if (ticks[n] < 0 || ticks[n] > 65'535)
      return "pulse " + std::to_string(n) + ": tick " + std::to_string(ticks[n]) + " is outside [0, 65535]";
    if (n == 0) continue;
    const double gap_us = (double(ticks[n]) - double(ticks[n - 1])) * tick_us;
    if (gap_us < pulse_us + c.guard_us)
      return "pulse " + std::to_string(n) + " begins " + std::to_string(std::int64_t(gap_us)) +
             " us after the one before, less than pulse and guard of " +
             std::to_string(std::int64_t(pulse_us) + c.guard_us) + " us";
  }
  return {};
}

}  // namespace

std::string ListName::text() const {
  return "list " + std::to_string(list) + " of path " + std::to_string(path);
}

Valve::Valve(ValveConfig config)
    : Driver(dialect_), name_(config.valve == 2 ? "valve_b" : "valve_a"), config_(config) {
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "FVB/1 valve controller";
}

void Valve::refuse(std::int32_t code, std::string text, Effects& fx) {
  fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, std::move(text)});
}

void Valve::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  op_ = Op::kNone;
  ending_.clear();
  ending_code_ = kNoCode;
  fx.events.emplace_back(Result{outcome, -1, 0, 0, 0, code, std::move(text)});
}

void Valve::add_list(const ListName& name, double tick_s, double pulse_s, std::span<const std::int32_t> ticks,
                     std::int64_t now_us, Effects& fx) {
  if (!lists_.contains(name) && name > last_) {
    Kept kept;
    kept.refusal = broken_limit(config_, tick_s, pulse_s, ticks);
    if (kept.refusal.empty()) {
      kept.ticks = std::make_shared<const std::vector<std::uint16_t>>(ticks.begin(), ticks.end());
      kept.tick_us = std::uint16_t(std::llround(tick_s * 1e6));
      kept.pulse_us = std::uint16_t(std::llround(pulse_s * 1e6));
    } else {
      fault(1, kLimit, name_ + ": " + name.text() + " is refused: " + kept.refusal, fx);
    }
    lists_.emplace(name, std::move(kept));
  }
  pump(now_us, fx);
}

bool Valve::accept(std::initializer_list<Phase> phases, Effects& fx) {
  if (busy()) return refuse(kNoCode, name_ + " is busy with another command", fx), false;
  if (std::find(phases.begin(), phases.end(), phase_) == phases.end())
    return refuse(kNoCode, name_ + " is " + drivers::name(state()), fx), false;
  return true;
}

const Valve::Kept* Valve::usable(const ListName& name, Effects& fx) {
  const auto at = lists_.find(name);
  if (at == lists_.end())
    return refuse(kNoCode,
                  name.text() + (name <= last_ ? " was armed before and is never armed again"
                                               : " has not been received"),
                  fx),
           nullptr;
  if (!at->second.refusal.empty())
    return refuse(kLimit, name.text() + ": " + at->second.refusal, fx), nullptr;
  return &at->second;
}

void Valve::load(const ListName& name, std::int64_t now_us, Effects& fx) {
  if (accept({Phase::kReady}, fx) && usable(name, fx)) {
    op_ = Op::kLoad;
    wanted_ = name;
    tries_ = 0;
    phase_ = Phase::kLoading;
  }
  pump(now_us, fx);
}

void Valve::arm(const ListName& name, std::int64_t now_us, Effects& fx) {
  if (accept({Phase::kReady}, fx)) {
    if (const Kept* kept = usable(name, fx)) {
      if (!holds(name)) {
        refuse(kNoCode, name.text() + " is not loaded", fx);
      } else {
        op_ = Op::kArm;
        phase_ = Phase::kArming;
        wanted_ = name;
        const auto last_us = std::int64_t(kept->ticks->back()) * kept->tick_us + kept->pulse_us;
        armed_ = Armed{name, id_, std::int64_t(kept->ticks->size()), last_us, 0, false, false};
        link_.push(fvb::number32(Type::kArm, seq(), std::uint32_t(std::llround(config_.arm_wait_s * 1e3)),
                                 Repeat::kNever));
        set_state(DriverState::kStaged, "arming " + name.text(), fx);
      }
    }
  }
  pump(now_us, fx);
}

void Valve::disarm(std::int64_t now_us, Effects& fx) {
  if (accept({Phase::kReady, Phase::kArmed}, fx)) {
    if (!armed_) {
      refuse(kNoCode, name_ + " was not armed", fx);
    } else {
      op_ = Op::kDisarm;
      if (armed_->over) {
        tell_count(kNoCode, {}, fx);
      } else {
        phase_ = Phase::kEnding;
        give_up_us_ = 0;
        ask_status();
      }
    }
  }
  pump(now_us, fx);
}

// The answer of a disarm, and of an arm that was cut short.
void Valve::tell_count(std::int32_t code, std::string text, Effects& fx) {
  const Armed a = *armed_;
  const bool all = a.fired == a.entries;
  Result r{all           ? Outcome::kDone
           : a.fired > 0 ? Outcome::kFailed
                         : Outcome::kNone,
           a.fired,
           a.entries,
           0,
           0,
           code,
           std::move(text)};
  if (a.doubt && !all) {
    r.outcome = Outcome::kUnknown;
    r.unknown_from = a.fired;
    r.unknown_to = a.entries;
    r.code = kValveLost;
  }
  armed_.reset();
  op_ = Op::kNone;
  ending_.clear();
  ending_code_ = kNoCode;
  fx.events.emplace_back(std::move(r));
}

}  // namespace firn::drivers
