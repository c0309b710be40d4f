// The table of labs: names the kinds of labs (lab.kind) and holds each kind's keys, processes and checks. A
// new lab is a row here and in the tables that docs/write-a-lab.md lists.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "config/experiment.h"

namespace firn {

struct Field;
class Rules;

/// How a lab builds up a layer: controller, mapper and measures of a print follow from it.
enum class Deposition {
  kDroplets,  ///< droplets on the cells of a grid, a height map after each layer
  kPaths,     ///< beads along the paths of a sliced part, a height map after each interval
};

/// A process that only some labs have.
struct LabProcess {
  std::string_view node;                        ///< name in the channel table
  bool (*wanted)(const Experiment&) = nullptr;  ///< nullptr: in every experiment of the lab
};

struct LabKind {
  std::string_view name;     ///< value of lab.kind
  std::string_view meaning;  ///< in words, for the documentation of lab.kind
  Deposition deposition;
  std::span<const std::string_view> keys;     ///< "section." or a whole key: what the lab's file may say
  std::span<const std::string_view> without;  ///< of these, what it may not say
  std::span<const LabProcess> processes;
  void (*check)(Rules&);  ///< throws ConfigError at the first rule between keys that is broken
  /// Keys of the lab's own sections, behind those of config/fields.cpp; nullptr: none.
  std::vector<Field> (*fields)(Experiment&) = nullptr;
};

/// Every kind of lab; the first one is the default.
std::span<const LabKind* const> lab_kinds();

/// The row of that name. @throws std::invalid_argument naming the kinds that there are
const LabKind& lab_kind(std::string_view name);
const LabKind& lab_of(const Experiment& experiment);

inline bool prints_paths(const Experiment& e) { return lab_of(e).deposition == Deposition::kPaths; }

}  // namespace firn
