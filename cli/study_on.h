// study_on makes the work of a study on other computers: as a job array of Slurm, or by GNU parallel over
// ssh. Both start the command of one shard again and again; journals in the study's folder are all that comes
// back.
#pragma once

#include <filesystem>

#include "cli/make_study.h"

namespace firn {

struct RemoteEnd {
  bool all_on_record = false;  ///< the results can be written
  int code = 0;                ///< of the command, where they cannot
};

/// Submits the missing results, or joins the job that was submitted before, and waits for it with progress.
/// Once the call's `stop` is set a job of Slurm goes on by itself, and shards over ssh end.
/// @throws UsageError: an engine that is none, is not installed or does not answer; a host with another build
RemoteEnd study_on(const StudyOptions& options, const StudyWork& work, const StudyCall& call);

/// Returns the states of the tasks of the study's job, for people; "" where none was submitted, or Slurm is
/// gone.
std::string job_text(const std::filesystem::path& study_folder);

}  // namespace firn
