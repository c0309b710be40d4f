#include "print/folder/running.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <string>

#include "files/usage_error.h"

namespace firn {

namespace fs = std::filesystem;

// The lock of LabLock, which the system gives back however the print ends.
std::optional<pid_t> printing_process(const fs::path& run) {
  const fs::path file = run / "io" / "lock";
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return std::nullopt;
  const bool held = ::flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(fd);
  pid_t pid = 0;
  if (!held) return std::nullopt;
  std::ifstream(file) >> pid;
  return pid;
}

void refuse_running(const fs::path& run) {
  if (const auto pid = printing_process(run))
    throw UsageError(run.string() + " is running (pid " + std::to_string(*pid) +
                     "); firn attach shows it, firn ctl commands it");
}

}  // namespace firn
