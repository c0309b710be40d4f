// Notice tells a program of the user's that a print has ended: it is started with the event as JSON on its
// standard input, and nobody waits for it.
#pragma once

#include <string>

#include "cli/print_run.h"

namespace firn {

/// Returns the event of a print that is over, one line (docs/notify.md): finished, out of tolerance, needs a
/// person, or stopped with its reason.
std::string notice_of(const PrintSummary& print);

/// Starts `command` in a shell and a session of its own with `event` on its standard input; its output goes
/// nowhere. A command that cannot be started changes nothing about the print: the error output says so.
void send_notice(const std::string& command, const std::string& event);

/// Gives the command an event of no print, waits for it, and lets its output through.
/// @returns its exit status; 128 and the number of the signal that ended it
int try_notice(const std::string& command);

}  // namespace firn
