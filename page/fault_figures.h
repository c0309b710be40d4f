// fault_figures finds the value and the limit of an interlock in the words of its fault.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace firn::page {

struct FaultFigures {
  double value = 0.0;
  std::optional<double> limit;
  std::string_view unit;  ///< of both
};

/// @param code of the interlock (docs/safety.md)
/// @param settings by key: limits that the words do not repeat
/// @returns nothing for a fault that is about no number
std::optional<FaultFigures> fault_figures(int code, std::string_view words,
                                          const std::map<std::string, double>& settings);

}  // namespace firn::page
