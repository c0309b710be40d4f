#include "drivers/link/crc16.h"

#include <array>

namespace firn::drivers {
namespace {

constexpr std::array<std::uint16_t, 256> kTable = [] {
  std::array<std::uint16_t, 256> table{};
  for (unsigned n = 0; n < 256; ++n) {
    unsigned crc = n << 8;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 0x8000u ? crc << 1 ^ 0x1021u : crc << 1;
    table[n] = std::uint16_t(crc);
  }
  return table;
}();

}  // namespace

std::uint16_t crc16(std::span<const std::byte> bytes, std::uint16_t crc) {
  for (const std::byte b : bytes) crc = std::uint16_t(crc << 8 ^ kTable[(crc >> 8 ^ unsigned(b)) & 0xFFu]);
  return crc;
}

void put_hex4(char* to, std::uint16_t value) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  for (int n = 0; n < 4; ++n) to[n] = kDigits[value >> (12 - 4 * n) & 15];
}

int hex4(std::string_view text) {
  if (text.size() != 4) return -1;
  int value = 0;
  for (const char c : text) {
    const int digit = c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    if (digit < 0) return -1;
    value = value << 4 | digit;
  }
  return value;
}

}  // namespace firn::drivers
