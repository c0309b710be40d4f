#include "runs/find/run_state.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <span>

#include "files/record/checksum.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "runs/folder/run_folder.h"

namespace firn::runs {
namespace {

// The folder's own time tells of files that are made, renamed and removed in it, as documents are; notes
// grow, and records are packed in a folder of their own. A result may be written by hand.
constexpr std::array kLooked{"", RunPaths::kNodes, RunPaths::kResult, RunPaths::kNotes};

std::int64_t state_at(int place, const std::string& name) {
  std::array<std::int64_t, 4 * kLooked.size()> seen{};
  auto at = seen.begin();
  for (const char* looked : kLooked) {
    struct stat s {};
    const std::string path = *looked ? name + "/" + looked : name;
    if (::fstatat(place, path.c_str(), &s, *looked ? AT_SYMLINK_NOFOLLOW : 0) != 0) s = {};
    *at++ = std::int64_t(s.st_ino);
    *at++ = std::int64_t(s.st_mtim.tv_sec);
    *at++ = std::int64_t(s.st_mtim.tv_nsec);
    *at++ = S_ISREG(s.st_mode) ? std::int64_t(s.st_size) : 0;
  }
  return std::int64_t(record::checksum64(std::as_bytes(std::span(seen))));
}

struct Closed {
  void operator()(DIR* folder) const { ::closedir(folder); }
};

}  // namespace

void each_run_state(const std::filesystem::path& place,
                    const std::function<void(const std::string& name, std::int64_t state)>& use) {
  const std::unique_ptr<DIR, Closed> folder(::opendir(place.c_str()));
  if (!folder)
    throw UsageError(place.string() + ": " + std::strerror(errno) + "; --runs names another folder");
  while (const dirent* entry = ::readdir(folder.get())) {
    const std::string name = entry->d_name;
    if (name == "." || name == ".." ||
        (entry->d_type != DT_DIR && entry->d_type != DT_LNK && entry->d_type != DT_UNKNOWN))
      continue;
    if (!is_unfinished_name(name)) use(name, state_at(::dirfd(folder.get()), name));
  }
}

std::int64_t run_state(const std::filesystem::path& run) { return state_at(AT_FDCWD, run.string()); }

}  // namespace firn::runs
