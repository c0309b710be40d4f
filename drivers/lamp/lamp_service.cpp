// Lamp: orders of a person, beside a print (firn device).
#include <cmath>

#include "drivers/lamp/lamp.h"

namespace firn::drivers {

void Lamp::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  const LampDialect& d = config_.dialect;
  const auto line = [](const std::string& text, omnicure::Format format, Repeat repeat) {
    return omnicure::request(text, format, repeat, kServiceTag);
  };
  const auto told = [&d](std::string before) {
    return [&d, before = std::move(before)](const Request&,
                                            std::span<const std::byte> frame) -> std::optional<std::string> {
      const std::string_view text = omnicure::OmnicureDialect::text(frame);
      if (text.starts_with(d.error)) return std::nullopt;
      return before.empty() ? std::string() : before + std::string(text);
    };
  };
  Service s{std::string(verb), {}, 0, {}, told("")};
  if (verb == "shutter" && v.size() == 1) return begin_exposure(v[0], kKeepIris, now_us, fx);
  if (verb == "on" && v.empty()) {
    s.begin = {line(d.lamp_on, omnicure::kReceived, Repeat::kSetup)};
  } else if (verb == "off" && v.empty()) {
    s.begin = {line(d.close, omnicure::kReceived, Repeat::kSetup),
               line(d.lamp_off, omnicure::kReceived, Repeat::kSetup)};
  } else if (verb == "iris" && v.size() == 1) {
    if (!(v[0] >= 1 && v[0] <= 100) || v[0] != std::floor(v[0]))
      return refuse_service(kLimit, "an iris is a whole number of percent, 1 to 100", fx);
    s.begin = {line(d.iris + std::to_string(int(v[0])), omnicure::kReceived, Repeat::kSetup)};
  } else if (verb == "hours" && v.empty()) {
    s.begin = {line(d.hours, omnicure::kAny, Repeat::kRead)};
    s.tell = told("lamp hours ");
  } else if (verb == "serial" && v.empty()) {
    s.begin = {line(d.serial, omnicure::kAny, Repeat::kRead)};
    s.tell = told(identity_ + " serial ");
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
