// A library to be preloaded into the processes of a live print (LD_PRELOAD): writes below FIRN_TROUBLE_FOLDER
// stall or fail with "no space left on device" as the first byte of the file FIRN_TROUBLE_FILE says
// (tests/live/disk_trouble.h), which every process maps.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
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

/// Waits while the disk is stalled. @returns whether it is full
bool meets_trouble(const char* path) {
  const Trouble& t = trouble();
  if (!t.state || std::strncmp(path, t.folder, std::strlen(t.folder)) != 0) return false;
  for (int ms = 0; *t.state == kStalled && ms < kLongestStall_ms; ++ms) ::usleep(1000);
  if (*t.state != kFull) return false;
  errno = ENOSPC;
  return true;
}

bool meets_trouble(int fd) {
  if (!trouble().state || *trouble().state == '-') return false;
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t n = ::readlink(link, path, sizeof path - 1);
  if (n < 0) return false;
  path[n] = 0;
  return meets_trouble(path);
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int open_like(const char* name, const char* path, int flags, unsigned mode) {
  static auto* const there = real<int(const char*, int)>("access");
  if ((flags & O_CREAT) && there(path, F_OK) != 0 && meets_trouble(path)) return -1;
  return real<int(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* data, size_t size) {
  static auto* const next = real<ssize_t(int, const void*, size_t)>("write");
  return meets_trouble(fd) ? -1 : next(fd, data, size);
}
ssize_t pwritev(int fd, const iovec* parts, int n, off_t at) {
  static auto* const next = real<ssize_t(int, const iovec*, int, off_t)>("pwritev");
  return meets_trouble(fd) ? -1 : next(fd, parts, n, at);
}
int fsync(int fd) {
  static auto* const next = real<int(int)>("fsync");
  return meets_trouble(fd) ? -1 : next(fd);
}
int fdatasync(int fd) {
  static auto* const next = real<int(int)>("fdatasync");
  return meets_trouble(fd) ? -1 : next(fd);
}
int rename(const char* from, const char* to) noexcept {
  static auto* const next = real<int(const char*, const char*)>("rename");
  return meets_trouble(from) ? -1 : next(from, to);
}
int open(const char* path, int flags, ...) {
  std::va_list list;
  va_start(list, flags);
  const unsigned mode = (flags & O_CREAT) ? va_arg(list, unsigned) : 0;
  va_end(list);
  return open_like("open", path, flags, mode);
}
}
