// What the tables of fields are written with.
#pragma once

#include <string_view>
#include <vector>

#include "config/fields.h"

namespace firn::field_rows {

using Table = std::vector<Field>;
inline void add(Table& t, Table rows) { t.insert(t.end(), rows.begin(), rows.end()); }

inline Limits text() { return {}; }
inline Limits within(double lo, double hi) { return {lo, hi, false, {}}; }
inline Limits above(double lo, double hi) { return {lo, hi, true, {}}; }
inline Limits one_of(std::vector<std::string_view> choices) {
  Limits l;
  l.choices = std::move(choices);
  return l;
}

}  // namespace firn::field_rows
