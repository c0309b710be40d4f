// Alarms are the events of a print that a person has to see, and who acknowledged which of them when. An
// acknowledgement is a line of the run's notes, which keep and seal it.
#pragma once

#include <string>

#include "page/view_data.h"

namespace firn::page {

/// Returns true for a warning, a fault or a stop.
bool is_alarm(const EventRow& event);

/// Returns "12.345 s, jet: no droplets": the alarm as an acknowledgement names it, the same from a live print
/// and from its records.
std::string alarm_text(const EventRow& event);

}  // namespace firn::page
