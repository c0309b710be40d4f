// Option describes one member of an options struct: name, member, unit, range and meaning. A struct's table
// of options stands beside the struct; the struct's check and config's keys both come from it, so that each
// option has one default (the member's initialiser) and one range.
//
//   struct SmfOptions { double kp = 1.0; };
//   inline constexpr OptionTable kSmfOptions{
//       Option{"kp", &SmfOptions::kp, "", above(0, 10), "proportional gain [Barnett, (5.1)]"},
//   };
//   check_options("smf", kSmfOptions, options);   // throws "smf: kp = 11 is outside (0, 10]"
#pragma once

#include <concepts>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/options/range.h"

namespace firn {

/// When an option's value may change.
enum class Change : std::uint8_t {
  kBeforePrint,    ///< the value holds for a whole print
  kBetweenLayers,  ///< the operator may change it; the next decision uses the new value
};

template <class Struct, class Value>
struct Option {
  std::string_view name;
  Value Struct::*member;
  std::string_view unit;  ///< "" = none
  Range range;            ///< of a list: of each entry; not used by words
  std::string_view meaning;
  Change change = Change::kBeforePrint;
};
template <class Struct, class Value>
Option(std::string_view, Value Struct::*, std::string_view, Range, std::string_view) -> Option<Struct, Value>;
template <class Struct, class Value>
Option(std::string_view, Value Struct::*, std::string_view, Range, std::string_view, Change)
    -> Option<Struct, Value>;

namespace detail {

template <std::size_t, class T>
struct OptionPlace {
  T option;
};
template <class, class...>
struct OptionPlaces;
template <std::size_t... N, class... T>
struct OptionPlaces<std::index_sequence<N...>, T...> : OptionPlace<N, T>... {
  constexpr explicit OptionPlaces(const T&... options) : OptionPlace<N, T>{options}... {}

  template <class F>
  constexpr decltype(auto) apply(F&& f) const {
    return f(static_cast<const OptionPlace<N, T>&>(*this).option...);
  }
};

}  // namespace detail

/// The options of one struct; apply(f) returns f(option, option, ...). Does what std::tuple does, in a third
/// of its compile time: every file that reads a configuration holds these tables.
template <class... T>
struct OptionTable : detail::OptionPlaces<std::index_sequence_for<T...>, T...> {
  constexpr explicit OptionTable(const T&... options)
      : detail::OptionPlaces<std::index_sequence_for<T...>, T...>(options...) {}
};

/// A member that holds one of a few words is an enumeration with values 0, 1, 2, ... and a function
/// words_of(E), beside it, that returns the words in this order.
template <class E>
concept Worded = std::is_enum_v<E> && requires(E e) {
  { words_of(e) } -> std::convertible_to<std::span<const std::string_view>>;
};

template <Worded E>
constexpr std::string_view word(E e) {
  return words_of(e)[std::size_t(e)];
}

/// An entry of a list as the number that its range bounds. Lists of other entries have a number_of() of their
/// own.
constexpr double number_of(double value) { return value; }

namespace detail {

/// The name in the message is prefix and name.
void check_number(std::string_view where, std::string_view prefix, std::string_view name, double value,
                  const Range& range);

template <class Base, class Value, class Struct>
void check_option(std::string_view where, std::string_view prefix, const Option<Base, Value>& option,
                  const Struct& options) {
  const Value& value = options.*option.member;
  if constexpr (std::is_arithmetic_v<Value>)
    check_number(where, prefix, option.name, double(value), option.range);
  else if constexpr (Worded<Value>)
    check_number(where, prefix, option.name, double(value),
                 within(0.0, double(words_of(value).size()) - 1.0));
  else
    for (const auto& entry : value) check_number(where, prefix, option.name, number_of(entry), option.range);
}

}  // namespace detail

/// Copies the options of `table` that may change between layers.
template <class Struct, class... Options>
void take_changeable(const OptionTable<Options...>& table, const Struct& from, Struct& to) {
  const auto take = [&](const auto& option) {
    if (option.change == Change::kBetweenLayers) to.*option.member = from.*option.member;
  };
  table.apply([&](const auto&... option) { (take(option), ...); });
}

/// @param prefix of the names in the message, for an options struct inside another: "foresee."
/// @throws std::invalid_argument "<where>: <prefix><name> = <value> is outside <range>" for the first option
/// out of its range
template <class Struct, class... Options>
void check_options(std::string_view where, const OptionTable<Options...>& table, const Struct& options,
                   std::string_view prefix = "") {
  table.apply([&](const auto&... option) { (detail::check_option(where, prefix, option, options), ...); });
}

}  // namespace firn
