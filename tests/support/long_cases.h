// Divides long loops of cases into tenths, of which ./firn test runs one a day (scripts/run_tests.py). A case
// must depend on its number alone, not on the cases before it.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn::test {

/// True under FIRN_FULL: all cases run.
inline bool full_cases() { return std::getenv("FIRN_FULL") != nullptr; }

/// Returns the tenth of FIRN_TENTH, 0 to 9, or nothing where it is "none" or missing.
/// @throws std::invalid_argument for any other text
inline std::optional<std::size_t> tenth_of_cases() {
  const char* text = std::getenv("FIRN_TENTH");
  const std::string tenth = text ? text : "none";
  if (tenth == "none") return std::nullopt;
  if (tenth.size() != 1 || tenth[0] < '0' || tenth[0] > '9')
    throw std::invalid_argument("FIRN_TENTH: '" + tenth + "' is neither a digit nor none");
  return std::size_t(tenth[0] - '0');
}

/// Numbers first, first + step, ...
struct Stride {
  std::size_t first = 0, step = 1;
};

/// Returns all of the numbers of `all` under FIRN_FULL, every tenth of them under FIRN_TENTH, `few`
/// otherwise: ten tenths run each number of `all` once.
inline Stride long_stride(Stride all, Stride few) {
  if (full_cases()) return all;
  const auto tenth = tenth_of_cases();
  return tenth ? Stride{all.first + *tenth * all.step, 10 * all.step} : few;
}

/// Returns the numbers in [0, all) that this run tries: all, a tenth, or the first `few`.
inline std::vector<std::size_t> long_cases(std::size_t all, std::size_t few) {
  const Stride stride = long_stride({}, {});
  std::vector<std::size_t> cases;
  const std::size_t end = full_cases() || tenth_of_cases() ? all : few;
  for (std::size_t n = stride.first; n < end; n += stride.step) cases.push_back(n);
  return cases;
}

/// Returns those of `all` that this run tries: all, a tenth, or the first `few`.
template <class T>
std::vector<T> long_cases(const std::vector<T>& all, std::size_t few) {
  std::vector<T> some;
  for (const std::size_t n : long_cases(all.size(), few)) some.push_back(all[n]);
  return some;
}

}  // namespace firn::test
