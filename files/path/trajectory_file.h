// TrajectoryWriter and TrajectoryReader write and read trajectories: one record per path in the framing of
// files/record/record_file.h. A file is streamed, checked for damage and read with one path in memory.
// Format: docs/formats.md.
#pragma once

#include <filesystem>
#include <optional>

#include "core/path/trajectory_codec.h"
#include "files/record/named_record_file.h"

namespace firn {

/// Kinds of records.
enum class TrajectoryRecord : std::uint16_t { kHead = 32, kPath = 33, kTotals = 34 };

/// Writes under a temporary name beside the file; finish() renames the file. The destructor removes an
/// unfinished file.
class TrajectoryWriter {
 public:
  TrajectoryWriter(const std::filesystem::path& file,
                   const TrajectoryHead& head);  ///< @throws record::FileError
  void add(const PlannedPath& path) {
    add(encode(path), path.trajectory.samples(), path.trajectory.certificate.duration_s);
  }
  /// Adds a path that was encoded elsewhere (by another thread).
  void add(std::span<const std::byte> encoded, std::size_t samples, double duration_s);
  void finish();  ///< @throws record::FileError
  const TrajectoryTotals& totals() const { return totals_; }
  std::uint64_t bytes() const { return out_.bytes(); }

 private:
  record::NamedRecordFile out_;
  TrajectoryTotals totals_;
};

/// Reads a file of TrajectoryWriter. @throws TrajectoryFormatError, record::FileError: no such file, no
/// head, damage (with the byte), a record of an unknown kind, trajectories behind the totals or totals that
/// differ.
class TrajectoryReader {
 public:
  explicit TrajectoryReader(const std::filesystem::path& file);
  explicit TrajectoryReader(std::span<const std::byte> bytes);
  const TrajectoryHead& head() const { return head_; }
  /// Returns the next trajectory, or nothing behind the last. A file without totals is incomplete: the last
  /// call throws.
  std::optional<PlannedPath> next();
  const TrajectoryTotals& totals() const { return seen_; }  ///< of the paths read so far

 private:
  std::optional<record::Record> record();
  void begin();

  std::optional<record::MappedFile> mapped_;
  std::optional<record::RecordReader> in_;
  TrajectoryHead head_;
  TrajectoryTotals seen_;
  bool ended_ = false;
};

}  // namespace firn
