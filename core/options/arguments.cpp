#include "core/options/arguments.h"

#include <algorithm>
#include <stdexcept>

#include "core/options/number.h"

namespace firn {

void refuse_argument(std::string_view name, std::string_view value, std::string_view must) {
  throw std::invalid_argument(std::string(name) + " '" + std::string(value) + "': must be " +
                              std::string(must));
}

template <class T>
T argument_number(std::string_view name, std::string_view text) {
  const std::optional<T> v = whole_number<T>(text);
  if (!v) refuse_argument(name, text, "a number");
  return *v;
}
template std::int32_t argument_number(std::string_view, std::string_view);
template std::int64_t argument_number(std::string_view, std::string_view);
template std::uint64_t argument_number(std::string_view, std::string_view);
template double argument_number(std::string_view, std::string_view);

void read_arguments(const std::vector<std::string>& arguments, std::span<const ProcessArgument> table) {
  for (std::size_t n = 0; n < arguments.size(); n += 2) {
    const std::string& name = arguments[n];
    if (n + 1 == arguments.size()) refuse_argument(name, "", "followed by its value");
    const std::string& text = arguments[n + 1];
    const auto row = std::ranges::find(table, name, &ProcessArgument::name);
    if (row == table.end())
      refuse_argument(name, text, "an argument of a process of Firn; firn print starts these");
    std::visit(
        [&]<class To>(const To& to) {
          if constexpr (std::is_same_v<To, std::string*>)
            *to = text;
          else if constexpr (std::is_pointer_v<To>)
            *to = argument_number<std::remove_pointer_t<To>>(name, text);
          else if (to)
            to(text);
        },
        row->value);
  }
}

}  // namespace firn
