#include "files/record/pages.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <string>
#include <utility>

namespace firn::logfile {
namespace {

constexpr std::size_t kLeastOfFile = std::size_t(32) << 20;

/// @returns an open file of `bytes` without a name, -1 where there is no room for it
int temporary_file(std::size_t bytes) {
  const char* folder = ::getenv("TMPDIR");
  std::string name = std::string(folder && *folder ? folder : "/var/tmp") + "/firn-XXXXXX";
  const int fd = ::mkostemp(name.data(), O_CLOEXEC);
  if (fd < 0) return -1;
  ::unlink(name.c_str());
  if (::posix_fallocate(fd, 0, off_t(bytes)) == 0) return fd;  // a hole could meet a full disk later
  ::close(fd);
  return -1;
}

}  // namespace

Pages::Pages(std::size_t bytes) : bytes_(bytes) {
  if (bytes == 0) return;
  void* at = MAP_FAILED;
  if (const int fd = bytes >= kLeastOfFile ? temporary_file(bytes) : -1; fd >= 0) {
    at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    of_file_ = at != MAP_FAILED;
    ::close(fd);
  }
  if (!of_file_)
    at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (at == MAP_FAILED) throw std::bad_alloc();
  at_ = static_cast<std::byte*>(at);
}

Pages::~Pages() {
  if (at_) ::munmap(at_, bytes_);
}

Pages::Pages(Pages&& other) noexcept
    : at_(std::exchange(other.at_, nullptr)), bytes_(other.bytes_), of_file_(other.of_file_) {}

void Pages::forget(std::size_t from, std::size_t until) const {
  if (of_file_) forget_pages(span(), from, until);
}

void Pages::drop_front(std::size_t bytes) {
  ::munmap(at_, bytes);
  at_ += bytes;
  bytes_ -= bytes;
}

std::size_t Pages::page_bytes() { return std::size_t(::sysconf(_SC_PAGESIZE)); }

std::span<std::byte> Pages::release() { return {std::exchange(at_, nullptr), bytes_}; }

void forget_pages(std::span<const std::byte> mapped, std::size_t from, std::size_t until) {
  const std::size_t page = Pages::page_bytes();
  from = (from + page - 1) / page * page;
  until = std::min(until, mapped.size()) / page * page;
  if (from < until) ::madvise(const_cast<std::byte*>(mapped.data()) + from, until - from, MADV_DONTNEED);
}

}  // namespace firn::logfile
