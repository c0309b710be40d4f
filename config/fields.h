// The one table of configuration fields. Parser, resolved dump, docs/configuration.md, the nearest known key
// and the list of differences all come from it.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/experiment.h"

namespace firn {

/// What a field may hold: an interval for numbers, a list for words. Nothing may be NaN or infinite.
struct Limits {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();  ///< of a list: of each entry
  bool min_excluded = false;
  std::vector<std::string_view> choices;  ///< of a string; empty = any printable text
};

using FieldValue = std::variant<double*, std::int32_t*, std::int64_t*, std::uint64_t*, std::string*,
                                std::vector<AlphaStep>*, std::vector<double>*>;

struct Field {
  std::string_view key;   ///< "grid.pitch_x_mm": section, dot, name
  FieldValue value;       ///< into the experiment handed to fields()
  std::string_view unit;  ///< "" = none
  Limits limits;
  std::string_view meaning;

  std::string_view section() const { return key.substr(0, key.rfind('.')); }
  std::string_view name() const { return key.substr(key.rfind('.') + 1); }
};

/// Every field of `experiment`, of all kinds of labs, in the order of the dump: sections stand together.
std::vector<Field> fields(Experiment& experiment);
/// Those of the ice lab (lab.kind to flow, then plant.ice), part of fields().
std::vector<Field> ice_fields(Experiment& experiment);
std::vector<Field> ice_plant_fields(Experiment& experiment);

/// Whether a kind of lab has the field: "inkjet" knows no robot, "ice" no jet.
bool belongs(const Field& field, std::string_view lab_kind);

/// Value as TOML: shortest text that reads back to the same value; canonical (-0.0 is written 0.0).
std::string value_text(const Field& field);

/// "" when the value keeps the limits, else what is wrong: "must lie in (0, 100] mm".
std::string broken_limit(const Field& field);

/// "(0, 100]", "one of a, b", or "" when anything goes: for documentation and messages.
std::string limits_text(const Field& field);

/// "number", "integer", "text", "number or schedule" or "list of numbers".
std::string_view type_text(const Field& field);

}  // namespace firn
