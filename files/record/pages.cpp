#include "files/record/pages.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace firn::record {
namespace {

constexpr std::size_t kMinOfFile = std::size_t(32) << 20;

// Of `bytes`; -1 where there is no room for them.
int temporary_file_of(std::size_t bytes) {
  const int fd = temporary_file();
  if (fd < 0 || ::posix_fallocate(fd, 0, off_t(bytes)) == 0)
    return fd;  // a hole could meet a full disk later
  ::close(fd);
  return -1;
}

// The room is there already.
void write_all(int fd, std::span<const std::byte> bytes, std::size_t at) {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(fd, bytes.data(), bytes.size(), off_t(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw std::bad_alloc();
    at += std::size_t(n);
    bytes = bytes.subspan(std::size_t(n));
  }
}

}  // namespace

int temporary_file() {
  const char* folder = ::getenv("TMPDIR");
  std::string name = std::string(folder && *folder ? folder : "/var/tmp") + "/firn-XXXXXX";
  const int fd = ::mkostemp(name.data(), O_CLOEXEC);
  if (fd >= 0) ::unlink(name.c_str());
  return fd;
}

Pages::Pages(std::size_t bytes, const std::function<std::span<const std::byte>()>& next) : bytes_(bytes) {
  if (bytes == 0) return;
  const int fd = bytes >= kMinOfFile ? temporary_file_of(bytes) : -1;
  of_file_ = fd >= 0;
  const auto map = [&](int protection, int flags) {
    void* const at = ::mmap(nullptr, bytes, protection, flags, fd, 0);
    if (at != MAP_FAILED) at_ = static_cast<std::byte*>(at);
  };
  if (!of_file_) map(PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE);
  try {
    if (!of_file_ && !at_) throw std::bad_alloc();
    std::size_t at = 0;
    for (auto part = next(); !part.empty(); part = next()) {
      if (part.size() > bytes - at) throw std::length_error("too long");
      if (of_file_)
        write_all(fd, part, at);  // a fault of a page that is written through a mapping costs its zeroing
      else
        std::ranges::copy(part, at_ + at);
      at += part.size();
    }
    if (at != bytes) throw std::length_error("too short");
    if (of_file_) map(PROT_READ, MAP_SHARED);
    if (!at_) throw std::bad_alloc();
  } catch (...) {
    if (fd >= 0) ::close(fd);
    if (at_) ::munmap(at_, bytes_);
    throw;
  }
  if (fd >= 0) ::close(fd);
}

Pages::~Pages() {
  if (at_) ::munmap(at_, bytes_);
}

Pages::Pages(Pages&& other) noexcept
    : at_(std::exchange(other.at_, nullptr)), bytes_(other.bytes_), of_file_(other.of_file_) {}

std::span<const std::byte> Pages::release() { return {std::exchange(at_, nullptr), bytes_}; }

void forget_pages(std::span<const std::byte> mapped, std::size_t from, std::size_t until) {
  const auto page = std::size_t(::sysconf(_SC_PAGESIZE));
  from = (from + page - 1) / page * page;
  until = std::min(until, mapped.size()) / page * page;
  if (from < until) ::madvise(const_cast<std::byte*>(mapped.data()) + from, until - from, MADV_DONTNEED);
}

}  // namespace firn::record
