// mended_png() makes the checksums of a PNG file's chunks true, so that a changed byte reaches the decoder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace firn::fuzz {

inline std::uint32_t crc32_of(const std::uint8_t* data, std::size_t size) {
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t n = 0; n < size; ++n) {
    crc ^= data[n];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

inline std::uint32_t big_endian(const std::uint8_t* at) {
  return std::uint32_t(at[0]) << 24 | std::uint32_t(at[1]) << 16 | std::uint32_t(at[2]) << 8 | at[3];
}

inline std::vector<std::uint8_t> mended_png(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> file(data, data + size);
  for (std::size_t at = 8; at + 12 <= size;) {
    const std::size_t n = big_endian(&file[at]);
    if (n > size - at - 12) break;
    const std::uint32_t crc = crc32_of(&file[at + 4], n + 4);
    for (std::size_t k = 0; k < 4; ++k) file[at + 8 + n + k] = std::uint8_t(crc >> (24 - 8 * k));
    at += 12 + n;
  }
  return file;
}

}  // namespace firn::fuzz
