#include "core/grid/random.h"

namespace firn {

PhiloxBlock philox4x32(PhiloxBlock c, std::array<std::uint32_t, 2> k) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t(0xD2511F53u) * c[0];
    const std::uint64_t p1 = std::uint64_t(0xCD9E8D57u) * c[2];
    c = {std::uint32_t(p1 >> 32) ^ c[1] ^ k[0], std::uint32_t(p1), std::uint32_t(p0 >> 32) ^ c[3] ^ k[1],
         std::uint32_t(p0)};
    k[0] += 0x9E3779B9u;
    k[1] += 0xBB67AE85u;
  }
  return c;
}

std::uint64_t random_bits(const DrawKey& key) {
  const PhiloxBlock out = philox4x32({key.cell, key.attempt, key.layer, std::uint32_t(key.purpose)},
                                     {std::uint32_t(key.seed), std::uint32_t(key.seed >> 32)});
  return std::uint64_t(out[0]) | std::uint64_t(out[1]) << 32;
}

double random_uniform(const DrawKey& key) { return double(random_bits(key) >> 11) * 0x1p-53; }

std::uint32_t random_below(const DrawKey& key, std::uint32_t n) {
  return std::uint32_t((std::uint64_t(std::uint32_t(random_bits(key))) * n) >> 32);
}

}  // namespace firn
