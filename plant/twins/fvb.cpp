#include "plant/twins/fvb.h"

#include "plant/twins/lines.h"

namespace firn::plant::fvb {

namespace {

constexpr std::uint8_t kFirst = 0xA5, kSecond = 0x5A;
constexpr std::size_t kBeforePayload = 6, kMaxPayload = 512, kChecksum = 2;

std::uint8_t at(std::span<const std::byte> bytes, std::size_t n) { return std::uint8_t(bytes[n]); }

std::uint32_t little_endian(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (std::size_t n = bytes.size(); n-- > 0;) value = value << 8 | at(bytes, n);
  return value;
}

void append(std::string& bytes, std::uint32_t value, int size) {
  for (int n = 0; n < size; ++n) bytes += char(value >> 8 * n & 255);
}

std::string framed(Kind kind, std::uint8_t number, const std::string& payload) {
  std::string summed;
  append(summed, std::uint8_t(kind), 1);
  append(summed, number, 1);
  append(summed, std::uint32_t(payload.size()), 2);
  summed += payload;
  append(summed, RemainderCcitt().add(summed).value(), 2);
  return std::string{char(kFirst), char(kSecond)} + summed;
}

}  // namespace

Intake take_in(std::span<const std::byte> stream) {
  Intake in;
  while (in.size < stream.size() && at(stream, in.size) != kFirst) ++in.size;
  if (in.size > 0 || stream.size() < 2) return in;
  in.size = 1;  // where the frame turns out to be damaged, the next one may begin within it
  if (at(stream, 1) != kSecond) return in;
  if (stream.size() >= kBeforePayload) {
    const std::size_t length = little_endian(stream.subspan(4, 2));
    if (length > kMaxPayload) return in;
    const std::size_t whole = kBeforePayload + length + kChecksum;
    if (stream.size() >= whole) {
      const auto summed = stream.subspan(2, kBeforePayload - 2 + length);
      const std::string_view text(reinterpret_cast<const char*>(summed.data()), summed.size());
      if (RemainderCcitt().add(text).value() != little_endian(stream.subspan(whole - kChecksum, kChecksum)))
        return in;
      return {whole, true, Kind(at(stream, 2)), at(stream, 3), stream.subspan(kBeforePayload, length)};
    }
  }
  in.size = 0;
  return in;
}

bool is_newer(std::uint8_t number, std::uint8_t last) {
  const int ahead = number > last ? number - last : number - last + 255;
  return number != 0 && number != last && ahead <= 127;
}

std::optional<Head> head_of(std::span<const std::byte> payload) {
  if (payload.size() != 11) return std::nullopt;
  return Head{little_endian(payload.first(4)), at(payload, 4),
              std::uint16_t(little_endian(payload.subspan(5, 2))),
              std::uint16_t(little_endian(payload.subspan(7, 2))),
              std::uint16_t(little_endian(payload.subspan(9, 2)))};
}

std::optional<Part> part_of(std::span<const std::byte> payload) {
  if (payload.size() < 4 || payload.size() % 2 != 0) return std::nullopt;
  Part part{std::uint16_t(little_endian(payload.first(2))), {}};
  for (std::size_t n = 2; n < payload.size(); n += 2)
    part.ticks.push_back(std::uint16_t(little_endian(payload.subspan(n, 2))));
  return part;
}

std::optional<std::uint16_t> checksum_of(std::span<const std::byte> payload) {
  if (payload.size() != 2) return std::nullopt;
  return std::uint16_t(little_endian(payload));
}

std::optional<std::uint32_t> wait_ms_of(std::span<const std::byte> payload) {
  if (payload.size() != 4) return std::nullopt;
  return little_endian(payload);
}

std::uint16_t checksum(std::span<const std::uint16_t> ticks) {
  RemainderCcitt sum;
  for (const std::uint16_t tick : ticks) {
    std::string bytes;
    append(bytes, tick, 2);
    sum.add(bytes);
  }
  return sum.value();
}

std::string hello(std::uint8_t number, std::uint16_t boots, std::uint16_t firmware,
                  std::uint8_t reset_cause) {
  std::string payload;
  append(payload, boots, 2);
  append(payload, firmware, 2);
  append(payload, reset_cause, 1);
  return framed(Kind::kHello, number, payload);
}

std::string status(std::uint8_t number, std::uint16_t boots, const Report& report) {
  std::string payload;
  append(payload, boots, 2);
  append(payload, std::uint8_t(report.state), 1);
  append(payload, report.path, 4);
  append(payload, report.fired, 2);
  append(payload, report.since_trigger_us, 4);
  append(payload, report.latest_us, 2);
  return framed(Kind::kStatus, number, payload);
}

std::string ack(std::uint8_t number, std::uint16_t boots) {
  std::string payload;
  append(payload, boots, 2);
  return framed(Kind::kAck, number, payload);
}

std::string nak(std::uint8_t number, std::uint16_t boots, Nak why) {
  std::string payload;
  append(payload, boots, 2);
  append(payload, std::uint8_t(why), 1);
  return framed(Kind::kNak, number, payload);
}

}  // namespace firn::plant::fvb
