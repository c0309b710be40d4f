// Assumptions about instruments: keys whose meaning has the mark of its evidence. [C] vendor text or two
// independent codebases, [S] one public source, [M] from memory, [P] ours, [U] inferred.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"

namespace firn {

struct Assumption {
  std::string key, value;
  char mark = 'C';
  std::string_view meaning;
};

/// Returns the last mark in a key's meaning, or 0.
char mark_of(std::string_view meaning);
/// @returns true for a mark without public evidence: M, P, U
bool unproven(char mark);

/// Returns the marked keys of an instrument, [NODE] and [devices.NODE.dialect], in the order of the table.
std::vector<Assumption> assumptions(const Experiment& experiment, std::string_view node);

/// Returns "settings of its protocol: 18 by its maker's text or two codebases [C], 3 chosen here [P]; to
/// check on yours: max_abs_v = 100 [P], …": how many of each mark, and those without evidence. Empty for an
/// instrument without marked keys.
std::string assumptions_text(const Experiment& experiment, std::string_view node);

}  // namespace firn
