// Error in what the user typed or handed in.
#pragma once

#include <stdexcept>

namespace firn {

/// Anything wrong with what the user typed or handed in: exit code 2.
struct UsageError : std::runtime_error {
  using runtime_error::runtime_error;
};

}  // namespace firn
