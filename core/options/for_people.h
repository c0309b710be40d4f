// for_people() writes numbers as people read them: three significant digits and no exponent. Files that
// programs read keep every digit.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace firn {

inline constexpr double kHour_s = 3600.0;

/// Returns a number in three significant digits, a number from 1000 on in whole ones with its thousands
/// apart: "7.5", "0.00512", "1,234,568"; "-" for a number that is none. Zeros behind the last digit are left
/// out.
std::string for_people(double value);

/// Returns a time in the unit that people give it in: "0.35 s", "41 s", "12 min", "2.5 h".
/// @param s [s]
std::string time_for_people(double s);

/// Returns a number of things with its thousands apart: "12,345".
std::string grouped(std::uint64_t n);

/// Returns a number of things and their name: "1 layer", "2 layers", "1,310 droplets".
/// @param one name of one of them @param many of several; empty: `one` and an s
std::string counted(std::uint64_t n, std::string_view one, std::string_view many = {});

/// Returns a sentence of a node with its long decimals in three significant digits. Sentences that are
/// recorded have six decimals ("60.000126 s", std::to_string), which a replay must meet again.
std::string for_people(std::string_view sentence);
inline std::string for_people(const std::string& sentence) { return for_people(std::string_view(sentence)); }
inline std::string for_people(const char* sentence) { return for_people(std::string_view(sentence)); }

}  // namespace firn
