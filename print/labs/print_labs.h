// Holds the table of labs as a print uses them: inputs, checks, tolerance, words and report of each kind. The
// rows below this room are listed in docs/write-a-lab.md.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "config/experiment.h"
#include "report/run/report_lab.h"
#include "runtime/node.h"

namespace firn {

/// Holds the words and units in which a print's result is reported.
struct PrintWords {
  std::string_view amount = "droplets";
  std::string_view reference = "target";  ///< of the measured surface
  bool in_mm = false;                     ///< heights in mm with three digits; else in um with two
};

struct PrintLab {
  std::string_view name;  ///< lab.kind
  /// Returns blobs by role from the files that the experiment names.
  /// @param folder of the experiment file
  /// @throws ConfigError, UsageError
  Blobs (*make_inputs)(const Experiment&, const std::filesystem::path& folder);
  /// Sets the keys that follow from the inputs; nullptr: no such keys.
  void (*complete)(Experiment&, const Blobs& inputs);
  /// Refuses inputs that a process would refuse after the start; nullptr: no such inputs.
  void (*check_inputs)(const Experiment&, const Blobs& inputs);
  double (*tolerance_um)(const Experiment&);  ///< of RMS: one nominal layer; 0: no target
  PrintWords words;
  /// Returns an experiment with every process that the lab may have (and inputs for it), for the table of
  /// subscriptions.
  Experiment (*fullest)();
  Blobs (*example_inputs)(const Experiment&);
  const replay::ReportLab* report;
};

/// Returns the labs of this program: all, or those of its own table (print/CMakeLists.txt).
std::span<const PrintLab* const> print_labs();
/// Returns the row of an experiment's lab. @throws std::invalid_argument: lab.kind has no row
const PrintLab& print_lab(const Experiment& experiment);

/// Returns the inputs of a print, by the row of its lab.
Blobs make_inputs(const Experiment& experiment, const std::filesystem::path& folder);
void complete_experiment(Experiment& experiment, const Blobs& inputs);
/// @throws UsageError naming the place in the inputs and the limit
void check_inputs(const Experiment& experiment, const Blobs& inputs);

}  // namespace firn
