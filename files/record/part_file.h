// PartFile holds the name of an unfinished output, so that a signal which ends the program removes the file.
#pragma once

#include <filesystem>

namespace firn::record {

/// One temporary file, from before its creation until it was renamed or removed. At most 64 names are held at
/// a time; a further one is only not removed by signals.
class PartFile {
 public:
  explicit PartFile(std::filesystem::path path);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void remove() const;  ///< of the file, if there is one

 private:
  std::filesystem::path path_;
  int slot_ = -1;
};

/// From now on SIGINT, SIGTERM and SIGHUP remove the unfinished outputs of this process and end it as they do
/// by default. A signal that the caller's parent ignores stays ignored, and whoever sets a handler later has
/// his own.
void remove_parts_on_signals();

}  // namespace firn::record
