// print_text, print_json and exit_code report a finished print: its verdict against the tolerance, in words
// and as exit code (docs/commands/print.md).
#pragma once

#include <optional>
#include <string>

#include "cli/print_run.h"

namespace firn {

/// One nominal layer [um]; 0 where a scheme prints towards no target: patterns, registration marks, a given
/// number of full layers.
double usual_tolerance_um(const Experiment& experiment);

/// Nothing of a print that has not run to its end, was not measured or has no tolerance.
std::optional<bool> within_tolerance(const PrintSummary& summary);

/// The print's own status; kOutOfTolerance where its last map is out of tolerance; kFailed where a tolerance
/// was asked for and nothing was measured.
int exit_code(const PrintSummary& summary);

std::string print_text(const PrintSummary& summary);
std::string print_json(const PrintSummary& summary);

}  // namespace firn
