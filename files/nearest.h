// nearest returns the known word nearest to an unknown one, for error messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace firn {

/// Returns the number of letters that differ, are missing or too many (Levenshtein).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Returns the candidate with the smallest edit distance to `word`; "" when more than half of every candidate
/// is wrong.
std::string nearest(std::string_view word, const std::vector<std::string_view>& candidates);

}  // namespace firn
