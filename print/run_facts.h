// add_facts() completes the result of a print with the facts that the records of its run hold: part,
// overspill, RMS inside and on the rim, use, audit. They are computed here alone and kept in result.json.
#pragma once

#include <string>

#include "runs/folder/documents.h"
#include "runs/folder/run_folder.h"

namespace firn {

/// Adds the facts of a print that has ended. A fact that the records do not hold stays empty; nothing is
/// thrown: a print that ended well does not fail for its description.
void add_facts(const runs::RunFolder& run, const Experiment& experiment, runs::RunResult& result);

/// Returns "cylinder", "mesh gear.stl", "lines antenna.json": the part that an experiment names.
std::string part_name(const Experiment& experiment);

}  // namespace firn
