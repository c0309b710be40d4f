#include "files/record/open_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace firn::record {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 4;  // folders from a run folder to any of its files, with one to spare
constexpr const char* kLink = "is a link, which is not followed in a run folder";
constexpr const char* kIrregular = "is no regular file, which a run folder holds alone";

bool is_there(const fs::path& path) {
  struct stat s {};
  return ::lstat(path.c_str(), &s) == 0;
}

// Returns the run folder and the rest of the path below it; both empty: the file is not in one.
std::pair<fs::path, fs::path> run_and_rest(const fs::path& file) {
  std::pair<fs::path, fs::path> found;
  fs::path folder = file, rest;
  for (int depth = 0; depth < kDeepest && folder.has_filename(); ++depth) {
    rest = rest.empty() ? folder.filename() : folder.filename() / rest;
    folder = folder.parent_path();
    const fs::path inside = rest.lexically_normal();
    if (*inside.begin() != ".." && is_there(folder / kRunProvenance) && is_there(folder / kRunExperiment))
      found = {folder.empty() ? fs::path(".") : folder, inside};
    if (folder == folder.root_path()) break;
  }
  return found;
}

bool is_link(int folder, const std::string& name) {
  struct stat s {};
  return ::fstatat(folder, name.c_str(), &s, AT_SYMLINK_NOFOLLOW) == 0 && S_ISLNK(s.st_mode);
}

}  // namespace

FolderOfFile::FolderOfFile(const fs::path& file) : name_(file.filename().string()) {
  const auto [run, inside] = run_and_rest(file);
  if (run.empty()) {
    folder_.fd = AT_FDCWD;
    name_ = file.string();
  } else {
    of_run_ = true;
    name_ = inside.filename().string();
    enter(run, inside.parent_path());
  }
}

void FolderOfFile::enter(const fs::path& run, const fs::path& inside) {
  constexpr int kFolder = O_PATH | O_DIRECTORY | O_CLOEXEC;
  folder_.fd = ::open(run.c_str(), kFolder);
  folder_.error = errno;
  for (const fs::path& part : inside) {
    if (folder_.fd < 0) return;
    const int next = ::openat(folder_.fd, part.c_str(), kFolder | O_NOFOLLOW);
    folder_.error = errno;
    if (next < 0 && is_link(folder_.fd, part.string())) {
      folder_.error = ELOOP;
      folder_.what = "is in a linked folder, which is not followed in a run folder";
    }
    ::close(std::exchange(folder_.fd, next));
  }
}

FolderOfFile::~FolderOfFile() {
  if (folder_.fd >= 0) ::close(folder_.fd);
}

OpenedFile FolderOfFile::open(const std::string& name, int flags, mode_t mode) const {
  if (folder_.fd < 0 && folder_.fd != AT_FDCWD) return folder_;
  OpenedFile file;
  const int all = flags | O_CLOEXEC | O_NONBLOCK | (of_run_ ? O_NOFOLLOW : 0);
  file.fd = ::openat(folder_.fd, name.c_str(), all, mode);
  file.error = file.fd < 0 ? errno : 0;
  if (!of_run_) return file;
  struct stat s {};
  if (file.fd < 0) {
    if (file.error == ELOOP) file.what = kLink;
    if (file.error == ENXIO) file.what = kIrregular;
  } else if (::fstat(file.fd, &s) != 0 || !S_ISREG(s.st_mode)) {
    ::close(std::exchange(file.fd, -1));
    file.error = S_ISDIR(s.st_mode) ? EISDIR : EINVAL;
    file.what = kIrregular;
  }
  return file;
}

int FolderOfFile::take_place(const std::string& from) const {
  return ::renameat(folder_.fd, from.c_str(), folder_.fd, name_.c_str()) == 0 ? 0 : errno;
}

OpenedFile open_file(const fs::path& file, int flags, mode_t mode) {
  return FolderOfFile(file).open(flags, mode);
}

bool is_file_of_run(const fs::path& file) { return FolderOfFile(file).of_run(); }

}  // namespace firn::record
