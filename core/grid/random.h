// Computes counter-based random numbers: the same key gives the same number on every machine, in any order,
// from any thread. Generator: Philox4x32-10 [Salmon et al., "Parallel random numbers: as easy as 1, 2, 3",
// SC'11].
#pragma once

#include <array>
#include <cstdint>

namespace firn {

using PhiloxBlock = std::array<std::uint32_t, 4>;
PhiloxBlock philox4x32(PhiloxBlock counter, std::array<std::uint32_t, 2> key);

/// Purpose of a draw. Streams of different purposes are independent.
enum class Purpose : std::uint32_t {
  kTest = 1,
  kGreedySearch = 2,
  kDropletSize = 3,
  kDropletPlacement = 4,
  kMissedDroplet = 5,
  kSatellite = 6,
  kNozzleDrift = 7,
  kSensorNoise = 8,
  kDropout = 9,
  kModelVariation = 10,
  kBusFault = 11,
  kKill = 12,
  kInstance = 13,
  kBootstrap = 14,
  kSurface = 15,
  kInstrument = 16,
  kPattern = 17,
  kSeam = 18,
  kDisturbance = 19,
};

/// Key of one draw: (seed, purpose, layer, attempt, cell), so that two runs that print the same droplet see
/// the same disturbance even when everything before it differed (common random numbers).
struct DrawKey {
  std::uint64_t seed = 0;
  Purpose purpose = Purpose::kTest;
  std::uint32_t layer = 0;
  std::uint32_t attempt = 0;
  std::uint32_t cell = 0;
};

std::uint64_t random_bits(const DrawKey& key);
double random_uniform(const DrawKey& key);  ///< in [0, 1), 53 bits
/// Integer in [0, n), exactly uniform up to 2^-32 (multiply-shift). @pre n > 0
std::uint32_t random_below(const DrawKey& key, std::uint32_t n);
/// Standard normal by inversion [Acklam's rational approximation, relative error 1.15e-9]. The tails use log,
/// so plant and tests may use it, nodes may not.
double random_normal(const DrawKey& key);

/// A sequence of draws under one key: draw n has cell = n. For loops that need many numbers in order.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, Purpose purpose, std::uint32_t layer = 0, std::uint32_t attempt = 0)
      : key_{seed, purpose, layer, attempt, 0} {}
  std::uint64_t bits() { return random_bits(next()); }
  double uniform() { return random_uniform(next()); }
  double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  std::uint32_t below(std::uint32_t n) { return random_below(next(), n); }
  double normal() { return random_normal(next()); }

 private:
  DrawKey next() {
    DrawKey k = key_;
    ++key_.cell;
    return k;
  }
  DrawKey key_;
};

}  // namespace firn
