// checksum64 computes XXH64 (seed 0), the checksum of record files, log index and tiles.
// https://github.com/Cyan4973/xxHash/blob/dev/doc/xxhash_spec.md
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace firn::logfile {

std::uint64_t checksum64(std::span<const std::byte> bytes);
/// Returns the checksum of `a` followed by each of `parts`, without joining them.
std::uint64_t checksum64(std::span<const std::byte> a, std::span<const std::span<const std::byte>> parts);

}  // namespace firn::logfile
