// PrintLab holds a lab as a print uses it: inputs, checks, tolerance and report. The rows below this
// room are listed in docs/write-a-lab.md.
#pragma once

#include <filesystem>
#include <string_view>

#include "config/experiment.h"
#include "print/inputs/mesh_inputs.h"
#include "report/run/report_lab.h"
#include "runtime/node.h"

namespace firn {

struct PrintLab {
  std::string_view name;  ///< lab.kind
  /// Returns blobs by role from the files that the experiment names.
  /// @param folder of the experiment file @param meshes the program's readers, nullptr: none
  /// @throws ConfigError, UsageError
  Blobs (*make_inputs)(const Experiment&, const std::filesystem::path& folder, const MeshInputs* meshes);
  /// Sets the keys that follow from the inputs; nullptr: no such keys.
  void (*complete)(Experiment&, const Blobs& inputs);
  /// Refuses inputs that a process would refuse after the start; nullptr: no such inputs.
  void (*check_inputs)(const Experiment&, const Blobs& inputs);
  double (*tolerance_um)(const Experiment&);  ///< of RMS: one nominal layer; 0: no target
  /// Returns an experiment with every process that the lab may have (and inputs for it), for the table of
  /// subscriptions.
  Experiment (*fullest)();
  Blobs (*example_inputs)(const Experiment&);
  const report::ReportLab* report;
};

}  // namespace firn
