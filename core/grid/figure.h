// Figure holds a value that is compared with a limit, Violation the sentence about a broken limit.
#pragma once

#include <optional>
#include <string>

namespace firn {

struct Figure {
  std::optional<double> value = {};
  std::optional<double> limit = {};
  std::string unit = {};  ///< of both; empty: a share or a count
  std::string key = {};   ///< of the configuration, which sets the limit; empty: no key does
};

struct Violation {
  std::string text = {};  ///< for people; empty: no limit is broken
  Figure figure = {};

  bool empty() const { return text.empty(); }
};

}  // namespace firn
