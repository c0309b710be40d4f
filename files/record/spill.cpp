#include "files/record/spill.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

#include "files/record/pages.h"

namespace firn::record {

Spill::~Spill() {
  if (fd_ >= 0) ::close(fd_);
}

// A block that is written in part lies behind the last whole one, where nobody reads.
bool Spill::write(std::span<const std::byte> block) {
  if (fd_ < 0) fd_ = temporary_file();
  std::size_t at = in_file_ * block_bytes_;
  while (fd_ >= 0 && !block.empty()) {
    const ssize_t n = ::pwrite(fd_, block.data(), block.size(), off_t(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += std::size_t(n);
    block = block.subspan(std::size_t(n));
  }
  return fd_ >= 0;
}

std::size_t Spill::put(std::span<const std::byte> block) {
  full_ = full_ || !write(block);
  if (!full_) return in_file_++;
  kept_.emplace_back(block.begin(), block.end());
  return in_file_ + kept_.size() - 1;
}

void Spill::get(std::size_t number, std::span<std::byte> block) const {
  if (number >= in_file_) {
    std::ranges::copy(kept_[number - in_file_], block.begin());
    return;
  }
  std::size_t at = number * block_bytes_;
  while (!block.empty()) {
    const ssize_t n = ::pread(fd_, block.data(), block.size(), off_t(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      throw std::runtime_error("a temporary file cannot be read: " +
                               std::generic_category().message(n < 0 ? errno : EIO));
    at += std::size_t(n);
    block = block.subspan(std::size_t(n));
  }
}

}  // namespace firn::record
