// write_outlines() writes the values of a run's outlines, layer by layer, as a table.
#pragma once

#include <filesystem>
#include <string>

#include "report/export/tables.h"
#include "runs/folder/documents.h"

namespace firn::report {

/// Opens metrics/OUTLINE with a row for each map and each true surface on the target's grid: layer, true or
/// measured, and the values of kOutlineMetrics; NaN: cannot be told. A run without a target, as along paths,
/// has no such table.
/// @param prefix group of the run, "" or "RUN/"
void write_outlines(const std::filesystem::path& run, const runs::ProvenanceDocument& provenance,
                    const std::string& prefix, TableSink& sink);

}  // namespace firn::report
