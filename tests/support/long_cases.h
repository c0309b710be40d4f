// Shortens long loops of cases: `./firn test --full` runs all of them, `./firn test` the same few every
// time. A case must depend on its number alone, not on the cases before it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <vector>

namespace firn::test {

/// Returns true under FIRN_FULL: all cases run.
inline bool full_cases() { return std::getenv("FIRN_FULL") != nullptr; }

/// Returns the numbers in [0, all) that this run tries: all under FIRN_FULL, otherwise `few`, evenly spread.
inline std::vector<std::size_t> long_cases(std::size_t all, std::size_t few) {
  const std::size_t count = full_cases() ? all : std::min(all, few);
  std::vector<std::size_t> cases(count);
  for (std::size_t n = 0; n < count; ++n) cases[n] = n * all / count;
  return cases;
}

/// Returns those of `all` that this run tries.
template <class T>
std::vector<T> long_cases(const std::vector<T>& all, std::size_t few) {
  std::vector<T> some;
  for (const std::size_t n : long_cases(all.size(), few)) some.push_back(all[n]);
  return some;
}

}  // namespace firn::test
