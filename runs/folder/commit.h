// RunCommit holds a moment of a print in one process to which all of its files can be taken back together:
// the lengths of the files that grow, and the state of the world.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

namespace firn::runs {

/// A print in one process gathers its records in buffers. A kill or a full disk leaves files that end at
/// different moments: nodes that know of droplets which the world does not have. The last commit is the
/// newest moment at which all files agree. RUN/world/commit, text: the number of the commit, whether it has
/// a state of the world, then a length and a name for each file.
class RunCommit {
 public:
  explicit RunCommit(std::filesystem::path run) : run_(std::move(run)) {}

  /// Commits. All buffers were flushed. @param save writes the world's state to the path that it is given;
  /// null: the run has not begun
  /// @throws record::FileError, std::runtime_error, std::filesystem::filesystem_error: the last commit holds
  void commit(const std::function<void(const std::filesystem::path& state)>& save);

  /// Ends the print in this process: RUN/world/state is written, and the files as they are count.
  /// @throws as commit()
  void end(const std::function<void(const std::filesystem::path& state)>& save);

 private:
  std::filesystem::path run_;
  std::uint64_t number_ = 0;
};

/// Takes the files of a run back to its commit, if it has one; RUN/world/state is then that of the commit.
/// Nobody may be printing the run. May be repeated after any failure.
/// @returns true if there was a commit
/// @throws std::runtime_error naming a damaged commit, std::filesystem::filesystem_error
bool roll_back(const std::filesystem::path& run);

/// Removes the files of a run in which no node has handled an event, so that a resume begins it: a print that
/// ended before its START. A run with any event, and a run with damaged files, stays as it is.
/// @returns true if the run begins anew
bool begin_anew(const std::filesystem::path& run);

/// Makes a run ready for a resume, before it is compared with its seals: roll_back, then begin_anew.
/// @returns false if the run begins anew
/// @throws as roll_back
bool ready_to_resume(const std::filesystem::path& run);

}  // namespace firn::runs
