#include "runs/folder/run_lock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>
#include <vector>

#include "core/options/number.h"
#include "files/record/file.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "files/utc_time.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/running.h"
#include "runs/folder/trial_files.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

// Locks that a use takes: of the records, the notes and the files made from the records.
struct Ranges {
  std::array<short, 3> types;  // F_RDLCK, F_WRLCK or F_UNLCK
};
Ranges ranges_of(RunUse use) {
  switch (use) {
    case RunUse::kPrint:
    case RunUse::kWrite:
      return {{F_WRLCK, F_UNLCK, F_UNLCK}};
    case RunUse::kRead:
      return {{F_RDLCK, F_UNLCK, F_UNLCK}};
    case RunUse::kReport:
      return {{F_RDLCK, F_UNLCK, F_WRLCK}};
    case RunUse::kNote:
      return {{F_UNLCK, F_WRLCK, F_UNLCK}};
    case RunUse::kRemove:
      return {{F_WRLCK, F_WRLCK, F_WRLCK}};
  }
  return {};
}

bool conflict(RunUse a, RunUse b) {
  const Ranges ours = ranges_of(a), theirs = ranges_of(b);
  for (std::size_t n = 0; n < ours.types.size(); ++n)
    if (ours.types[n] != F_UNLCK && theirs.types[n] != F_UNLCK &&
        (ours.types[n] == F_WRLCK || theirs.types[n] == F_WRLCK))
      return true;
  return false;
}

bool writes_records(RunUse use) { return ranges_of(use).types[0] == F_WRLCK; }
bool only_reads(RunUse use) { return use == RunUse::kRead || use == RunUse::kReport; }

constexpr std::uint32_t kPages = 64;  // further holders have locks and no name
constexpr off_t kPage_bytes = 512;
constexpr std::size_t kCommandShown = 200;
constexpr int kLockPause_us = 10'000, kLockPauses = 500;  // 5 s
constexpr int kNamelessPauses = 50;                       // a holder names itself right after its lock

off_t page_at(std::uint32_t page) { return off_t(page + 1) * kPage_bytes; }

struct flock range_at(short type, off_t from, off_t bytes) {
  struct flock l {};
  l.l_type = type;
  l.l_whence = SEEK_SET;
  l.l_start = from;
  l.l_len = bytes;
  return l;
}

// @returns errno; EAGAIN: another has it
int lock_range(int fd, short type, off_t from, off_t bytes) {
  struct flock l = range_at(type, from, bytes);
  for (;;) {
    if (::fcntl(fd, F_OFD_SETLK, &l) == 0) return 0;
    if (errno != EINTR) return errno == EACCES ? EAGAIN : errno;
  }
}

bool range_is_locked(int fd, off_t from, off_t bytes) {
  struct flock l = range_at(F_WRLCK, from, bytes);
  return ::fcntl(fd, F_OFD_GETLK, &l) == 0 && l.l_type != F_UNLCK;
}

std::string command_line() {
  std::string line;
  for (const std::string& word : own_command_line())
    line += line.empty() ? fs::path(word).filename().string() : " " + word;
  for (char& c : line)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return line.substr(0, kCommandShown);
}

std::string host_name() {
  std::array<char, 65> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

// Lines: use, pid, host, since, command.
std::optional<RunHolder> read_page(int fd, std::uint32_t page) {
  std::array<char, kPage_bytes> text{};
  const ssize_t n = ::pread(fd, text.data(), text.size(), page_at(page));
  std::vector<std::string> lines(1);
  for (ssize_t k = 0; k < n && text[std::size_t(k)] != 0; ++k)
    if (const char c = text[std::size_t(k)]; c == '\n')
      lines.emplace_back();
    else
      lines.back() += c >= ' ' || c < 0 ? c : '?';
  if (lines.size() != 6) return std::nullopt;
  const std::optional<int> use = whole_number(lines[0], 0, int(RunUse::kRemove));
  if (!use) return std::nullopt;
  return RunHolder{RunUse(*use), whole_number<int>(lines[1]).value_or(-1), lines[4], lines[2], lines[3]};
}

// A holder other than the open file `fd` itself, whose locks never stand in its own way.
std::optional<RunHolder> named_holder(int fd, RunUse use) {
  for (std::uint32_t page = 0; page < kPages; ++page) {
    if (!range_is_locked(fd, page_at(page), kPage_bytes)) continue;
    const auto holder = read_page(fd, page);
    if (holder && conflict(holder->use, use)) return holder;
  }
  return std::nullopt;
}

[[noreturn]] void refuse_second(const fs::path& run, const RunHolder& holder) {
  if (holder.use == RunUse::kPrint)
    throw UsageError(run.string() + " is running (pid " + std::to_string(holder.pid) +
                     "): " + to_text(holder) + "; firn attach shows it, firn ctl commands it");
  throw UsageError(run.string() + " is in use: " + to_text(holder));
}

}  // namespace

std::string to_text(const RunHolder& h) {
  return h.command + ", pid " + std::to_string(h.pid) + " on " + h.host + " since " + h.since_utc;
}

