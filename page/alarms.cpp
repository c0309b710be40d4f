#include "page/alarms.h"

#include <fmt/core.h>

namespace firn::page {

bool is_alarm(const EventRow& event) { return event.weight >= Weight::kWarning; }

std::string alarm_text(const EventRow& event) {
  return fmt::format("{:.3f} s, {}: {}", event.t_s, event.source, event.words);
}

}  // namespace firn::page
