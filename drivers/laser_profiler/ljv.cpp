#include "drivers/laser_profiler/ljv.h"

#include <array>
#include <cstdio>

namespace firn::drivers::ljv {
namespace {

// Offsets in the command data, which follows prefix and header.
constexpr std::size_t kNewest = 0, kOldest = 4, kFirst = 8, kProfilesRead = 12, kKind = 20, kPoints = 24,
                      kUnit = 26, kX0 = 28, kDx = 32, kProfiles = 36;
// Offsets in one profile: a head, samples filled up to whole words, a word that ends it.
constexpr std::size_t kTrigger = 4, kEncoder = 8, kSamples = 24, kEnd = 4;
constexpr std::size_t kRefused =
    16;  // bytes of a reply to a frame that was not understood: prefix and header [V]
constexpr std::uint8_t kWithLuminance = 0x40;  // 10 bits a point follow the heights [S]
constexpr std::uint32_t kCurrent = 0x0000, kByNumber = 0x0200, kErase = 0x100;

std::uint32_t u32(std::span<const std::byte> b, std::size_t n) {
  return std::uint32_t(b[n]) | std::uint32_t(b[n + 1]) << 8 | std::uint32_t(b[n + 2]) << 16 |
         std::uint32_t(b[n + 3]) << 24;
}

std::uint32_t u16(std::span<const std::byte> b, std::size_t n) {
  return std::uint32_t(b[n]) | std::uint32_t(b[n + 1]) << 8;
}

/// The lowest 20 bits as a signed number.
std::int32_t signed20(std::uint32_t bits) { return std::int32_t(bits << 12) >> 12; }

Request request(std::uint8_t command, std::initializer_list<std::uint32_t> words, Repeat repeat) {
  Request r;
  r.repeat = repeat;
  r.argument = command;
  const auto append = [&](std::uint32_t v) {
    const std::array<std::uint8_t, 4> b{std::uint8_t(v), std::uint8_t(v >> 8), std::uint8_t(v >> 16),
                                        std::uint8_t(v >> 24)};
    r.append(std::as_bytes(std::span(b)));
  };
  const auto n = std::uint32_t(words.size() * 4);
  append(16 + n);
  append(0x00F00001);
  append(0);
  append(4 + n);
  append(command);
  for (const std::uint32_t w : words) append(w);
  return r;
}

}  // namespace

Request change_program(int program) {
  return request(kChangeProgram, {std::uint32_t(program)}, Repeat::kSetup);
}

Request get_newest_profile(bool erase) {
  return request(kGetProfile, {0, kCurrent, 1, erase ? kErase | 1 : 1}, Repeat::kRead);
}

Request get_profiles(std::uint32_t first, int count) {
  return request(kGetProfile, {0, kByNumber, first, std::uint32_t(count)}, Repeat::kRead);
}

Request get_errors() { return request(kGetErrors, {}, Repeat::kRead); }

std::string error_text(std::span<const std::byte> frame) {
  if (frame.size() <= kPrefix + kHeader) return "no error";
  const std::span<const std::byte> body = frame.subspan(kPrefix + kHeader);
  std::string text;
  for (std::size_t n = 0, at = 4; n < std::size_t(body[0]) && at + 2 <= body.size(); ++n, at += 2) {
    char hex[6];
    std::snprintf(hex, sizeof hex, " %04X", unsigned(u16(body, at)));
    text += hex;
  }
  return text.empty() ? "no error" : "errors" + text;
}

std::string_view return_text(std::uint8_t command, std::uint8_t code) {
  constexpr struct {
    std::uint8_t command, code;  // command 0: any
    std::string_view words;
  } kWords[] = {{0, 0x11, "the frame did not end in time"},
                {0, 0x21, "a fixed value of the frame is wrong"},
                {0, 0x22, "a fixed value of the frame is wrong"},
                {0, 0x31, "it knows no such command"},
                {0, 0x32, "the command's length is wrong"},
                {0, 0x41, "not in this state of the controller"},
                {0, 0x42, "a parameter is out of range"},
                {kChangeProgram, 0x80, "its terminals switch the program"},
                {kGetProfile, 0x80, "it is in advanced mode; high-speed mode is needed"},
                {kGetProfile, 0x81, "batch measurement is on"},
                {kGetProfile, kNoProfile, "no profile was measured yet"}};
  for (const auto& row : kWords)
    if ((row.command == 0 || row.command == command) && row.code == code) return row.words;
  return "";
}

std::optional<Head> parse_head(std::span<const std::byte> frame) {
  Head h;
  if (frame.size() == kRefused) {
    h.return_code = std::uint8_t(frame[8]);
    return h;
  }
  if (frame.size() < kPrefix + kHeader) return std::nullopt;
  h.command = std::uint8_t(frame[16]);
  h.return_code = std::uint8_t(frame[8]) != 0 ? std::uint8_t(frame[8]) : std::uint8_t(frame[17]);
  h.status = std::uint8_t(frame[18]);
  h.program = std::uint8_t(frame[24]);
  return h;
}

std::int32_t sample20(std::span<const std::byte> data, std::size_t n) {
  const std::size_t bit = 20 * n, byte = bit / 8;
  const std::uint32_t window =
      std::uint32_t(data[byte]) | std::uint32_t(data[byte + 1]) << 8 | std::uint32_t(data[byte + 2]) << 16;
  return signed20(window >> (bit % 8));
}

std::optional<Holdings> parse_holdings(std::span<const std::byte> frame) {
  if (frame.size() < kPrefix + kHeader) return std::nullopt;
  const std::span<const std::byte> data = frame.subspan(kPrefix + kHeader);
  if (data.empty()) return Holdings{};  // nothing measured yet
  if (data.size() <= kProfilesRead) return std::nullopt;
  const Holdings h{u32(data, kNewest), u32(data, kOldest), u32(data, kFirst),
                   std::int32_t(std::uint8_t(data[kProfilesRead]))};
  if (h.profiles > 0 && data.size() < kProfiles + std::size_t(h.profiles) * (kSamples + kEnd))
    return std::nullopt;
  return h;
}

bool parse_profile(std::span<const std::byte> frame, RawProfile& out, int k, bool wanted) {
  out.points = 0;
  out.z_mm.clear();
  if (frame.size() < kPrefix + kHeader) return false;
  const std::span<const std::byte> data = frame.subspan(kPrefix + kHeader);
  if (data.size() <= kProfilesRead) return data.empty();  // nothing measured yet, told by an empty body
  if (k >= std::int32_t(std::uint8_t(data[kProfilesRead]))) return k == 0;
  if (data.size() < kUnit) return false;
  const std::uint32_t points = u16(data, kPoints);
  if (points == 0) return true;
  if (points > std::uint32_t(kMaxPoints)) return false;
  // No source tells the padding of luminance: of such a reply only the first profile is read.
  if (k > 0 && (std::uint8_t(data[kKind]) & kWithLuminance) != 0) return false;
  const std::size_t bytes = (points * 20 + 7) / 8;
  const std::size_t at = kProfiles + std::size_t(k) * (kSamples + (bytes + 3) / 4 * 4 + kEnd);
  if (data.size() < at + kSamples + bytes) return false;
  const auto dx = std::int32_t(u32(data, kDx));
  if (dx <= 0) return false;
  out.x0_mm = std::int32_t(u32(data, kX0)) * kMmPerUnit;
  out.dx_mm = dx * kMmPerUnit;
  out.trigger_count = u32(data, at + kTrigger);
  out.encoder_count = std::int32_t(u32(data, at + kEncoder));
  out.points = std::int32_t(points);
  if (!wanted) return true;
  const double unit_mm = u16(data, kUnit) * kMmPerUnit;
  const std::span<const std::byte> samples = data.subspan(at + kSamples);
  out.z_mm.resize(points);
  const auto put = [&](std::size_t n, std::int32_t v) {
    out.z_mm[n] = v <= kLastInvalid ? std::numeric_limits<float>::quiet_NaN() : float(v * unit_mm);
  };
  // Two points fill five bytes.
  std::size_t n = 0;
  for (std::size_t five = 0; n + 1 < points; n += 2, five += 5) {
    const std::uint32_t low = u32(samples, five), high = std::uint32_t(samples[five + 4]);
    put(n, signed20(low));
    put(n + 1, signed20(low >> 20 | high << 12));
  }
  if (n < points) put(n, sample20(samples, n));
  return true;
}

LjvDialect::LjvDialect() {
  timeouts.reply_us = 500'000;
  timeouts.read_us = 200'000;
  timeouts.quiet_us = 100'000;
  timeouts.lock_us = 3'000'000;
}

Frame LjvDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  if (buffer.size() < kPrefix) return {};
  const std::size_t length = u32(buffer, 0);  // of the rest; untrusted
  const bool refused = length == kRefused - kPrefix;
  if ((length < kHeader && !refused) || length > kLongestReply) return {Frame::Kind::kCorrupt, buffer.size()};
  if (buffer.size() >= kRefused && u32(buffer, 12) + 12 != length)
    return {Frame::Kind::kCorrupt, buffer.size()};
  if (buffer.size() < kPrefix + length) return {};
  const std::size_t size = kPrefix + length;
  if (!awaited) return {Frame::Kind::kUnsolicited, size};
  const auto head = parse_head(buffer.first(size));
  const bool own = head && (refused ? head->return_code != 0 : head->command == awaited->argument);
  return {own ? Frame::Kind::kReply : Frame::Kind::kCorrupt, size};
}

Request LjvDialect::probe() const { return get_newest_profile(); }

LinkProbe link_probe() {
  return {"a Keyence LJ-V profiler", std::string(get_newest_profile(false).text()),
          [](std::string_view s) { return is_whole_reply(LjvDialect(), get_newest_profile(false), s); }};
}

}  // namespace firn::drivers::ljv
