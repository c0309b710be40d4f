#include "logfile/checksum.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace firn::logfile {

std::uint64_t checksum64(std::span<const std::byte> bytes) { return XXH64(bytes.data(), bytes.size(), 0); }

std::uint64_t checksum64(std::span<const std::byte> a, std::span<const std::span<const std::byte>> parts) {
  XXH64_state_t state;
  XXH64_reset(&state, 0);
  XXH64_update(&state, a.data(), a.size());
  for (const auto& part : parts)
    if (!part.empty()) XXH64_update(&state, part.data(), part.size());
  return XXH64_digest(&state);
}

}  // namespace firn::logfile
