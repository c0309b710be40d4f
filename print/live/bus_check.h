// Whether datagrams that leave for the bus come back on this machine.
#pragma once

#include <string>

namespace firn {

/// Sends one datagram with ttl 0 through LCM and waits for it. @returns empty, or what is wrong and the mend
std::string check_multicast(double within_s = 2.0);

}  // namespace firn
