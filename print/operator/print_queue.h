// PrintQueue is the list of prints that wait for the same lab, and a person's word that its bed is clear.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace firn {

/// A print as `firn print` would be called, and how far it has come.
struct QueuedPrint {
  /// Returns "waits", "began" or "stopped".
  const char* state() const { return began_utc.empty() ? "waits" : run.empty() ? "began" : "stopped"; }

  std::int64_t id = 0;
  std::string experiment;  ///< full path of the file
  std::string digest;      ///< SHA-256 of the file and its includes when it was added
  std::vector<std::string> overrides, meta, accept_bringup;
  std::string bus;            ///< as of --bus
  double tolerance_um = 0.0;  ///< as of --tolerance
  std::string by, added_utc;  ///< who added it, and when
  std::string began_utc;      ///< empty: it waits
  std::string run, why;       ///< where it was stopped: run folder, reason
};

class PrintQueue {
 public:
  /// Adds a print behind all others, or before all that wait: one that has begun stays first.
  /// @returns its number, which no other print gets @throws UsageError: there are kMaxQueued
  std::int64_t add(QueuedPrint print, bool first);
  /// @returns false: there is none of this number
  bool remove(std::int64_t id);
  /// The bed is clear, says a person.
  void clear(const std::string& by);
  /// A print begins. The word is good for one print, and spent before that: a computer that dies asks again.
  /// @returns false, and changes nothing: the print is not the next one any more
  bool begin(std::int64_t id);
  /// The print was refused before it began: it waits again, and the bed is as clear as it was.
  void put_back(std::int64_t id, const std::string& cleared_by);
  /// The print has ended, and leaves the queue; or it was stopped, and stays. @param why empty: ended
  void end(std::int64_t id, const std::string& run, const std::string& why);

  std::int64_t next_id = 1;
  std::vector<QueuedPrint> prints;  ///< the next one first
  /// Who has said that the bed is clear; empty: nobody since the last print began.
  std::string cleared_by, cleared_utc;

 private:
  QueuedPrint* find(std::int64_t id);
};

inline constexpr std::size_t kMaxQueued = 1000;

/// Returns RUNS/queue.json.
std::filesystem::path queue_file(const std::filesystem::path& runs);
/// Returns the queue that the text of a file says. @param name of the file, for errors
/// @throws UsageError naming file and requirement
PrintQueue parse_queue(const std::string& text, const std::string& name);
std::string to_text(const PrintQueue& queue);
/// Returns the queue; an empty one where there is no file.
/// @throws UsageError as parse_queue()
PrintQueue read_queue(const std::filesystem::path& file);

/// Holds RUNS/queue.lock while a queue is changed: no other command changes it meanwhile. The system gives
/// the lock back when its process has ended.
class QueueChange {
 public:
  /// Waits up to 5 s. @throws UsageError: another holds it, or the folder cannot be written
  explicit QueueChange(const std::filesystem::path& file);
  ~QueueChange();
  QueueChange(const QueueChange&) = delete;
  QueueChange& operator=(const QueueChange&) = delete;

  PrintQueue queue;  ///< as it was read

  /// Writes the queue; the earlier one stays until the new one is whole. @throws WriteError
  void save() const;

 private:
  std::filesystem::path file_;
  int lock_ = -1;
};

/// Keeps a second `firn queue start` away while the first one lives.
class QueueTurn {
 public:
  /// @throws UsageError naming the process that has it
  explicit QueueTurn(const std::filesystem::path& file);
  ~QueueTurn();
  QueueTurn(const QueueTurn&) = delete;
  QueueTurn& operator=(const QueueTurn&) = delete;

 private:
  int lock_ = -1;
};

/// Returns the SHA-256 of an experiment file and all its includes. @throws ConfigError
std::string experiment_digest(const std::filesystem::path& experiment);

}  // namespace firn
