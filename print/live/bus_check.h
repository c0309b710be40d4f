// Checks that datagrams sent to the bus come back on this machine.
#pragma once

#include <string>

namespace firn {

/// Sends one datagram with ttl 0 through LCM and waits for it. Returns empty, or the fault and its remedy.
std::string check_multicast(double within_s = 2.0);

}  // namespace firn
