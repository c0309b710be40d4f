// A library to be preloaded into the processes of a live print (LD_PRELOAD): writes below FIRN_TROUBLE_FOLDER
// stall or fail with "no space left on device" as the first byte of the file FIRN_TROUBLE_FILE says, which
// every process maps: s, f, or - (no trouble).
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace {

constexpr char kStalled = 's', kFull = 'f';
constexpr int kLongestStall_ms = 8000;

struct Trouble {
  const char* folder = nullptr;
  volatile const char* state = nullptr;
};

const Trouble& trouble() {
  static const Trouble found = [] {
    Trouble t;
    t.folder = std::getenv("FIRN_TROUBLE_FOLDER");
    const char* file = std::getenv("FIRN_TROUBLE_FILE");
    if (!t.folder || !file) return t;
    const int fd = int(::syscall(SYS_openat, AT_FDCWD, file, O_RDONLY | O_CLOEXEC));
    if (fd < 0) return t;
    void* const page = ::mmap(nullptr, 1, PROT_READ, MAP_SHARED, fd, 0);
    if (page != MAP_FAILED) t.state = static_cast<const char*>(page);
    return t;
  }();
  return found;
}

bool watching() { return trouble().state && *trouble().state != '-'; }

/// Waits while the disk is stalled. @returns whether it is full
bool refuses(const char* path) {
  const Trouble& t = trouble();
  if (!t.state || std::strncmp(path, t.folder, std::strlen(t.folder)) != 0) return false;
  for (int ms = 0; *t.state == kStalled && ms < kLongestStall_ms; ++ms) ::usleep(1000);
  if (*t.state != kFull) return false;
  errno = ENOSPC;
  return true;
}

}  // namespace

#include "tests/support/write_calls.h"
