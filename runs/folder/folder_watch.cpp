#include "runs/folder/folder_watch.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "files/record/file.h"
#include "files/run_paths.h"
#include "files/text_file.h"

namespace firn::runs {

namespace fs = std::filesystem;

namespace {
constexpr int kLooks = 20, kBetweenLooks_us = 5000;
}  // namespace

FolderWatch::FolderWatch(const fs::path& folder)
    : named_(folder), fd_(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {
  if (fd_ < 0) throw record::FileError(folder, 0, "cannot open folder", errno);
}

FolderWatch::~FolderWatch() { ::close(fd_); }

bool FolderWatch::in_place() const {
  struct stat held {
  }, found{};
  return ::fstat(fd_, &held) == 0 && ::stat(named_.c_str(), &found) == 0 && held.st_dev == found.st_dev &&
         held.st_ino == found.st_ino;
}

fs::path FolderWatch::now() const {
  if (in_place()) return named_;
  struct stat held {};
  if (::fstat(fd_, &held) != 0 || held.st_nlink == 0) return {};
  std::error_code error;
  const fs::path place = fs::read_symlink("/proc/self/fd/" + std::to_string(fd_), error);
  return error || !fs::is_directory(place, error) ? fs::path() : place;
}

std::string FolderWatch::trouble() const {
  std::error_code ignored;
  const std::string name = "the run folder " + named_.string();
  for (int looks = 0; in_place(); ++looks) {
    if (fs::exists(RunPaths(named_).provenance_path(), ignored)) return "";
    if (looks == kLooks) return name + " lost its " + RunPaths::kProvenance;
    ::usleep(kBetweenLooks_us);  // a folder that is being deleted loses its files first
  }
  const fs::path place = now();
  return name + (place.empty() ? " was deleted" : " was moved to " + place.string());
}

std::string storage_trouble(const std::exception& error) {
  if (dynamic_cast<const record::FileError*>(&error) || dynamic_cast<const WriteError*>(&error))
    return error.what();
  const auto* raw = dynamic_cast<const fs::filesystem_error*>(&error);
  return raw ? raw->path1().string() + ": " + raw->code().message() : "";
}

}  // namespace firn::runs
