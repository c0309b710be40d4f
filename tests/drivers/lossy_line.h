// Holds random numbers of the drivers' tests, and a line that loses, damages and delays an instrument's
// bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace firn::drivers::test {

inline std::uint64_t next(std::uint64_t& seed) {
  return (seed = seed * 6364136223846793005u + 1442695040888963407u) >> 33;
}

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// FakeRig::line: of `percent` in a hundred things said, a third is lost, one in three has a bit turned, and
/// the rest comes up to `latest_us` late. @param head turns a bit of the first so many bytes only
inline std::function<std::int64_t(std::string&)> lossy_line(std::uint64_t& seed, std::uint64_t percent,
                                                            std::uint64_t latest_us,
                                                            std::size_t head = std::string::npos) {
  return [&seed, percent, latest_us, head](std::string& said) -> std::int64_t {
    if (next(seed) % 100 >= percent) return 0;
    switch (next(seed) % 3) {
      case 0:
        said.clear();
        return 0;
      case 1:
        said[next(seed) % std::min(head, said.size())] ^= char(1 << next(seed) % 8);
        return 0;
      default:
        return std::int64_t(next(seed) % latest_us);
    }
  };
}

}  // namespace firn::drivers::test
