// UsageError holds the message of an error in the user's input.
#pragma once

#include <stdexcept>

namespace firn {

/// An error in the command line or in a file of the user: exit code 2.
struct UsageError : std::runtime_error {
  using runtime_error::runtime_error;
};

}  // namespace firn
