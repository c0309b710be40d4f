// Replaces the calls of the C library that write, rename and create files, so that they can be refused. The
// one source of a program or a preloaded library that includes this header defines before it:
//   bool watching();                  // false: the next question is not asked
//   bool refuses(const char* path);   // true: the call on this path fails, with the errno that it has set
#pragma once

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>

namespace {

bool refuses(int fd) {
  if (!watching()) return false;
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t n = ::readlink(link, path, sizeof path - 1);
  if (n < 0) return false;
  path[n] = 0;
  return refuses(path);
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int open_like(const char* name, const char* path, int flags, unsigned mode) {
  static auto* const there = real<int(const char*, int)>("access");
  if ((flags & O_CREAT) && there(path, F_OK) != 0 && refuses(path)) return -1;
  return real<int(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* data, size_t size) {
  static auto* const next = real<ssize_t(int, const void*, size_t)>("write");
  return refuses(fd) ? -1 : next(fd, data, size);
}
ssize_t pwritev(int fd, const iovec* parts, int n, off_t at) {
  static auto* const next = real<ssize_t(int, const iovec*, int, off_t)>("pwritev");
  return refuses(fd) ? -1 : next(fd, parts, n, at);
}
int fsync(int fd) {
  static auto* const next = real<int(int)>("fsync");
  return refuses(fd) ? -1 : next(fd);
}
int fdatasync(int fd) {
  static auto* const next = real<int(int)>("fdatasync");
  return refuses(fd) ? -1 : next(fd);
}
int rename(const char* from, const char* to) noexcept {
  static auto* const next = real<int(const char*, const char*)>("rename");
  return refuses(from) ? -1 : next(from, to);
}
int open(const char* path, int flags, ...) {
  std::va_list list;
  va_start(list, flags);
  const unsigned mode = (flags & O_CREAT) ? va_arg(list, unsigned) : 0;
  va_end(list);
  return open_like("open", path, flags, mode);
}
}
