// fields() returns the one table of configuration fields. Parser, resolved dump, docs/configuration.md, the
// nearest known key and the list of differences all come from it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/experiment.h"
#include "core/options/range.h"

namespace firn {

/// Limits hold the allowed values of a field: an interval for numbers (of a list: for each entry), a list for
/// words.
struct Limits : Range {
  std::vector<std::string_view> choices;  ///< of words; empty = any printable text
  bool is_path = false;                   ///< relative to the folder of the file that gives it
  bool or_own = false;     ///< words: or own:NAME, a program of the lab's own (config/own_programs.h)
  bool or_python = false;  ///< words: or a class in a Python file (core/control/python_scheme.h)

  Limits(const Range& range = {}, std::vector<std::string_view> words = {})
      : Range(range), choices(std::move(words)) {}
};

/// A member that is an enumeration with words (core/options/option.h); its value counts the field's choices.
struct WordMember {
  void* member;
  std::size_t (*get)(const void* member);
  void (*set)(void* member, std::size_t value);
};

using FieldValue = std::variant<double*, std::int32_t*, std::int64_t*, std::uint64_t*, std::string*,
                                std::vector<AlphaStep>*, std::vector<double>*, WordMember>;

struct Field {
  std::string key;        ///< "grid.pitch_x_mm": section, dot, name
  FieldValue value;       ///< into the experiment handed to fields()
  std::string_view unit;  ///< "" = no unit
  Limits limits;
  std::string_view meaning;
  bool between_layers = false;   ///< the operator may change it while the print runs
  std::string_view scheme = {};  ///< that alone has the key; empty: any
  std::string_view nature = {};  ///< word of plant.model that alone has the key; empty: any
  bool only_if_given = false;    ///< not in the dump while it is empty or zero

  std::string_view section() const { return std::string_view(key).substr(0, key.rfind('.')); }
  std::string_view name() const { return std::string_view(key).substr(key.rfind('.') + 1); }
};

/// Returns every field of `experiment`, of all kinds of labs, in the order of the dump; fields of one section
/// are adjacent.
std::vector<Field> fields(Experiment& experiment);
/// Returns the fields of the ice lab (lab.kind to flow, then plant.ice), part of fields().
std::vector<Field> ice_fields(Experiment& experiment);
std::vector<Field> ice_plant_fields(Experiment& experiment);

/// Returns true if a kind of lab has the field: "inkjet" has no robot, "ice" no jet.
bool belongs(const Field& field, std::string_view lab_kind);

/// Returns true if an experiment has the field: its lab, its scheme and its physics.
bool belongs(const Field& field, const Experiment& experiment);

/// Returns the fields of a scheme's own parameters, "control.extra.NAME", with their values in `values`.
std::vector<Field> extra_fields(std::span<const control::ExtraOption> options, std::string_view scheme,
                                control::ExtraValues& values);

/// Returns the value as TOML: the shortest text that reads back to the same value; canonical (-0.0 is written
/// 0.0).
std::string value_text(const Field& field);

/// Returns "" if the value is within the limits, else the problem: "must lie in (0, 100] mm".
std::string broken_limit(const Field& field);

/// Returns "" if a field of text may hold `word`, else the problem: "must be one of a, b".
std::string broken_word(const Field& field, const std::string& word);

/// Returns "(0, 100]", "one of a, b", or "" for a field without limits, for documentation and messages.
std::string limits_text(const Field& field);

/// Returns "number", "integer", "text", "number or schedule" or "list of numbers".
std::string_view type_text(const Field& field);

}  // namespace firn
