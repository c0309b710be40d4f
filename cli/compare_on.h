// compare_on makes the prints of a study on other computers: as a job array of Slurm, or by GNU parallel over
// ssh. Both start the command of one shard again and again; journals in the study's folder are all that comes
// back.
#pragma once

#include <atomic>
#include <filesystem>

#include "cli/compare_command.h"
#include "studies/compare/study_runner.h"

namespace firn {

struct RemoteEnd {
  bool all_on_record = false;  ///< the results can be written
  int code = 0;                ///< of the command, where they cannot
};

/// Submits the missing prints, or joins the job that was submitted before, and waits for it with progress.
/// @param stop set: a job of Slurm goes on by itself, shards over ssh end
/// @throws UsageError: an engine that is none, is not installed or does not answer; a host with another build
RemoteEnd compare_on(const CompareOptions& options, const StudyPlan& plan,
                     const std::filesystem::path& folder, StudyPlatforms platforms,
                     const std::atomic<bool>* stop);

/// Returns the states of the tasks of the study's job, for people; "" where none was submitted, or Slurm is
/// gone.
std::string job_text(const std::filesystem::path& study_folder);

}  // namespace firn
