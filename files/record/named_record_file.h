// NamedRecordFile writes a file of records that receives its name only when complete.
#pragma once

#include <filesystem>
#include <memory>

#include "files/record/part_file.h"
#include "files/record/record_file.h"

namespace firn::record {

/// Writes under a temporary name beside `file`; finish() syncs and renames the file. The destructor removes
/// an unfinished file.
class NamedRecordFile {
 public:
  explicit NamedRecordFile(const std::filesystem::path& file);  ///< @throws FileError
  ~NamedRecordFile();
  NamedRecordFile(const NamedRecordFile&) = delete;
  NamedRecordFile& operator=(const NamedRecordFile&) = delete;

  RecordWriter& records() { return *out_; }       ///< until finish()
  void finish();                                  ///< @throws FileError
  std::uint64_t bytes() const { return bytes_; }  ///< of the finished file

 private:
  std::filesystem::path file_;
  PartFile part_;
  std::unique_ptr<RecordWriter> out_;
  std::uint64_t bytes_ = 0;
};

}  // namespace firn::record
