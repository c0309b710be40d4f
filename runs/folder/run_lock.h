// RunLock keeps a run folder to one writer, or to readers that need its files to stay as they are.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace firn::runs {

/// Purpose of a process in a run folder.
enum class RunUse : std::uint8_t {
  kPrint,   ///< prints or resumes: writes the records
  kWrite,   ///< packs, expands, repairs, seals: writes the records
  kRead,    ///< needs still records: replay, audit, export, a study of runs
  kReport,  ///< kRead, and writes metrics.csv, the page and their seal
  kNote,    ///< adds notes, which people do during a print too
  kRemove,  ///< removes the folder: nobody else may use it
};

/// Holds the facts that another process is told about the holder of a run folder.
struct RunHolder {
  RunUse use = RunUse::kRead;
  pid_t pid = 0;
  std::string command;  ///< "firn runs pack runs/x"
  std::string host, since_utc;
};
/// Returns "firn runs pack runs/x, pid 1234 on lab3 since 2026-11-28T23:18:28Z".
std::string to_text(const RunHolder& holder);

/// Holds the lock of a run folder from the first look into it to the last rename in it.
///
/// The lock is a set of byte ranges of RUN/lock (fcntl, open file descriptions): the system gives them back
/// when their process has ended, however it ended. Byte 0 stands for the records, byte 1 for the notes, byte
/// 2 for the files that are made from the records; each is locked for one writer or for readers. A holder
/// also locks a page of its own behind them, in which it names itself. The file belongs to the owner of the
/// folder alone (0600), and the last holder removes it. A reader that may not open or make it, as in an
/// archive or in the folder of another user, reads without a lock.
class RunLock {
 public:
  /// Refuses, or waits up to 5 s: the processes of a launcher that has died make the lab safe; a note is
  /// written at once. Unfinished files of earlier holders are removed (trial_files.h).
  /// @throws UsageError "RUN is running (pid 1234): …", "RUN is in use: …"; for a writer, a link or a device
  /// among the files; record::FileError
  RunLock(const std::filesystem::path& run, RunUse use);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  bool try_to_take();
  void name_holder();
  void await_heirs() const;
  void release();

  std::filesystem::path run_;
  RunUse use_;
  std::string since_utc_;
  int folder_ = -1, file_ = -1;
  std::optional<std::uint32_t> page_;  ///< number of the page that names this holder
};

/// Returns the holder who keeps others from a use of the run; nothing: there is none, or the lock cannot be
/// read.
std::optional<RunHolder> holder_against(const std::filesystem::path& run, RunUse use);

}  // namespace firn::runs
