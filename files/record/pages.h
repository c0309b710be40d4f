// Pages is writable memory for the content of a large file. From 32 MiB on it lies in an unlinked temporary
// file (TMPDIR, else /var/tmp), so that the system can write it out and forget() takes it from the process.
#pragma once

#include <cstddef>
#include <span>

namespace firn::logfile {

class Pages {
 public:
  /// @throws std::bad_alloc
  explicit Pages(std::size_t bytes);
  ~Pages();
  Pages(Pages&& other) noexcept;
  Pages& operator=(Pages&&) = delete;

  std::span<std::byte> span() const { return {at_, bytes_}; }
  bool of_file() const { return of_file_; }
  /// Takes whole pages of [from, until) out of the process's memory; they are read again where they are used.
  /// Does nothing for small memory, which no file holds.
  void forget(std::size_t from, std::size_t until) const;
  /// Gives up the first bytes, a multiple of page_bytes().
  void drop_front(std::size_t bytes);
  static std::size_t page_bytes();
  /// Returns the bytes, which the caller unmaps.
  std::span<std::byte> release();

 private:
  std::byte* at_ = nullptr;
  std::size_t bytes_;
  bool of_file_ = false;
};

/// Takes whole pages of a mapped file's bytes [from, until) out of the process's memory.
void forget_pages(std::span<const std::byte> mapped, std::size_t from, std::size_t until);

}  // namespace firn::logfile
