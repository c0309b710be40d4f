// print_text and print_json report a finished print: its end and its verdict (docs/commands/print.md).
#pragma once

#include <string>

#include "cli/print_run.h"

namespace firn {

/// Returns the last line of a print: its verdict, or how a print that was stopped goes on.
std::string last_line(const runs::RunResult& result, const LabWords& words, const std::string& folder);
std::string print_text(const PrintSummary& summary);
std::string print_json(const PrintSummary& summary);

}  // namespace firn
