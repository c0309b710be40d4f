// run_at_host() carries out a command of firn at the computer where an instrument is: the driver and its stop
// stay beside the instrument, whatever the line does.
#pragma once

#include <string>
#include <vector>

#include "config/experiment.h"

namespace firn {

/// Name of the host of a node; empty: this computer.
std::string host_of(const Experiment& lab, const std::string& node);

/// Runs `firn COMMAND LAB WORDS` at the host, where LAB is `lab` with that host's instruments as its own.
/// Input, output and errors are this process's. Returns its exit code; kSafetyStop, with a sentence on
/// stderr, if the host cannot be reached.
int run_at_host(const Experiment& lab, const std::string& host, const std::string& command,
                const std::vector<std::string>& words);

/// The words for ssh that do it.
std::vector<std::string> words_at_host(const Experiment& lab, const std::string& host,
                                       const std::string& command, const std::vector<std::string>& words);

/// The other side of run_at_host: writes the lab file and runs the command. @returns its exit code
/// @throws UsageError: the text is no lab of a launcher
int run_here(const std::string& lab_in_hex, const std::string& command,
             const std::vector<std::string>& words);

}  // namespace firn
