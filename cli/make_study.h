// make_study makes the missing results of a study: here, as one shard, or on other computers. It is the one
// way in which commands and benches run studies.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/study_options.h"
#include "studies/compare/study_work.h"

namespace firn {

struct StudyEnd {
  int code = 0;                           ///< of the program where `journal` is null
  std::unique_ptr<StudyJournal> journal;  ///< every result is in it; null: not all are on record, or none
                                          ///< were asked for
};

struct StudyCall {
  /// The command of a shard: the program and its words, without --shard, --threads, --platform; paths are
  /// absolute.
  std::vector<std::string> words;
  /// Called once before something is made, in the study's folder, but not by shards, which begin at one
  /// moment.
  std::function<void(const std::filesystem::path& folder)> prepare = {};
  const std::atomic<bool>* stop = nullptr;  ///< set while it runs: nothing new is begun
};

/// @param options with a folder in `output` that need not exist, or none: the results are in memory alone
/// @throws UsageError: options that contradict each other; the folder cannot be made; another process is at
/// work on a journal. std::runtime_error naming the file: a result cannot be written
StudyEnd make_study(const StudyOptions& options, const StudyWork& work, const StudyCall& call);

}  // namespace firn
