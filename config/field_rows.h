// rows() returns the fields of an options struct from its own table (core/options/option.h); further helpers
// build the rows of all other structs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "core/options/enumerators.h"
#include "core/options/option.h"

namespace firn::field_rows {

using Table = std::vector<Field>;
inline void add(Table& t, const Table& rows) { t.insert(t.end(), rows.begin(), rows.end()); }

inline Limits text() { return {}; }
inline Limits path() {
  Limits limits;
  limits.is_path = true;
  return limits;
}
inline Limits one_of(std::vector<std::string_view> choices) { return {{}, std::move(choices)}; }
inline Limits or_own(Limits limits) {
  limits.or_own = true;
  return limits;
}

/// The key of one option. @param meaning instead of the option's own
template <class Struct, class Value>
Field row(std::string key, Value& value, const Option<Struct, Value>& option, std::string_view meaning = {}) {
  const std::string_view told = meaning.empty() ? option.meaning : meaning;
  const bool between_layers = option.change == Change::kBetweenLayers;
  if constexpr (Worded<Value>) {
    constexpr std::span<const std::string_view> words = words_of(Value{});
    static_assert(words.size() == kTableSize<Value>, "one word for each value");
    const WordMember member{&value, [](const void* v) { return std::size_t(*static_cast<const Value*>(v)); },
                            [](void* v, std::size_t word) { *static_cast<Value*>(v) = Value(word); }};
    return {std::move(key), member, option.unit, one_of({words.begin(), words.end()}), told, between_layers};
  } else {
    return {std::move(key), &value, option.unit, option.range, told, between_layers};
  }
}

/// The keys of all options of a table. @param section with its dot: "control.smf."
template <class Struct, class... Options>
Table rows(const std::string& section, Struct& options, const OptionTable<Options...>& table) {
  return table.apply(
      [&](const auto&... o) { return Table{row(section + std::string(o.name), options.*o.member, o)...}; });
}

}  // namespace firn::field_rows
