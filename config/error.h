// ConfigError holds the place and the description of a mistake in a configuration.
#pragma once

#include <stdexcept>
#include <string>

namespace firn {

/// what() returns "file:line: key = value: problem, with unit and limit", as far as these are known.
struct ConfigError : std::runtime_error {
  ConfigError(const std::string& file_name, int line_number, const std::string& key_name,
              const std::string& what_is_wrong);

  std::string file;
  int line = 0;         ///< 1-based; 0 = unknown or not from a file
  std::string key;      ///< "" when the file as a whole is wrong
  std::string problem;  ///< the message without the place
};

}  // namespace firn
