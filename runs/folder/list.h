// RunEntry holds the facts that a list of runs shows of one run folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "runs/folder/documents.h"
#include "runs/folder/notes.h"
#include "runs/folder/run_meta.h"

namespace firn::runs {

struct RunEntry {
  std::filesystem::path folder;
  std::int64_t run_id = 0;
  std::optional<std::int64_t> seed;  ///< of the simulated world
  std::string started_utc, name, scheme, lab;
  std::string
      outcome;  ///< "finished", "stopped safely", …; "running (pid 1234)", "interrupted" without an end
  std::string reason;
  int layers = 0;
  std::optional<RunResult> result;  ///< none: the print has not ended
  RunMeta meta;
  RunNotes notes;
  std::uint64_t bytes = 0;
  bool running = false;
};

/// Returns the facts of one run folder; those that cannot be read are in `reason`.
RunEntry run_entry(const std::filesystem::path& folder);

/// Returns the run folders in `root`, oldest first. Other folders are left out.
/// @throws UsageError: no such folder
std::vector<RunEntry> list_runs(const std::filesystem::path& root);

/// Removes a run folder that nobody uses, if it still is as `seen`: under another name first, so that a kill
/// leaves a run or none.
/// @returns false: it has changed, and stays
/// @throws UsageError: somebody uses it; std::filesystem::filesystem_error
bool remove_run(const RunEntry& seen);

/// Removes the rest of removals in `root` that a kill ended. @throws std::filesystem::filesystem_error
void finish_removals(const std::filesystem::path& root);

}  // namespace firn::runs
