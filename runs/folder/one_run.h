// Compares the number of a run in its provenance.json with that in its write-ahead files: a document of
// another run beside them would give their numbers a false origin.
#pragma once

#include <filesystem>

namespace firn::runs {

/// @throws UsageError: "provenance.json is of run 5, nodes/stage.wal is of run 7"; nothing is compared while
/// the run has no readable write-ahead file, and one that is of this run is enough
void require_one_run(const std::filesystem::path& run);

}  // namespace firn::runs
