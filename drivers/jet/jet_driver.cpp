#include "drivers/jet/jet_driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "drivers/jet/jetdrive.h"

namespace firn::drivers {
namespace {

constexpr double kMaxBurst_s = 1.0;  // droplets of a burst cannot be called back
constexpr double kMost16 = 65535.0;

std::string beyond(const char* what, double value, double limit, const char* unit) {
  char text[120];
  std::snprintf(text, sizeof text, "%s %g is outside (0, %g] %s", what, value, limit, unit);
  return text;
}

}  // namespace

std::string unarmable(const JetConfig& config) {
  const JetTraits& t = traits_of(config.kind);
  if (!t.trigger_by_words || !config.trigger_on.empty()) return {};
  return "the known commands of " + std::string(t.instrument) +
         " name no external trigger, so that the stage cannot fire it: jet.trigger_on and jet.trigger_off "
         "take the texts of the unit's manual [P]";
}

std::string small_refusal(const JetConfig& config) {
  const JetTraits& t = traits_of(config.kind);
  if (!t.two_sizes) return std::string(t.instrument) + " has one size of droplet";
  return refusal_of({config.small_dwell_v, config.small_echo_v, config.dwell_us, config.echo_us}, config);
}

bool answers_probe(const Dialect& dialect, std::string_view heard) {
  const Request asked = dialect.probe();
  return !heard.empty() && dialect.frame(std::as_bytes(std::span(heard)), &asked).kind == Frame::Kind::kReply;
}

JetDriver::JetDriver(const Dialect& dialect, JetKind kind, JetOptions config)
    : JetInterface(dialect), config_(std::move(config)) {
  config_.kind = kind;
  check_options("jet", kJetConfig, config_);
}

void JetDriver::jet(std::int64_t now_us, Effects& fx) {
  refuse_service(kNoCode, std::string(traits_of(config_.kind).instrument) + " does not jet for the camera",
                 fx);
  pump(now_us, fx);
}

bool JetDriver::accepts(bool ready, Effects& fx) const {
  if (!busy() && ready) return true;
  refuse_service(
      kNoCode, busy() ? "the jet is busy with another command" : std::string("the jet is ") + standing(), fx);
  return false;
}

void JetDriver::arm(std::int64_t expected, bool small, std::int64_t now_us, Effects& fx) {
  if (std::string why = unarmable(config_); !why.empty()) {
    refuse_service(kInstrument, std::move(why), fx);
  } else if (std::string beyond = small ? small_refusal(config_) : std::string(); !beyond.empty()) {
    refuse_service(kJetLimit, std::move(beyond), fx);
  } else if (accepts(ready(), fx)) {
    op_ = Op::kArm;
    expected_ = expected;
    not_armed_.clear();
    armed_until_us_ = 0;
    may_fire_ = true;
    start_arming(small);
    set_state(DeviceState::kStaged, "arming", fx);
  }
  pump(now_us, fx);
}

void JetDriver::disarm(std::int64_t now_us, Effects& fx) {
  if (accepts(at_rest(), fx)) {
    op_ = Op::kDisarm;
    start_disarming(now_us, fx);
  }
  pump(now_us, fx);
}

void JetDriver::armed(std::string_view text, Effects& fx) {
  set_state(DeviceState::kArmed, text, fx);
  finish(Outcome::kReady, kNoCode, {}, fx);
}

void JetDriver::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  if (op_ == Op::kNone) return;
  op_ = Op::kNone;
  Result r{outcome, -1, expected_, 0, 0, code, std::move(text)};
  if (outcome == Outcome::kUnknown) r.unknown_to = expected_;
  r.until_us = armed_until_us_;
  fx.events.emplace_back(std::move(r));
}

void JetDriver::finish_pass(std::string text, Effects& fx) {
  if (not_armed_.empty()) return finish(Outcome::kDone, kNoCode, std::move(text), fx);
  finish(Outcome::kUnknown, kInstrument, "the jet was not seen armed during the whole pass: " + not_armed_,
         fx);
}

// The stage may go on triggering for a moment: its driver is another process.
void JetDriver::disarmed_before_its_time(std::int64_t now_us) {
  if (may_fire_ && op_ != Op::kDisarm && armed_until_us_ == 0) armed_until_us_ = now_us;
}

void JetDriver::stop(std::int64_t now_us, Effects& fx) {
  disarmed_before_its_time(now_us);
  cease(now_us, fx);
}

void JetDriver::give_up(std::int32_t code, const std::string& why, std::int64_t now_us, Effects& fx) {
  fault(Severity::kWarning, code, "jet: " + why, fx);
  reconnect(now_us, fx, why);
}

std::string refusal_of(const JetPulses& p, const JetConfig& config) {
  const JetTraits& t = traits_of(config.kind);
  if (!t.second_pulse && (p.echo_v != 0.0 || p.echo_us != 0.0))
    return std::string(t.instrument) + " has one pulse: ECHO and ECHO_US are 0";
  if (p.dwell_v != std::round(p.dwell_v) || p.echo_v != std::round(p.echo_v) || p.dwell_v < t.min_v ||
      std::abs(p.dwell_v) > kMaxJet_v || std::abs(p.echo_v) > kMaxJet_v) {
    char text[120];
    std::snprintf(text, sizeof text, "the jet takes whole volts within %g to %g V", t.min_v, kMaxJet_v);
    return text;
  }
  if (t.step_us == 1.0 && !whole_within(p.dwell_us, 1, kMaxJet_us))
    return "the jet takes whole microseconds from 1";
  return jetdrive::waveform_refusal({0, int(p.dwell_v), int(p.echo_v), 0.0, p.dwell_us, 0.0, p.echo_us, 0.0},
                                    config.dialect)
      .text;
}

void JetDriver::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  const JetTraits& t = traits_of(config_.kind);
  const double rate_hz = config_.max_rate_hz;
  Service s{std::string(verb), {}, 0, {}, [this](const Request& r, std::span<const std::byte> frame) {
              return obeyed(r, frame) ? std::optional<std::string>("") : std::nullopt;
            }};
  if (verb == "fire" && v.size() == 1) {
    const double most = std::min(kMost16, rate_hz * kMaxBurst_s);
    if (!whole_within(v[0], 1, most))
      return refuse_service(kJetLimit, beyond("a number of droplets of", v[0], most, "(one second's)"), fx);
    s.hold_us = std::int64_t(v[0] / rate_hz * 1e6) + 1;
    fire(int(v[0]), s);
  } else if (verb == "continuous" && v.size() == 1) {
    const double max_s = std::min(config_.dialect.most_continuous_s, t.most_drops / rate_hz);
    if (!(v[0] > 0.0 && v[0] <= max_s))
      return refuse_service(kJetLimit, beyond("jetting for", v[0], max_s, "s"), fx);
    s.hold_us = std::int64_t(v[0] * 1e6);
    jet_for(v[0], s);
  } else if (verb == "strobe" && v.size() == 2) {
    if (!whole_within(v[0], 1, t.max_divider))
      return refuse_service(kLimit, beyond("a strobe divider of", v[0], t.max_divider, "(whole)"), fx);
    if (!whole_within(v[1], 0, kMost16))
      return refuse_service(kLimit, beyond("a strobe delay of", v[1], kMost16, "us"), fx);
    strobe(int(v[0]), int(v[1]), s);
  } else if (verb == "waveform" && v.size() == 4) {
    const JetPulses wanted{v[0], v[1], v[2], v[3]};
    if (std::string why = refusal_of(wanted, config_); !why.empty())
      return refuse_service(kJetLimit, std::move(why), fx);
    return pulses(wanted, std::move(s), fx);
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
