// A study's shards on several computers by GNU parallel over ssh, with the user's own keys and ssh settings.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>

#include "studies/engines/shard_command.h"

namespace firn {

class Parallel {
 public:
  /// @param hosts as parallel's --sshlogin takes them: "HOST,USER@HOST,2/HOST" @param study_folder has a log
  /// of the shards in `parallel/`
  Parallel(const std::filesystem::path& study_folder, std::string hosts)
      : folder_(study_folder), hosts_(std::move(hosts)) {}

  /// Checks that each host answers and runs this build, and whether it sees the study's folder.
  /// @param program firn, at the same path everywhere; `version` as its --version says
  /// @throws UsageError: parallel is missing; naming the host: it does not answer, another build, no program
  void check(const std::string& program, const std::string& version);

  /// Runs all wanted shards and returns when they are over. Journals of hosts that do not see the folder come
  /// back by --return. @returns how many failed; their words are on stderr
  /// @param stop once it is set no further shard is begun, and those at work end
  int run(const ShardCommand& command, const std::atomic<bool>& stop) const;

 private:
  std::filesystem::path folder_;
  std::string hosts_;
  bool shared_ = true;
};

}  // namespace firn
