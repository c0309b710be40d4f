// checksum64 computes XXH64 (seed 0), the checksum of record files, log index and tiles.
// https://github.com/Cyan4973/xxHash/blob/dev/doc/xxhash_spec.md
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace firn::record {

std::uint64_t checksum64(std::span<const std::byte> bytes);
/// Returns the checksum of `a` followed by each of `parts`, without joining them.
std::uint64_t checksum64(std::span<const std::byte> a, std::span<const std::span<const std::byte>> parts);

/// Returns the checksum of mapped bytes, which are taken from memory as it goes on where `forget` is true.
std::uint64_t checksum64_of_mapped(std::span<const std::byte> mapped, bool forget);

/// The same of bytes that come one part after the other.
class Checksum64 {
 public:
  Checksum64();
  ~Checksum64();
  void add(std::span<const std::byte> bytes);
  std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace firn::record
