// The pairs of prints that firn tune --verify holds against its promise, as a study with a folder. The folder
// remembers the settings, so that shards print them and search nothing.
#pragma once

#include <optional>
#include <vector>

#include "cli/tune_lab_command.h"
#include "studies/tune/verify_promise.h"

namespace firn {

/// A command's runs, and the keys that it tunes.
struct TunedRuns {
  const TuneLabOptions& options;
  const std::vector<tune::RecordedRun>& runs;
  const tune::RecordedRun& start;  ///< the print that is repeated
  const std::vector<tune::TuneKey>& keys;
};

/// Returns the settings that the folder of --study remembers of the same question to the same build; none
/// where it does not. @throws UsageError naming the file: it is no record of settings
std::optional<tune::PairSettings> remembered_settings(const TunedRuns& tuned);

/// Remembers them in the folder, if one is named, and makes it. @throws UsageError: it cannot be written
void remember_settings(const TunedRuns& tuned, const tune::PairSettings& settings);

/// Returns the command of one shard, without its number.
std::vector<std::string> pair_words(const TuneLabOptions& options);

}  // namespace firn
