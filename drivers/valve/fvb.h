// FvbDialect encodes and frames FVB/1, the binary protocol between Firn and the firmware of a valve's
// microcontroller (docs/devices/valve.md; the thesis's bytes are not public). `A5 5A | type | seq | length
// u16 | payload | CRC-16`, little endian, the CRC over type .. payload. Nothing here
// allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::fvb {

inline constexpr std::size_t kHead = 6, kTail = 2, kMaxPayload = 512;
inline constexpr std::size_t kMaxEntries = 16384;  ///< of a list: 32 KB [Barnett 2012, 2.3.1]
inline constexpr std::size_t kEntriesPerFrame = (kMaxPayload - 2) / 2;  ///< 255
inline constexpr int kMinPulse_us = 500;                                ///< the valve's manufacturer

/// Requests have the sequence numbers 1 .. 255; as in fvp.h: newer = executed, equal = the reply again, older
/// = NAK 11. HELLO is always executed and begins the count anew.
inline constexpr std::uint8_t next_seq(std::uint8_t seq) { return seq == 255 ? 1 : std::uint8_t(seq + 1); }
inline constexpr bool newer(std::uint8_t seq, std::uint8_t last) {
  const int ahead = (int(seq) - int(last) + 255) % 255;
  return ahead > 0 && ahead <= 127;
}

enum class Type : std::uint8_t {
  kHello = 0x01,  ///< request empty; reply Hello
  kBegin = 0x02,  ///< Begin: forgets the list it had
  kData = 0x03,   ///< u16 offset, u16 ticks …: refused with kOrder unless the offset is the entries held so
                  ///< far or less
  kEnd = 0x04,    ///< u16 CRC of all ticks, little endian bytes
  kArm = 0x05,    ///< u32 longest wait for the trigger, ms; 0 = for ever
  kDisarm = 0x06,  ///< valve closed; a list that was not used up stays loaded, one that was is done
  kStatus = 0x07,  ///< request empty; reply Status
  kAbort = 0x08,   ///< valve closed at once, list forgotten
  kSpit = 0x09,    ///< Begin: that many pulses, one a tick, from now on; forgets the list it had
  kAck = 0x7E,     ///< u16 boot count
  kNak = 0x7F,     ///< u16 boot count, u8 Refusal
};
std::string_view name(Type type);

enum class Refusal : std::uint8_t {
  kBadSeq = 11,
  kWrongState = 20,
  kRange = 21,    ///< entries, tick or pulse outside the firmware's range
  kOrder = 22,    ///< ticks not ascending, or closer than pulse and guard
  kMismatch = 23  ///< END: CRC or number of entries differ from those sent
};
std::string_view name(Refusal refusal);

enum class State : std::uint8_t { kIdle, kLoading, kLoaded, kArmed, kFiring, kDone, kFault };
std::string_view name(State state);

struct Hello {
  std::uint16_t boot_count = 0;
  std::uint16_t firmware = 1;
  std::uint8_t reset_cause = 0;  ///< 0 power, 1 watchdog, 2 pin, 3 brown-out
  // Limits, which firmware 1 does not tell.
  std::uint16_t max_entries = kMaxEntries;  ///< of a list
  std::uint16_t step_us = 0;                ///< edges fall on steps of this length; 0: not told
  std::uint16_t max_pulse_us = 65'535;      ///< longest open time of a pulse
  std::uint8_t max_duty_percent = 100;      ///< of open time in the mean
};
struct Begin {
  std::uint32_t path = 0;
  std::uint8_t valve = 1;  ///< 1 valve_a, 2 valve_b
  std::uint16_t entries = 0;
  std::uint16_t tick_us = 2000;
  std::uint16_t pulse_us = 1250;
};
struct Status {
  std::uint16_t boot_count = 0;
  State state = State::kIdle;
  std::uint32_t path = 0;      ///< of the list held or done
  std::uint16_t next = 0;      ///< pulses fired of it
  std::uint32_t since_us = 0;  ///< since the trigger
  std::uint16_t late_us = 0;   ///< latest pulse against its tick
  bool operator==(const Status&) const = default;
};
struct Reply {  ///< of any type
  Type type = Type::kAck;
  std::uint16_t boot_count = 0;
  std::uint8_t refusal = 0;  ///< of kNak
};

/// Adds a frame to `out`. @pre payload.size() <= kMaxPayload
void encode(Type type, std::uint8_t seq, std::span<const std::byte> payload, std::vector<std::byte>& out);
void encode(std::uint8_t seq, const Begin& begin, std::vector<std::byte>& out);
void encode_data(std::uint8_t seq, std::uint16_t offset, std::span<const std::uint16_t> ticks,
                 std::vector<std::byte>& out);

/// The first frame of a buffer.
struct Found {
  enum class Kind : std::uint8_t {
    kIncomplete,  ///< more bytes are needed
    kFrame,
    kNoise  ///< `size` bytes belong to no frame
  };
  Kind kind = Kind::kIncomplete;
  std::size_t size = 0;
  Type type = Type::kAck;
  std::uint8_t seq = 0;
  std::span<const std::byte> payload;
};
/// Only the first byte of a damaged frame is dropped: a frame inside it is found.
Found find(std::span<const std::byte> buffer);

// Each returns nothing unless the payload has exactly its size and every field its range.
std::optional<Hello> parse_hello(std::span<const std::byte> payload);
std::optional<Status> parse_status(std::span<const std::byte> payload);
std::optional<Reply> parse_reply(const Found& frame);  ///< ACK, NAK, HELLO's and STATUS's

std::uint16_t list_crc(std::span<const std::uint16_t> ticks);

/// kPerson: SPIT, whose Request::tag is the link's (drivers/link/service.h).
enum Format : std::uint8_t { kFrame, kEntries, kPerson };

Request request(Type type, std::uint8_t seq, std::span<const std::byte> payload, Repeat repeat);
Request begin(std::uint8_t seq, const Begin& begin);
Request spit(std::uint8_t seq, const Begin& pulses);
Request number16(Type type, std::uint8_t seq, std::uint16_t value);
Request number32(Type type, std::uint8_t seq, std::uint32_t value, Repeat repeat);
/// Entries [first, first + count) of FvbDialect::ticks, made when it is sent.
Request data(std::uint8_t seq, std::size_t first, std::size_t count);

/// The host's side. Request::tag is the Type, Request::argument the sequence number.
class FvbDialect : public Dialect {
 public:
  FvbDialect();
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
  void write(const Request& request, std::vector<std::byte>& tx) const override;

  std::span<const std::uint16_t> ticks;
};

LinkProbe link_probe();

}  // namespace firn::drivers::fvb
