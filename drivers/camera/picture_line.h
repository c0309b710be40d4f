// PictureLineDialect encodes and frames Firn's own camera protocol, which the bridges of runtime/camera speak
// for V4L2 devices and folders, and the twin for the simulated camera: one line a request, one line a reply,
// a picture's pixels behind its line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "drivers/camera/picture.h"
#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::picture_line {

/// Largest picture [bytes of its pixels].
inline constexpr std::size_t kMaxBytes = std::size_t(1) << 28;

enum Format : std::uint8_t { kPlain, kPicture };

/// `ID` -> `OK ID <name>`
Request identify();
/// `SET <exposure us> <gain dB> <delay us>` -> `OK SET`
Request set(double exposure_us, double gain_db, double delay_us);
/// `SNAP <number>` -> `OK SNAP <number> <width> <height> <white> <age us> <bytes> <checksum>` and the pixels:
/// rows from the top, 1 byte each, or 2, low byte first, where white > 255. The age is the time from the
/// exposure to the reply.
Request snap(std::int32_t number, std::int64_t reply_us);

struct Reply {
  bool accepted = false;  ///< `OK`; `NO` refuses
  std::string_view text;  ///< behind the verb, or why it was refused
};
/// @param line without its end. @returns nothing for a line that answers another verb
std::optional<Reply> parse(std::string_view line, std::string_view verb);

/// The line of a picture. @returns nothing where a number is missing or outside its limits
struct Head {
  std::int32_t number = 0, width = 0, height = 0, white = 0;
  std::int64_t age_us = 0;
  std::size_t bytes = 0;
  std::uint32_t checksum = 0;
};
std::optional<Head> parse_head(std::string_view text);
/// @param frame a whole reply to snap(). @returns nothing for a checksum that does not agree
std::optional<Picture> parse_picture(std::span<const std::byte> frame);

/// The instrument's reply to snap().
std::string encode(std::int32_t number, const Picture& picture);

/// Fletcher's sum of 16-bit words, modulo 65535.
std::uint32_t checksum(std::span<const std::byte> bytes);

class PictureLineDialect final : public Dialect {
 public:
  PictureLineDialect();
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override { return identify(); }
};

LinkProbe link_probe();

}  // namespace firn::drivers::picture_line
