// ExtraOption declares a parameter of one scheme, which its experiment sets under [control.extra]. The
// scheme's row in its table of schemes holds the declarations; nothing else has to know them.
//
//   inline constexpr std::array kLevelOptions{
//       ExtraOption{"level_margin_mm", 0.002, "mm", within(0, 1), "cells this much above the lowest are
//       raised too"}};
//   ... in the constructor:  margin_mm_(options.extra.number("level_margin_mm"))
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>

#include "core/options/option.h"

namespace firn::control {

struct ExtraOption {
  std::string_view name;                                         ///< unlike those of all other schemes
  std::variant<double, std::int64_t, std::string_view> initial;  ///< the default, whose type is the option's
  std::string_view unit;
  Range range;  ///< of numbers
  std::string_view meaning;
  std::span<const std::string_view> words = {};  ///< of a text: the allowed ones; empty: any
  Change change = Change::kBeforePrint;
};

/// Holds the values of declared options, by name.
struct ExtraValues {
  std::map<std::string, double, std::less<>> numbers;
  std::map<std::string, std::int64_t, std::less<>> integers;
  std::map<std::string, std::string, std::less<>> texts;

  /// Gives every option that has no value its default.
  void complete(std::span<const ExtraOption> options) {
    for (const ExtraOption& o : options) {
      const std::string name(o.name);
      if (const auto* number = std::get_if<double>(&o.initial))
        numbers.try_emplace(name, *number);
      else if (const auto* integer = std::get_if<std::int64_t>(&o.initial))
        integers.try_emplace(name, *integer);
      else
        texts.try_emplace(name, std::get<std::string_view>(o.initial));
    }
  }

  double number(std::string_view name) const { return value(numbers, name); }
  std::int64_t integer(std::string_view name) const { return value(integers, name); }
  const std::string& text(std::string_view name) const { return value(texts, name); }

 private:
  template <class Map>
  static const typename Map::mapped_type& value(const Map& values, std::string_view name) {
    const auto found = values.find(name);
    if (found == values.end())
      throw std::invalid_argument("control.extra." + std::string(name) +
                                  ": no scheme declares it with this type");
    return found->second;
  }
};

/// @throws std::invalid_argument "<where>: <name> = <value> is outside <range>" for the first number out of
/// its range; an option without a value has its default
inline void check_extra(std::string_view where, std::span<const ExtraOption> options, ExtraValues values) {
  values.complete(options);
  for (const ExtraOption& o : options)
    if (std::holds_alternative<double>(o.initial))
      detail::check_number(where, "extra.", o.name, values.number(o.name), o.range);
    else if (std::holds_alternative<std::int64_t>(o.initial))
      detail::check_number(where, "extra.", o.name, double(values.integer(o.name)), o.range);
}

}  // namespace firn::control
