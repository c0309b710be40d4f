// for_people() writes numbers as people read them: three significant digits and no exponent. Files that
// programs read keep every digit.
#pragma once

#include <string>
#include <string_view>

namespace firn {

/// Returns a number in three significant digits, a number from 1000 on in whole ones with its thousands
/// apart: "7.5", "0.00512", "1,234,568"; "-" for a number that is none. Zeros behind the last digit are left
/// out.
std::string for_people(double value);

/// Returns a sentence of a node with its long decimals in three significant digits. Sentences that are
/// recorded have six decimals ("60.000126 s", std::to_string), which a replay must meet again.
std::string for_people(std::string_view sentence);
inline std::string for_people(const std::string& sentence) { return for_people(std::string_view(sentence)); }
inline std::string for_people(const char* sentence) { return for_people(std::string_view(sentence)); }

}  // namespace firn
