// open_serial_line() opens the serial line of an instrument: raw bytes, without flow control, for this
// process alone.
#pragma once

#include <string>
#include <string_view>

#include "files/port_address.h"

namespace firn {

/// Opens the device file nonblocking, locks it (TIOCEXCL and flock) and sets speed, frame and modem line.
/// @param why receives the reason when there is none: no such file, the process that holds the line, a
/// setting that the line does not take
/// @returns a file descriptor, or -1
int open_serial_line(const PortAddress& address, std::string& why);

/// Drops the bytes that the line has not sent yet: a stop must not wait behind it.
void drop_unsent(int fd);

/// Returns "process 812 (ModemManager)" for a process that has the file open, this one excepted; empty if
/// none is seen.
std::string holder_of(std::string_view file);

}  // namespace firn
