// FolderOfFile opens the files of run folders, and all others, for every reader and writer of files: below
// the folder of a run no link is followed, and regular files alone are opened.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace firn::record {

/// Names of the two files that make a folder one of a run; RunPaths has all names.
inline constexpr const char *kRunExperiment = "experiment.toml", *kRunProvenance = "provenance.json";

struct OpenedFile {
  int fd = -1;                 ///< the caller closes it; -1: not opened
  int error = 0;               ///< errno of the reason
  const char* what = nullptr;  ///< "is a link, which …": where the error says too little
};

/// Holds the folder of a file open, so that the file is opened, renamed and removed in this one folder.
///
/// A run folder may come from anybody. A link in it could name a file of the caller, a pipe would wait for
/// ever, a device has no end. Therefore a file of a run is looked up component by component from the run
/// folder on (openat, O_NOFOLLOW). The path up to the run folder is the caller's own and may have links. A
/// run folder is the outermost of the four folders above a file that has provenance.json and experiment.toml.
class FolderOfFile {
 public:
  explicit FolderOfFile(const std::filesystem::path& file);
  ~FolderOfFile();
  FolderOfFile(const FolderOfFile&) = delete;
  FolderOfFile& operator=(const FolderOfFile&) = delete;

  bool of_run() const { return of_run_; }
  /// Returns the file's name in the folder; of a file that is not of a run, its whole path.
  const std::string& name() const { return name_; }
  /// Opens the file. Never waits for the other end of a pipe, and closes the file in child programs.
  OpenedFile open(int flags, mode_t mode = 0644) const { return open(name_, flags, mode); }
  /// Opens another file of the folder, as name() + ".part".
  OpenedFile open(const std::string& name, int flags, mode_t mode = 0644) const;
  /// Gives the file `from` of the folder the name of the file. @returns errno, 0: done
  int take_place(const std::string& from) const;

 private:
  void enter(const std::filesystem::path& run, const std::filesystem::path& inside);

  std::string name_;
  OpenedFile folder_;
  bool of_run_ = false;
};

/// Returns FolderOfFile(file).open(flags, mode).
OpenedFile open_file(const std::filesystem::path& file, int flags, mode_t mode = 0644);

/// Returns true if the file lies in the folder of a run.
bool is_file_of_run(const std::filesystem::path& file);

}  // namespace firn::record
