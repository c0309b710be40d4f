#include "runs/folder/running.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "core/options/number.h"
#include "files/record/open_file.h"
#include "files/run_paths.h"
#include "runs/folder/run_lock.h"

namespace firn::runs {

namespace fs = std::filesystem;

std::optional<pid_t> printing_process(const fs::path& run) {
  if (const auto holder = holder_against(run, RunUse::kRead); holder && holder->use == RunUse::kPrint)
    return holder->pid;
  return launcher_of_instruments(run);
}

// The lock of LabLock, which the system gives back however its processes end.
std::optional<pid_t> launcher_of_instruments(const fs::path& run) {
  const record::OpenedFile file = record::open_file(RunPaths(run).instruments_lock_path(), O_RDONLY);
  if (file.fd < 0) return std::nullopt;
  const bool held = ::flock(file.fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  std::array<char, 32> text{};
  const ssize_t n = held ? ::pread(file.fd, text.data(), text.size(), 0) : 0;
  ::close(file.fd);
  if (!held) return std::nullopt;
  std::string_view written(text.data(), std::size_t(std::max<ssize_t>(n, 0)));
  return take_number<pid_t>(written).value_or(0);
}

}  // namespace firn::runs
