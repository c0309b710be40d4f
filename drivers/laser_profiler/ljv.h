// LjvDialect encodes and frames the commands of the Keyence LJ-V7000, command port TCP 24691, little endian:
// change program (39h) and high-speed profiles (42h): the newest one, or several by number. Layout from two
// public sources that agree (docs/devices/laser_profiler.md). No checksum: lengths, the echoed command and
// the bounds of every field are checked instead.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::ljv {

inline constexpr std::uint8_t kGetErrors = 0x04, kChangeProgram = 0x39, kGetProfile = 0x42;
inline constexpr std::size_t kPrefix = 4, kHeader = 24;  ///< u32 length; header and fixed head of the body
inline constexpr std::size_t kLongestReply = 131'072;    ///< 16 profiles of 3,200 points have 128,512 bytes
inline constexpr int kMaxPoints = 3'200;
inline constexpr int kMaxProfiles = 16;     ///< asked for in one request
inline constexpr double kMmPerUnit = 1e-5;  ///< 0.01 um
/// Sample codes from here up to -524285: no peak, masked, dead zone, still waiting.
inline constexpr std::int32_t kFirstInvalid = -524'288, kLastInvalid = -524'285;

Request change_program(int program);
/// The newest profile; `erase`: the instrument forgets it and those before it.
Request get_newest_profile(bool erase = true);
/// Profiles `first`, first + 1, …, which stay in the instrument. @pre 1 <= count <= kMaxProfiles
Request get_profiles(std::uint32_t first, int count);

/// The errors that the controller holds [V].
Request get_errors();
/// "no error", or the codes, newest first, in hexadecimal. @pre parse_head(frame)
std::string error_text(std::span<const std::byte> frame);

inline constexpr std::uint8_t kNoProfile = 0xA0;  ///< return code of 42h: nothing was measured yet [V]
/// Says what a return code of a command means, "" if no source tells it [V].
std::string_view return_text(std::uint8_t command, std::uint8_t code);

struct Head {
  std::uint8_t command =
      0;  ///< 0 of a reply that is no more than a frame header: it was refused as a frame [V]
  std::uint8_t return_code = 0;  ///< 0 = good; that of the frame header if it is not 0
  std::uint8_t status = 0;
  std::uint8_t program = 0;
};

struct RawProfile {
  std::int32_t points = 0;  ///< 0 = the instrument has not measured yet
  std::uint32_t trigger_count = 0;
  std::int32_t encoder_count = 0;
  double x0_mm = 0.0;
  double dx_mm = 0.0;
  std::vector<float> z_mm;  ///< NaN = no valid sample
};

/// @returns nothing if the frame is shorter than its fields say or a field is out of range; never reads
/// outside it.
std::optional<Head> parse_head(std::span<const std::byte> frame);
/// Which profiles the instrument holds and how many a reply to 42h has.
struct Holdings {
  std::uint32_t newest = 0, oldest = 0, first = 0;  ///< numbers; `first` of this reply
  int profiles = 0;                                 ///< in this reply
};
/// @returns nothing as parse_head, or when the reply has more profiles than bytes for them
std::optional<Holdings> parse_holdings(std::span<const std::byte> frame);
/// Profile `k` of the reply; reuses the storage of `out`. @param samples false: z_mm stays empty
/// @returns false as parse_head.
bool parse_profile(std::span<const std::byte> frame, RawProfile& out, int k = 0, bool samples = true);

/// Sample `n` of the packed 20-bit signed little-endian stream. @pre the stream holds it.
std::int32_t sample20(std::span<const std::byte> data, std::size_t n);

class LjvDialect : public Dialect {
 public:
  LjvDialect();
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
};

LinkProbe link_probe();

}  // namespace firn::drivers::ljv
