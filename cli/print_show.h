// print_text and print_json report a finished print: its end and its verdict (docs/commands/print.md).
#pragma once

#include <string>

#include "cli/print_run.h"

namespace firn {

std::string print_text(const PrintSummary& summary);
std::string print_json(const PrintSummary& summary);

}  // namespace firn
