// RunEntry holds the facts that a list of runs shows of one run folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace firn {

struct RunEntry {
  std::filesystem::path folder;
  std::string started_utc, name, scheme;
  std::string
      outcome;  ///< "finished", "stopped safely", …; "running (pid 1234)", "interrupted" without an end
  std::string reason;
  int layers = 0;
  std::uint64_t bytes = 0;
  bool running = false;
};

/// Returns the run folders in `root`, oldest first. Other folders are left out.
/// @throws UsageError: no such folder
std::vector<RunEntry> list_runs(const std::filesystem::path& root);

/// Returns true if `word` is in the folder's name, the outcome, its reason or a value of the experiment, in
/// any case of letters.
bool mentions(const RunEntry& run, const std::string& word);

}  // namespace firn
