// Microdrop: orders beside a print, of a person (firn device) or for the camera, in the words that its card
// has.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/jet/microdrop.h"

namespace firn::drivers {

using namespace microdrop;

namespace {

constexpr double kMostDrops = 65535.0, kMostStrobe_us = 65535.0;

std::string outside(const char* what, double value, double most) {
  char text[120];
  std::snprintf(text, sizeof text, "%s of %g is no whole number up to %g", what, value, most);
  return text;
}

}  // namespace

void Microdrop::jet(std::int64_t now_us, Effects& fx) {
  finish(Outcome::kRefused, kNoCode, "microdrop does not jet for the camera", fx);
  pump(now_us, fx);
}

// Drops of StartGlobal come at the frequency that was set, and SetActive(1,0) ends them.
void Microdrop::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  Service s{std::string(verb), {}, 0, {}, [](const Request& r, std::span<const std::byte> line) {
              const bool good = r.argument == kUnchecked || number_of(line) == r.argument;
              const bool asked = r.format == kNumber && r.argument == kUnchecked;
              const std::string_view text(reinterpret_cast<const char*>(line.data()), line.size());
              return !good ? std::nullopt
                           : std::optional<std::string>(asked ? text.substr(1, text.size() - 2) : "");
            }};
  const auto drops = [&](double count) {
    s.begin = {command("SetDrops(1,", count), question("GetDrops(1)", count),
               command("SetActive(1,1)", Repeat::kNever), command("StartGlobal(1)", Repeat::kNever)};
    s.hold_us = std::int64_t(count / config_.max_rate_hz * 1e6) + 1;
    s.end = {command("SetActive(1,0)"), command("SetDrops(1,1)")};
  };
  if (verb == "fire" && v.size() == 1) {
    const double most = std::min(kMostDrops, double(config_.max_rate_hz));  // those of one second
    if (!whole_within(v[0], 1, most))
      return refuse_service(kJetLimit, outside("a number of droplets", v[0], most), fx);
    drops(v[0]);
  } else if (verb == "continuous" && v.size() == 1) {
    const double most_s = std::min(config_.dialect.most_continuous_s, kMostDrops / config_.max_rate_hz);
    if (!(v[0] > 0.0 && v[0] <= most_s)) {
      char text[120];
      std::snprintf(text, sizeof text, "jetting for %g s is outside (0, %g] s: SetDrops takes 65535 at most",
                    v[0], most_s);
      return refuse_service(kJetLimit, text, fx);
    }
    drops(std::max(1.0, std::floor(v[0] * config_.max_rate_hz)));
  } else if (verb == "strobe" && v.size() == 2) {
    if (v[0] != 1.0) return refuse_service(kLimit, "a Microdrop's strobe has no divider: it is 1", fx);
    if (!whole_within(v[1], 0, kMostStrobe_us))
      return refuse_service(kLimit, outside("a strobe delay [us]", v[1], kMostStrobe_us), fx);
    s.begin = {command("SetStrobe(1,", v[1]), question("GetStrobe(1)", v[1])};
  } else if (verb == "waveform" && v.size() == 4) {
    if (v[1] != 0.0 || v[3] != 0.0)
      return refuse_service(kJetLimit, "a Microdrop has one pulse: ECHO and ECHO_US are 0", fx);
    const JetDialect& d = config_.dialect;
    if (!whole_within(v[0], 1, d.max_abs_v))
      return refuse_service(kJetLimit, outside("a voltage", v[0], d.max_abs_v), fx);
    if (!whole_within(v[2], 1, d.max_time_us))
      return refuse_service(kJetLimit, outside("a pulse [us]", v[2], d.max_time_us), fx);
    config_.dwell_v = v[0];
    config_.dwell_us = v[2];
    s.begin = {command("SetPulseVoltage(1,1,", v[0]), command("SetPulseLength(1,1,", v[2]),
               command("RefreshPulse(1)"), question("GetPulseVoltage(1,1)", v[0]),
               question("GetPulseLength(1,1)", v[2])};
  } else if (verb == "serial") {
    s.begin = {question("GetConfig(1,3)"), question("GetConfig(1,6)")};
    s.tell = [](const Request& r, std::span<const std::byte> line) {
      const bool hardware = r.text().find(",3)") != std::string_view::npos;
      return std::optional<std::string>((hardware ? "Microdrop MD-E hardware " : "software ") +
                                        std::to_string(number_of(line)));
    };
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
