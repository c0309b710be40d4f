// read_arguments() reads the command line of a process of a run: pairs "--name value" in any order.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace firn {

/// One name and the place of its value; a function takes a text that is more than one number.
struct ProcessArgument {
  std::string_view name;
  std::variant<std::string*, std::int32_t*, std::int64_t*, double*, std::function<void(const std::string&)>>
      value;
};

/// @throws std::invalid_argument "<name> '<value>': must be <must>"
[[noreturn]] void refuse_argument(std::string_view name, std::string_view value, std::string_view must);

/// The number that is the whole of `text`.
/// @throws std::invalid_argument "<name> '<text>': must be a number"
template <class T>
T argument_number(std::string_view name, std::string_view text);

/// @throws std::invalid_argument naming an argument that is not in the table, has no value, or is no number
void read_arguments(const std::vector<std::string>& arguments, std::span<const ProcessArgument> table);

}  // namespace firn
