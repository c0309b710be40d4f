#include "tests/print/disk_faults.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <string>

namespace {

bool armed = false;
std::string watched;
std::uint64_t calls_seen = 0, fails_at = 0;
bool keeps_failing = false;

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

bool fails(const char* path) {
  if (!armed || !path || std::strncmp(path, watched.c_str(), watched.size()) != 0) return false;
  ++calls_seen;
  const bool now = fails_at != 0 && (calls_seen == fails_at || (keeps_failing && calls_seen > fails_at));
  if (now) errno = ENOSPC;
  return now;
}

bool fails(int fd) {
  if (!armed) return false;
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t n = ::readlink(link, path, sizeof path - 1);
  if (n < 0) return false;
  path[n] = 0;
  return fails(path);
}

int open_like(const char* name, const char* path, int flags, unsigned mode) {
  static auto* const there = real<int(const char*, int)>("access");
  if ((flags & O_CREAT) && there(path, F_OK) != 0 && fails(path)) return -1;
  return real<int(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* data, size_t size) {
  static auto* const next = real<ssize_t(int, const void*, size_t)>("write");
  return fails(fd) ? -1 : next(fd, data, size);
}
ssize_t pwritev(int fd, const iovec* parts, int n, off_t at) {
  static auto* const next = real<ssize_t(int, const iovec*, int, off_t)>("pwritev");
  return fails(fd) ? -1 : next(fd, parts, n, at);
}
int fsync(int fd) {
  static auto* const next = real<int(int)>("fsync");
  return fails(fd) ? -1 : next(fd);
}
int fdatasync(int fd) {
  static auto* const next = real<int(int)>("fdatasync");
  return fails(fd) ? -1 : next(fd);
}
int rename(const char* from, const char* to) noexcept {
  static auto* const next = real<int(const char*, const char*)>("rename");
  return fails(from) ? -1 : next(from, to);
}
int open(const char* path, int flags, ...) {
  std::va_list list;
  va_start(list, flags);
  const unsigned mode = (flags & O_CREAT) ? va_arg(list, unsigned) : 0;
  va_end(list);
  return open_like("open", path, flags, mode);
}
}

namespace firn::test {

DiskFaults::DiskFaults(const std::filesystem::path& folder, std::uint64_t fails, bool stays) {
  watched = std::filesystem::absolute(folder).string();
  calls_seen = 0;
  fails_at = fails;
  keeps_failing = stays;
  armed = true;
}
DiskFaults::~DiskFaults() { armed = false; }

std::uint64_t DiskFaults::calls() const { return calls_seen; }

}  // namespace firn::test
