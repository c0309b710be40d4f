// figure_contradiction compares the figure of a fault with the numbers of its sentence. Test benches call it
// for every fault that a node or a driver reports.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/grid/figure.h"

namespace firn::figure_words {

inline std::vector<double> numbers_in(const std::string& words) {
  std::vector<double> found;
  for (const char* at = words.c_str(); *at != '\0';) {
    const bool begins = (*at >= '0' && *at <= '9') || (*at == '-' && at[1] >= '0' && at[1] <= '9');
    char* end = nullptr;
    if (begins) found.push_back(std::strtod(at, &end));
    at = begins ? end : at + 1;
  }
  return found;
}

/// The value is a number of the sentence, or the difference, quotient or length of two; the limit is one, or
/// a key sets it. Sentences round to 2 digits and more.
/// @returns the contradiction; empty: none
inline std::string figure_contradiction(const std::string& words, const Figure& f) {
  const auto near = [](double a, double b) { return std::abs(a - b) <= 0.02 * std::abs(b) + 1e-5; };
  const std::vector<double> numbers = numbers_in(words);
  const auto told = [&](double x) {
    return std::ranges::any_of(numbers, [&](double n) { return near(x, n); });
  };
  bool value_told = !f.value || !std::isfinite(*f.value) || told(*f.value);  // not finite: sent as not known
  for (const double a : numbers)
    for (const double b : numbers)
      value_told =
          value_told || near(*f.value, a - b) || near(*f.value, a / b) || near(*f.value, std::hypot(a, b));
  if (!value_told) return "value " + std::to_string(*f.value) + " is not in '" + words + "'";
  if (f.limit && f.key.empty() && !told(*f.limit))
    return "limit " + std::to_string(*f.limit) + " is neither in '" + words + "' nor has a key";
  if ((f.limit || !f.unit.empty() || !f.key.empty()) && !f.value)
    return "a limit, unit or key without a value: " + words;
  if (!f.unit.empty() && words.find(f.unit) == std::string::npos)
    return "unit " + f.unit + " is not in '" + words + "'";
  return "";
}

}  // namespace firn::figure_words
