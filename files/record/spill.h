// Spill keeps blocks of bytes outside the process's memory, LongList the entries of a list that only grows:
// for what a pass over a long run finds and a later pass needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

namespace firn::record {

/// Blocks of one size in an unlinked temporary file (TMPDIR, else /var/tmp); in memory from the first one on
/// that finds no room there. Of one thread at a time.
class Spill {
 public:
  explicit Spill(std::size_t block_bytes) : block_bytes_(block_bytes) {}
  ~Spill();
  Spill(const Spill&) = delete;
  Spill& operator=(const Spill&) = delete;

  std::size_t block_bytes() const { return block_bytes_; }
  /// @param block of block_bytes
  /// @returns its number
  std::size_t put(std::span<const std::byte> block);
  /// @throws std::runtime_error: the file cannot be read
  void get(std::size_t number, std::span<std::byte> block) const;

 private:
  bool write(std::span<const std::byte> block);

  std::size_t block_bytes_;
  int fd_ = -1;
  bool full_ = false;
  std::size_t in_file_ = 0;                  // blocks
  std::deque<std::vector<std::byte>> kept_;  // the blocks behind these
};

/// A list with its last entries, and those around the entry that was read last, in memory. Entries that are
/// read in some order near that of the list cost one read of kBlock of them.
template <class Entry>
class LongList {
  static_assert(std::is_trivially_copyable_v<Entry>);

 public:
  static constexpr std::size_t kBlock = 256;  ///< entries
  static constexpr std::size_t kBlock_bytes = kBlock * sizeof(Entry);

  /// @param spill of blocks of kBlock_bytes; must outlive the list, and may be that of others
  explicit LongList(Spill& spill) : spill_(&spill) {}

  std::size_t size() const { return numbers_.size() * kBlock + last_.size(); }
  bool empty() const { return size() == 0; }
  void push_back(const Entry& entry) {
    last_.push_back(entry);
    if (last_.size() < kBlock) return;
    numbers_.push_back(std::uint32_t(spill_->put(std::as_bytes(std::span(last_)))));
    last_.clear();
  }
  /// Returns the last entry. @pre not empty
  const Entry& back() const { return (*this)[size() - 1]; }
  /// Returns an entry that is valid until the next call. @pre n < size()
  const Entry& operator[](std::size_t n) const {
    const std::size_t block = n / kBlock;
    if (block == numbers_.size()) return last_[n % kBlock];
    if (read_.empty() || block != at_) {
      read_.resize(kBlock);
      spill_->get(numbers_[block], std::as_writable_bytes(std::span(read_)));
      at_ = block;
    }
    return read_[n % kBlock];
  }
  /// Returns the place of the first entry for which `before` is false, by halves; size() if there is none.
  /// @pre the entries for which it is true come first
  template <class Before>
  std::size_t partition_point(const Before& before) const {
    std::size_t n = 0, behind = size();
    while (n < behind) {
      const std::size_t middle = std::midpoint(n, behind);
      if (before((*this)[middle]))
        n = middle + 1;
      else
        behind = middle;
    }
    return n;
  }

 private:
  Spill* spill_;
  std::vector<std::uint32_t> numbers_;  // of the full blocks
  std::vector<Entry> last_;
  mutable std::vector<Entry> read_;  // the block `at_`
  mutable std::size_t at_ = 0;
};

}  // namespace firn::record
