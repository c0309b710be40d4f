// Pages holds the content of a large file, read only. From 32 MiB on it lies in an unlinked temporary file
// (TMPDIR, else /var/tmp), so that the system can write it out and the process can forget it.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

namespace firn::record {

class Pages {
 public:
  /// @param bytes of the content
  /// @param next returns the next part of the content, empty at its end
  /// @throws std::bad_alloc; std::length_error: the parts have another length
  Pages(std::size_t bytes, const std::function<std::span<const std::byte>()>& next);
  ~Pages();
  Pages(Pages&& other) noexcept;
  Pages& operator=(Pages&&) = delete;

  std::span<const std::byte> span() const { return {at_, bytes_}; }
  bool of_file() const { return of_file_; }
  /// Returns the bytes, which the caller unmaps.
  std::span<const std::byte> release();

 private:
  std::byte* at_ = nullptr;
  std::size_t bytes_;
  bool of_file_ = false;
};

/// Returns an open file without a name (in TMPDIR, else /var/tmp), which the caller closes; -1 where none can
/// be made.
int temporary_file();

/// Takes whole pages of a mapped file's bytes [from, until) out of the process's memory.
void forget_pages(std::span<const std::byte> mapped, std::size_t from, std::size_t until);

}  // namespace firn::record
