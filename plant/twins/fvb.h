// Reads requests and writes replies of FVB/1 as a valve's microcontroller does (docs/devices/valve.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace firn::plant::fvb {

inline constexpr std::uint32_t kMaxEntries = 16384, kShortestPulse_us = 500;

enum class Kind : std::uint8_t {
  kHello = 0x01,
  kBegin = 0x02,
  kData = 0x03,
  kEnd = 0x04,
  kArm = 0x05,
  kDisarm = 0x06,
  kStatus = 0x07,
  kAbort = 0x08,
  kSpit = 0x09,
  kAck = 0x7E,
  kNak = 0x7F,
};
enum class State : std::uint8_t { kIdle, kLoading, kLoaded, kArmed, kFiring, kDone, kFault };
enum class Nak : std::uint8_t {
  kNone = 0,
  kNumber = 11,
  kState = 20,
  kRange = 21,
  kOrder = 22,
  kMismatch = 23
};

/// Holds the begin of a byte stream: a request, or bytes that are none.
struct Intake {
  std::size_t size = 0;  ///< bytes to drop from the stream's begin; 0: more bytes have to come
  bool good = false;     ///< false: the dropped bytes are noise or a damaged frame
  Kind kind = Kind::kAck;
  std::uint8_t number = 0;
  std::span<const std::byte> payload;
};
Intake take_in(std::span<const std::byte> stream);

/// True for a number that is ahead of the last one by 1 to 127, where 1 follows 255.
bool is_newer(std::uint8_t number, std::uint8_t last);

/// A list's head, from BEGIN.
struct Head {
  std::uint32_t path = 0;
  std::uint8_t valve = 0;
  std::uint16_t entries = 0, tick_us = 0, pulse_us = 0;
};
std::optional<Head> head_of(std::span<const std::byte> payload);

/// A part of the list, from DATA.
struct Part {
  std::uint16_t offset = 0;
  std::vector<std::uint16_t> ticks;
};
std::optional<Part> part_of(std::span<const std::byte> payload);

std::optional<std::uint16_t> checksum_of(std::span<const std::byte> payload);  ///< from END
std::optional<std::uint32_t> wait_ms_of(std::span<const std::byte> payload);   ///< from ARM
/// CRC of a list's ticks as little-endian bytes, as END must name it.
std::uint16_t checksum(std::span<const std::uint16_t> ticks);

struct Report {
  State state = State::kIdle;
  std::uint32_t path = 0;
  std::uint16_t fired = 0;
  std::uint32_t since_trigger_us = 0;
  std::uint16_t latest_us = 0;  ///< how late the latest pulse was
};
// Frames of the replies.
std::string hello(std::uint8_t number, std::uint16_t boots, std::uint16_t firmware, std::uint8_t reset_cause);
std::string status(std::uint8_t number, std::uint16_t boots, const Report& report);
std::string ack(std::uint8_t number, std::uint16_t boots);
std::string nak(std::uint8_t number, std::uint16_t boots, Nak why);

}  // namespace firn::plant::fvb
