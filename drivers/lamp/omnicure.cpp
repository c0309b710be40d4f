#include "drivers/lamp/omnicure.h"

#include <cctype>

namespace firn::drivers::omnicure {
namespace {

constexpr std::size_t kLongestLine = 80;

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;  // the instrument sends capitals; a flipped bit must not pass as the other case
}

bool digits(std::string_view text) {
  for (const char c : text)
    if (!std::isdigit(static_cast<unsigned char>(c))) return false;
  return !text.empty();
}

}  // namespace

std::uint8_t crc8(std::string_view text) {
  std::uint8_t crc = 0;
  for (const char c : text) {
    crc = std::uint8_t(crc ^ std::uint8_t(c));
    for (int n = 0; n < 8; ++n) crc = std::uint8_t(crc & 1 ? crc >> 1 ^ 0x8C : crc >> 1);
  }
  return crc;
}

std::string frame(std::string_view text) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  const std::uint8_t crc = crc8(text);
  return std::string(text) + kHex[crc >> 4] + kHex[crc & 15] + '\r';
}

Request request(std::string_view text, Format format, Repeat repeat, std::uint16_t tag) {
  Request r;
  r.append(frame(text));
  r.format = format;
  r.repeat = repeat;
  r.tag = tag;
  return r;
}

std::string_view trouble(std::uint32_t status) {
  if (status & kAlarm) return "it has an alarm";
  if (status & kShutterFault) return "its shutter has a fault";
  if (status & kExposureFault) return "it has an exposure fault";
  if (!(status & kBurning)) return "it does not burn";
  return {};
}

OmnicureDialect::OmnicureDialect() : LineDialect('\r', kLongestLine) {
  timeouts.reply_us = 500'000;
  timeouts.read_us = 100'000;
  timeouts.quiet_us = 150'000;
  timeouts.lock_us = 4'000'000;
  timeouts.opening_us = 50'000;
}

std::string_view OmnicureDialect::text(std::span<const std::byte> frame) {
  return {reinterpret_cast<const char*>(frame.data()), frame.size() - 3};
}

std::optional<std::string_view> OmnicureDialect::body(std::string_view line) const {
  const std::size_t end = line.size() - 1;
  if (end < 3) return std::nullopt;
  const std::string_view body = line.substr(0, end - 2);
  const int high = hex_digit(line[end - 2]), low = hex_digit(line[end - 1]);
  return high < 0 || low < 0 || crc8(body) != std::uint8_t(high << 4 | low) ? std::nullopt
                                                                            : std::optional(body);
}

bool OmnicureDialect::answers(std::string_view body, const Request& asked) const {
  if (body.starts_with(table.error)) return true;
  switch (Format(asked.format)) {
    case kReceived:
      return body == table.received;
    case kReady:
      return body == table.ready;
    case kClosed:
      return body.starts_with(table.disconnected);
    case kAny:
      break;
  }
  return digits(body);
}

Request OmnicureDialect::probe() const { return request(table.status, kAny, Repeat::kRead, 0); }

bool is_line(std::string_view s) {
  return s.size() >= 4 && s.back() == '\r' && frame(s.substr(0, s.size() - 3)) == s;
}

LinkProbe link_probe() {
  return {"an OmniCure lamp", frame("CONN"),
          [](std::string_view s) {  // an answer to another line may come before
            return s.size() >= 2 && is_line(s.substr(s.find_last_of('\r', s.size() - 2) + 1));
          },
          '\r'};
}

}  // namespace firn::drivers::omnicure
