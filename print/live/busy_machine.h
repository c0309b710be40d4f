// Says of a stop that a busy computer may be its cause, and measures how late a computer lets a print run.
#pragma once

#include <cstdint>
#include <string>

namespace firn {

/// Lines of limits.conf with which a print goes before the computer's other work (runtime/precedence.h).
inline constexpr const char* kPriorityRemedy =
    "give the print priority, by the lines \"USER - rtprio 1\" and \"USER - nice -10\" in "
    "/etc/security/limits.conf and a new login, or another computer";

/// Returns words to append to the reason of a stop: "; this computer was busy (load 9.4 on 2 cores): ...".
/// Empty: the stop is not of the kind that a late process causes, or the load is below the cores.
/// @param reason of the stop @param fault_code interlock number of its fault (fault_t.code), 0 = none
/// @param load mean number of processes that wanted to run @param cores of the computer
std::string busy_words(const std::string& reason, std::int32_t fault_code, double load, unsigned cores);
/// The same, by the load of the last minute.
std::string busy_words(const std::string& reason, std::int32_t fault_code);

/// Returns the longest delay of a wake-up within some seconds [s], scheduled as the safety process is.
double longest_delay_s(double for_s);

}  // namespace firn