RunLock::RunLock(const fs::path& run, RunUse use) : run_(run), use_(use), since_utc_(utc_now()) {
  if (only_reads(use)) require_run(run);
  folder_ = ::open(run.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_ < 0) throw record::FileError(run, 0, "cannot open folder", errno);
  try {
    for (int pauses = 0; !try_to_take(); ++pauses) {
      const auto holder = holder_against(run, use);
      const bool waits = use == RunUse::kNote || !holder;
      if (holder && (!waits || pauses >= kLockPauses)) refuse_second(run, *holder);
      if (!holder && pauses >= kNamelessPauses)
        throw UsageError(run.string() + " is in use: another process holds " + RunPaths::kLock);
      ::usleep(kLockPause_us);
    }
    if (use == RunUse::kNote) return;
    await_heirs();
    if (writes_records(use) && use != RunUse::kRemove) refuse_links(run);
    if (file_ >= 0) remove_trial_files(run);
  } catch (...) {
    release();
    throw;
  }
}

RunLock::~RunLock() { release(); }

// @returns false: another has it, or has just removed the file
bool RunLock::try_to_take() {
  const fs::path path = run_ / RunPaths::kLock;
  struct stat folder {
  }, held{}, named{};
  if (::fstat(folder_, &folder) != 0) throw record::FileError(run_, 0, "cannot open folder", errno);
  // A reader makes no file that the owner of the folder could not open.
  const bool others = folder.st_uid != ::geteuid();
  const int make = only_reads(use_) && others && ::geteuid() != 0 ? 0 : O_CREAT;
  file_ = ::openat(folder_, RunPaths::kLock, O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | make, 0600);
  if (file_ < 0) {
    if (only_reads(use_) && (errno == EACCES || errno == EPERM || errno == EROFS || errno == ENOENT))
      return true;
    if (errno == ELOOP || errno == ENXIO)
      throw UsageError(path.string() + ": is no regular file, which the lock of a run is");
    throw record::FileError(path, 0, "cannot lock", errno);
  }
  const auto fail = [&](int error) {
    ::close(std::exchange(file_, -1));
    if (error != EAGAIN) throw record::FileError(path, 0, "cannot lock", error);
    return false;
  };
  if (::fstat(file_, &held) != 0) return fail(errno);
  if (!S_ISREG(held.st_mode)) return fail(EINVAL);
  if (others && held.st_uid == ::geteuid() && ::geteuid() == 0)
    if (::fchown(file_, folder.st_uid, folder.st_gid) != 0) return fail(errno);
  const Ranges ranges = ranges_of(use_);
  for (std::size_t n = 0; n < ranges.types.size(); ++n)
    if (ranges.types[n] != F_UNLCK)
      if (const int error = lock_range(file_, ranges.types[n], off_t(n), 1)) return fail(error);
  if (::fstatat(folder_, RunPaths::kLock, &named, AT_SYMLINK_NOFOLLOW) != 0 || named.st_ino != held.st_ino ||
      named.st_dev != held.st_dev)
    return fail(EAGAIN);  // its last holder removed it between the opening and the lock
  for (std::uint32_t page = 0; page < kPages && !page_; ++page)
    if (lock_range(file_, F_WRLCK, page_at(page), kPage_bytes) == 0) page_ = page;
  name_holder();
  return true;
}

void RunLock::name_holder() {
  if (!page_) return;
  std::string text = std::to_string(int(use_)) + "\n" + std::to_string(::getpid()) + "\n" + host_name() +
                     "\n" + since_utc_ + "\n" + command_line() + "\n";
  text.resize(std::size_t(kPage_bytes), '\0');
  // On a full disk the lock holds all the same, without a name.
  [[maybe_unused]] const ssize_t n = ::pwrite(file_, text.data(), text.size(), page_at(*page_));
}

// Drivers that a launcher started hold the lock of the instruments while they make them safe.
void RunLock::await_heirs() const {
  if (use_ == RunUse::kPrint) return;  // waits for them itself (lab_lock.h)
  for (int pauses = 0;; ++pauses) {
    const auto launcher = launcher_of_instruments(run_);
    if (!launcher) return;
    if (pauses >= kLockPauses)
      throw UsageError(run_.string() + " is in use by processes that were started by process " +
                       std::to_string(*launcher));
    ::usleep(kLockPause_us);
  }
}

void RunLock::release() {
  if (file_ >= 0) {
    // Nobody else has a lock: whoever waits for one finds that the file has gone, and makes another.
    if (lock_range(file_, F_WRLCK, 0, 0) == 0) ::unlinkat(folder_, RunPaths::kLock, 0);
    ::close(file_);
  }
  if (folder_ >= 0) ::close(folder_);
  file_ = folder_ = -1;
}

std::optional<RunHolder> holder_against(const fs::path& run, RunUse use) {
  const int fd = ::open((run / RunPaths::kLock).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return std::nullopt;
  auto holder = named_holder(fd, use);
  ::close(fd);
  return holder;
}

}  // namespace firn::runs
