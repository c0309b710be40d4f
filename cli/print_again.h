// print_again() prints a recorded run anew in the simulated lab, and compares every message with the recorded
// one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace firn {

struct Product;

struct PrintedAgain {
  bool same = false;           ///< every message has the same bytes
  bool printed = false;        ///< else `why` has the reason
  std::uint64_t messages = 0;  ///< equal ones
  std::string why;             ///< the first reason
};

/// @param scratch an empty folder, for the new run
/// @param run_python code of the run in Python is run too
PrintedAgain print_again(const Product& product, const std::filesystem::path& run,
                         const std::filesystem::path& scratch, bool run_python);

}  // namespace firn
