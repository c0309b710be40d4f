// Jet: orders of a person, beside a print (firn device).
#include <cmath>

#include "drivers/jet/jet.h"

namespace firn::drivers {

using jetdrive::Command;

namespace {

constexpr double kMostBurst_s = 1.0;  // droplets of SOFTTRIGGER cannot be called back

Request number(Command command, int value, int bytes, Repeat repeat = Repeat::kSetup) {
  const std::uint8_t data[2] = {std::uint8_t(unsigned(value) >> 8), std::uint8_t(value)};
  return jetdrive::frame(command, std::span(data).last(std::size_t(bytes)), repeat);
}

Request soft_trigger() { return jetdrive::frame(Command::kSoftTrigger, {}, Repeat::kNever); }

std::string beyond(const char* what, double value, double limit, const char* unit) {
  char text[120];
  std::snprintf(text, sizeof text, "%s %g is outside (0, %g] %s", what, value, limit, unit);
  return text;
}

}  // namespace

void Jet::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  const JetDialect& d = config_.dialect;
  Service s{std::string(verb), {}, 0, {}, [this](const Request&, std::span<const std::byte> frame) {
              return dialect_.parse(frame).acknowledged ? std::optional<std::string>("") : std::nullopt;
            }};
  if (verb == "fire" && v.size() == 1) {
    const double most = std::min(65535.0, config_.max_rate_hz * kMostBurst_s);
    if (!whole_within(v[0], 1, most))
      return refuse(kJetLimit, beyond("a number of droplets of", v[0], most, "(one second's)"), fx);
    s.begin = {number(Command::kDrops, int(v[0]), 2), soft_trigger()};
    s.hold_us = std::int64_t(v[0] / config_.max_rate_hz * 1e6) + 1;
    s.end = {number(Command::kDrops, config_.drops_per_trigger, 2)};
  } else if (verb == "continuous" && v.size() == 1) {
    if (!(v[0] > 0.0 && v[0] <= d.most_continuous_s))
      return refuse(kJetLimit, beyond("jetting for", v[0], d.most_continuous_s, "s"), fx);
    s.begin = {number(Command::kContinuous, 1, 1, Repeat::kNever), soft_trigger()};
    s.hold_us = std::int64_t(v[0] * 1e6);
    s.end = {number(Command::kContinuous, 0, 1)};
  } else if (verb == "strobe" && v.size() == 2) {
    if (!whole_within(v[0], 1, 255))
      return refuse(kLimit, beyond("a strobe divider of", v[0], 255, "(whole)"), fx);
    if (!whole_within(v[1], 0, 65535))
      return refuse(kLimit, beyond("a strobe delay of", v[1], 65535, "us"), fx);
    const std::uint8_t delay[3] = {0x01, std::uint8_t(unsigned(v[1]) >> 8), std::uint8_t(unsigned(v[1]))};
    s.begin = {number(Command::kStrobeDivider, int(v[0]), 1), number(Command::kStrobeEnable, 1, 1),
               jetdrive::frame(Command::kStrobeDelay, delay, Repeat::kSetup)};
  } else if (verb == "waveform" && v.size() == 4) {
    if (v[0] != std::round(v[0]) || v[1] != std::round(v[1]) || std::abs(v[0]) > kMaxJet_v ||
        std::abs(v[1]) > kMaxJet_v)
      return refuse(kJetLimit, "the JetDrive takes whole volts within +-100 V", fx);
    jetdrive::Waveform w = waveform_;
    w.dwell_v = int(v[0]);
    w.echo_v = int(v[1]);
    w.dwell_us = v[2];
    w.echo_us = v[3];
    return begin_waveform(w, fx);
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
