// utc_now tells the time of day in UTC as files and file names bear it.
#pragma once

#include <string>

namespace firn {

/// Returns the present time. @param format as of strftime; usually as "2026-12-01T14:28:31Z"
std::string utc_now(const char* format = "%Y-%m-%dT%H:%M:%SZ");

}  // namespace firn
