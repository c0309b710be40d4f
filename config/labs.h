// The table of labs: names the kinds of labs (lab.kind) and holds each kind's keys, processes and checks. A
// new lab is a row here and in the tables that docs/write-a-lab.md lists.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"

namespace firn {

struct Field;
class Rules;

/// The lab's way of building a layer, which determines controller, mapper and measures of a print.
enum class Deposition {
  kDroplets,  ///< droplets on the cells of a grid, a height map after each layer
  kPaths,     ///< beads along the paths of a sliced part, a height map after each interval
  kLines,     ///< lines of a shuttered, continuous flow, a height map after each layer
};

/// A process that only some labs have.
struct LabProcess {
  std::string_view node;                        ///< name in the channel table
  bool (*wanted)(const Experiment&) = nullptr;  ///< nullptr: in every experiment of the lab
};

/// Holds the words and units in which people read a lab's prints; files for programs have um.
struct LabWords {
  std::string_view amount = "droplets";
  std::string_view reference = "target";  ///< of the measured surface
  bool in_mm = false;                     ///< heights; else in um

  /// Returns a height in three significant digits with its unit.
  std::string length(double um) const;
};

struct LabKind {
  std::string_view name;     ///< value of lab.kind
  std::string_view meaning;  ///< in words, for the documentation of lab.kind
  Deposition deposition;
  std::span<const std::string_view> keys;     ///< "section." or a whole key: keys that the lab's file may set
  std::span<const std::string_view> without;  ///< exceptions among these keys
  std::span<const LabProcess> processes;
  void (*check)(Rules&);  ///< throws ConfigError at the first rule between keys that is broken
  /// Fields of the lab's own sections, appended to those of config/fields.cpp; nullptr: no own fields.
  std::vector<Field> (*fields)(Experiment&) = nullptr;
  /// Instruments that trigger lines couple: all of them are real, or all simulated.
  std::span<const std::string_view> coupled = {};
  LabWords words = {};
};

/// Returns every kind of lab; the first one is the default.
std::span<const LabKind* const> lab_kinds();

/// Returns the row of that name. @throws std::invalid_argument naming the known kinds
const LabKind& lab_kind(std::string_view name);
const LabKind& lab_of(const Experiment& experiment);
/// Returns the words of the lab of that name; those of the first lab for a name without a row.
const LabWords& lab_words(std::string_view name);

inline bool prints_lines(const Experiment& e) { return lab_of(e).deposition == Deposition::kLines; }
inline bool prints_paths(const Experiment& e) { return lab_of(e).deposition == Deposition::kPaths; }

}  // namespace firn
