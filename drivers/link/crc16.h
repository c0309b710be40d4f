// crc16 computes CRC-16/CCITT-FALSE: polynomial 1021h, initial value FFFFh, not reflected: "123456789" ->
// 29B1h. The checksum of the robot's lines, the valve's frames and the heater's lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace firn::drivers {

inline constexpr std::uint16_t kCrc16Start = 0xFFFF;

/// @param crc that of the bytes before, to go on with it.
std::uint16_t crc16(std::span<const std::byte> bytes, std::uint16_t crc = kCrc16Start);
inline std::uint16_t crc16(std::string_view text, std::uint16_t crc = kCrc16Start) {
  return crc16(std::as_bytes(std::span(text.data(), text.size())), crc);
}

/// Four capital hex digits. @param to room for four characters
void put_hex4(char* to, std::uint16_t value);
/// @returns -1 unless `text` is four capital hex digits: a flipped bit must not pass as the other case.
int hex4(std::string_view text);

}  // namespace firn::drivers
