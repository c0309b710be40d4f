// Squeezer and Restorer write record files shorter and back: without all that follows from the rest of a
// file, which is sync markers, checksums, indices and padding. Bytes that are no valid record stay as they
// are. Both work on a part at a time, so that their memory holds one record. Format: docs/formats.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace firn::record {

/// A payload so long holds a message with an array; short ones are as short packed without their known text.
inline constexpr std::size_t kLongPayload_bytes = 512;

class Squeezer {
 public:
  /// @param plain must outlive the squeezer
  explicit Squeezer(std::span<const std::byte> plain) : plain_(plain) {}

  /// Appends about `bytes` squeezed bytes to `out`, more where a record is longer. @returns false at the end
  bool more(std::vector<std::byte>& out, std::size_t bytes);
  struct Counted {
    std::size_t squeezed = 0;
    std::size_t of_long = 0;  ///< of them in payloads of kLongPayload_bytes and more
  };
  /// Counts about `bytes` squeezed bytes more without writing them. @returns false at the end
  bool count(Counted& counted, std::size_t bytes);
  /// Returns the number of plain bytes that are done.
  std::size_t done() const { return at_; }

 private:
  template <class Sink>
  bool walk(Sink sink, std::size_t full);

  std::span<const std::byte> plain_;
  std::size_t at_ = 0, kept_ = 0;  // bytes from at_ on that stay as they are, and whose item has begun
  std::uint64_t next_ = 0;         // index of the next record
};

class Restorer {
 public:
  /// Appends the plain bytes of the next squeezed ones, as far as they are known, to `plain`. @returns false
  /// if the squeezed bytes are damaged
  bool add(std::span<const std::byte> squeezed, std::vector<std::byte>& plain);
  /// Returns true if the squeezed bytes end here.
  bool whole() const { return kept_ == 0 && item_.empty(); }

 private:
  bool take_item(std::span<const std::byte> item, std::vector<std::byte>& plain);

  std::vector<std::byte> item_;  // the beginning of one
  std::uint64_t kept_ = 0;       // bytes that stay as they are and are still to come
  std::uint64_t next_ = 0;
};

std::vector<std::byte> squeeze_records(std::span<const std::byte> plain);
/// Writes the record file again. @returns false if `squeezed` is damaged or `plain` has another size
bool restore_records(std::span<const std::byte> squeezed, std::span<std::byte> plain);

}  // namespace firn::record
