// A study's shards as one job array of Slurm: written, submitted, watched and ended with Slurm's own
// commands. The study's folder is shared with the nodes.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "studies/engines/shard_command.h"

namespace firn {

class Slurm {
 public:
  /// @param study_folder has the job's files in `slurm/`: job.sh, job.json and a log of each shard
  explicit Slurm(const std::filesystem::path& study_folder) : folder_(study_folder / "slurm") {}

  /// Returns the most shards that the cluster takes in one array. @throws UsageError: Slurm is not installed,
  /// or its controller does not answer
  int most_shards() const;

  /// Submits an array with a task for each wanted shard, which Slurm starts again where a node dies.
  /// @param partition empty: the cluster's default
  /// @returns the job's number. @throws UsageError with Slurm's words
  std::string submit(const ShardCommand& command, const std::string& partition) const;

  /// Returns the job that was submitted last from this folder.
  std::optional<std::string> job() const;

  /// Returns how many tasks of the job wait, run or are otherwise known to Slurm, by state ("PENDING"); none
  /// once all are over. @throws UsageError: the controller does not answer
  std::map<std::string, int> tasks() const;

  /// @throws UsageError with Slurm's words
  void cancel() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace firn
