// LaserProfiler: orders of a person, beside a print (firn device).
#include "drivers/laser_profiler/laser_profiler.h"

namespace firn::drivers {

void LaserProfiler::service(std::string_view verb, std::span<const double> v, std::int64_t now_us,
                            Effects& fx) {
  Service s{std::string(verb), {}, 0, {}, nullptr};
  if (verb == "read" && v.empty()) {
    s.begin = {ljv::get_newest_profile(false)};
    s.tell = [this](const Request&, std::span<const std::byte> frame) -> std::optional<std::string> {
      raw_.points = 0;
      const auto head = ljv::parse_head(frame);
      if (!head || head->return_code != 0 || !ljv::parse_profile(frame, raw_)) return std::nullopt;
      return std::string();
    };
    s.then = [this](std::int64_t, Effects& effects) {
      Result r{Outcome::kNone, 0, 1, 0, 0, kNoCode, "it has measured nothing yet: a trigger is wanted"};
      if (raw_.points > 0) {
        effects.measured<LaserProfiler>(in_part_frame(0));
        r = {Outcome::kDone, 1, 1, 0, 0, kNoCode, std::to_string(raw_.points) + " points"};
      }
      effects.events.emplace_back(std::move(r));
    };
  } else if (verb == "errors" && v.empty()) {
    s.begin = {ljv::get_errors()};
    s.tell = [](const Request&, std::span<const std::byte> frame) -> std::optional<std::string> {
      const auto head = ljv::parse_head(frame);
      if (!head || head->return_code != 0) return std::nullopt;
      return ljv::error_text(frame);
    };
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
