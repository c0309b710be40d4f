// LayerWriter and LayerReader write and read deposition paths: one record per layer in the framing of
// files/record/record_file.h. A file is streamed, checked for damage and read with one layer in memory.
// Format: docs/formats.md.
#pragma once

#include <filesystem>
#include <optional>

#include "core/slice/paths/path_codec.h"
#include "files/record/named_record_file.h"

namespace firn {

/// Kinds of records.
enum class PathRecord : std::uint16_t { kHead = 48, kLayer = 49, kTotals = 50 };

/// Writes under a temporary name beside the file; finish() renames the file. The destructor removes an
/// unfinished file.
class LayerWriter {
 public:
  LayerWriter(const std::filesystem::path& file,
              const slice::PathFileHead& head);  ///< @throws record::FileError
  /// @param encoded the layer, @param use of each material in the layer: made elsewhere, by any thread
  void add(std::span<const std::byte> encoded, const slice::LayerPaths& layer,
           const std::vector<slice::MaterialUse>& use);
  void finish();  ///< @throws record::FileError
  const slice::PathFileTotals& totals() const { return totals_; }
  std::uint64_t bytes() const { return out_.bytes(); }

 private:
  record::NamedRecordFile out_;
  slice::PathFileTotals totals_;
};

/// Reads a file of LayerWriter. @throws FormatError, record::FileError: no such file, no head, damage (with
/// the byte), a record of an unknown kind, layers that do not ascend, totals that differ.
class LayerReader {
 public:
  explicit LayerReader(const std::filesystem::path& file);
  explicit LayerReader(std::span<const std::byte> bytes);
  const slice::PathFileHead& head() const { return head_; }
  /// Returns the next layer, or nothing behind the last. A file without totals is incomplete: the last call
  /// throws.
  std::optional<slice::LayerPaths> next();
  const slice::PathFileTotals& totals() const {
    return seen_;
  }                         ///< of the layers read so far; use only at the end
  double fraction() const;  ///< of the file that has been read

 private:
  std::optional<record::Record> record();
  void begin();
  void finish(const record::Record& totals);

  std::optional<record::MappedFile> mapped_;
  std::span<const std::byte> bytes_;
  std::optional<record::RecordReader> in_;
  slice::PathFileHead head_;
  slice::PathFileTotals seen_;
  std::int32_t last_layer_ = 0;
  bool ended_ = false;
};

}  // namespace firn
