// FolderWatch holds a run folder open and reports if the folder was moved or deleted under a running print.
#pragma once

#include <exception>
#include <filesystem>
#include <string>

namespace firn::runs {

class FolderWatch {
 public:
  explicit FolderWatch(const std::filesystem::path& folder);  ///< @throws record::FileError
  ~FolderWatch();
  FolderWatch(const FolderWatch&) = delete;
  FolderWatch& operator=(const FolderWatch&) = delete;

  /// Returns "the run folder runs/x was moved to runs/y", "… was deleted", "… lost its provenance.json",
  /// or nothing.
  std::string trouble() const;
  /// Returns the folder's present path; empty = deleted.
  std::filesystem::path now() const;

 private:
  bool in_place() const;

  std::filesystem::path named_;
  int fd_ = -1;
};

/// Returns the error's text if it is one of files: "<path>: …: No space left on device"; else nothing.
std::string storage_trouble(const std::exception& error);

}  // namespace firn::runs
