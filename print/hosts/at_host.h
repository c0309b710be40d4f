// run_at_host() carries out a command of firn at the computer where an instrument is: the driver and its stop
// stay beside the instrument, whatever the line does.
#pragma once

#include <string>
#include <vector>

#include "config/experiment.h"

namespace firn {

/// Name of the host of a node; empty: this computer.
std::string host_of(const Experiment& lab, const std::string& node);

/// A file beside the lab's, which names it.
struct FileOfLab {
  std::string name, text;
};
/// Stands among a command's words for the lab file; a command without it has that behind its name.
inline constexpr const char* kLabHere = "LAB";

/// Runs `firn COMMAND LAB WORDS` at the host, where LAB is `lab` with that host's instruments as its own.
/// Input and errors are this process's, and so is the output unless `output` takes it. Returns its exit code;
/// kSafetyStop, with a sentence on stderr, if the host cannot be reached.
int run_at_host(const Experiment& lab, const std::string& host, const std::string& command,
                const std::vector<std::string>& words, const std::vector<FileOfLab>& files = {},
                std::string* output = nullptr);

/// The words for ssh that do it. @param person may be asked and may press Ctrl-C there
std::vector<std::string> words_at_host(const Experiment& lab, const std::string& host,
                                       const std::string& command, const std::vector<std::string>& words,
                                       const std::vector<FileOfLab>& files = {}, bool person = false);

/// The other side of run_at_host: writes the lab file and runs the command. When nobody takes its output any
/// more, the connection is gone: it gets SIGINT, as by Ctrl-C. @returns its exit code
/// @param files_in_hex "NAME:digits" @throws UsageError: the text is no lab of a launcher
int run_here(const std::string& lab_in_hex, const std::vector<std::string>& files_in_hex,
             const std::string& command, const std::vector<std::string>& words);

}  // namespace firn
