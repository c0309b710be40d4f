#include "drivers/camera/picture_line.h"

#include <algorithm>
#include <cstdio>

#include "core/options/number.h"

namespace firn::drivers::picture_line {
namespace {

constexpr std::size_t kMaxLine = 200;
constexpr std::int64_t kMaxAge_us = 60'000'000;

Request line(const char* text, Repeat repeat, Format format) {
  Request r;
  r.append(std::string_view(text));
  r.append(std::string_view("\n"));
  r.repeat = repeat;
  r.format = format;
  return r;
}

std::string_view verb_of(const Request& request) {
  const std::string_view text = request.text();
  return text.substr(0, text.find_first_of(" \n"));
}

// The next number of `text`, which is taken off. @returns false: none, or outside [low, high]
bool take(std::string_view& text, std::int64_t low, std::int64_t high, std::int64_t& value) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const std::string_view word = text.substr(0, text.find(' '));
  const std::optional<std::int64_t> number = whole_number(word, low, high);
  value = number.value_or(value);
  text.remove_prefix(word.size());
  return number.has_value();
}

std::string_view chars(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Request identify() { return line("ID", Repeat::kRead, kPlain); }

Request set(double exposure_us, double gain_db, double delay_us) {
  char text[100];
  std::snprintf(text, sizeof text, "SET %.3f %.3f %.3f", exposure_us, gain_db, delay_us);
  return line(text, Repeat::kSetup, kPlain);
}

Request snap(std::int32_t number, std::int64_t reply_us) {
  Request r = line(("SNAP " + std::to_string(number)).c_str(), Repeat::kRead, kPicture);
  r.argument = number;
  r.reply_us = reply_us;
  return r;
}

std::optional<Reply> parse(std::string_view line, std::string_view verb) {
  const bool accepted = line.starts_with("OK ");
  if (!accepted && !line.starts_with("NO ")) return std::nullopt;
  line.remove_prefix(3);
  if (!line.starts_with(verb)) return std::nullopt;
  line.remove_prefix(verb.size());
  if (!line.empty() && line.front() != ' ') return std::nullopt;
  line.remove_prefix(std::min<std::size_t>(1, line.size()));
  return Reply{accepted, line};
}

std::optional<Head> parse_head(std::string_view text) {
  std::int64_t number = 0, width = 0, height = 0, white = 0, age_us = 0, bytes = 0, sum = 0;
  if (!take(text, 0, INT32_MAX, number) || !take(text, kMinPicture_px, kMaxPicture_px, width) ||
      !take(text, kMinPicture_px, kMaxPicture_px, height) || !take(text, 1, 65535, white) ||
      !take(text, 0, kMaxAge_us, age_us) || !take(text, 1, std::int64_t(kMaxBytes), bytes) ||
      !take(text, 0, 0xFFFFFFFF, sum) || !text.empty() || bytes != width * height * (white > 255 ? 2 : 1))
    return std::nullopt;
  return Head{std::int32_t(number), std::int32_t(width), std::int32_t(height), std::int32_t(white), age_us,
              std::size_t(bytes),   std::uint32_t(sum)};
}

std::optional<Picture> parse_picture(std::span<const std::byte> frame) {
  const std::string_view text = chars(frame);
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) return std::nullopt;
  const auto reply = parse(text.substr(0, end), "SNAP");
  const auto head = reply && reply->accepted ? parse_head(reply->text) : std::nullopt;
  const auto data = frame.subspan(end + 1);
  if (!head || data.size() != head->bytes || checksum(data) != head->checksum) return std::nullopt;
  Picture p{head->width, head->height, head->white, head->age_us, {}};
  p.pixels.resize(std::size_t(p.width) * std::size_t(p.height));
  if (p.white <= 255)
    std::ranges::transform(data, p.pixels.begin(), [](std::byte b) { return std::uint16_t(b); });
  else
    for (std::size_t i = 0; i < p.pixels.size(); ++i)
      p.pixels[i] = std::uint16_t(std::uint16_t(data[2 * i]) | std::uint16_t(data[2 * i + 1]) << 8);
  return p;
}

std::string encode(std::int32_t number, const Picture& p) {
  const bool wide = p.white > 255;
  std::string pixels;
  pixels.reserve(p.pixels.size() * (wide ? 2 : 1));
  for (const std::uint16_t v : p.pixels) {
    pixels.push_back(char(v & 0xFF));
    if (wide) pixels.push_back(char(v >> 8));
  }
  std::string reply = "OK SNAP";
  const std::uint32_t sum = checksum(std::as_bytes(std::span(pixels)));
  for (const std::int64_t n :
       {std::int64_t(number), std::int64_t(p.width), std::int64_t(p.height), std::int64_t(p.white), p.age_us,
        std::int64_t(pixels.size()), std::int64_t(sum)})
    reply += ' ' + std::to_string(n);
  return reply + '\n' + pixels;
}

std::uint32_t checksum(std::span<const std::byte> bytes) {
  std::uint64_t a = 0, b = 0;
  constexpr std::size_t kBlock = 20'000;  // words whose sums of sums stay below 2^64
  const std::size_t words = (bytes.size() + 1) / 2;
  for (std::size_t from = 0; from < words; from += kBlock) {
    for (std::size_t i = from; i < std::min(words, from + kBlock); ++i) {
      a += std::uint64_t(bytes[2 * i]);
      if (2 * i + 1 < bytes.size()) a += std::uint64_t(bytes[2 * i + 1]) << 8;
      b += a;
    }
    a %= 65535;
    b %= 65535;
  }
  return std::uint32_t(b << 16 | a);
}

PictureLineDialect::PictureLineDialect() {
  timeouts.reply_us = 1'000'000;
  timeouts.read_us = 500'000;
  timeouts.quiet_us = 100'000;
}

Frame PictureLineDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  using Kind = Frame::Kind;
  const std::string_view text = chars(buffer.first(std::min(buffer.size(), kMaxLine + 1)));
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos)
    return buffer.size() > kMaxLine ? Frame{Kind::kCorrupt, buffer.size()} : Frame{};
  const std::size_t size = end + 1;
  const auto snapped = parse(text.substr(0, end), "SNAP");
  if (snapped && snapped->accepted) {
    const auto head = parse_head(snapped->text);
    if (!head) return {Kind::kCorrupt, buffer.size()};
    if (buffer.size() < size + head->bytes) return {};
    const bool asked = awaited && awaited->format == kPicture && awaited->argument == head->number;
    const bool sound = asked && checksum(buffer.subspan(size, head->bytes)) == head->checksum;
    return {sound ? Kind::kReply : Kind::kCorrupt, size + head->bytes};
  }
  if (!awaited) return {Kind::kUnsolicited, size};
  return {parse(text.substr(0, end), verb_of(*awaited)) ? Kind::kReply : Kind::kCorrupt, size};
}

LinkProbe link_probe() {
  return {"a camera behind Firn's picture lines", std::string(identify().text()), [](std::string_view s) {
            return s.ends_with('\n') && (s.starts_with("OK ID") || s.starts_with("NO "));
          }};
}

}  // namespace firn::drivers::picture_line
