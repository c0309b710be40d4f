// PortRate holds the bytes that an instrument can send by its own protocol, and RateMeter finds a port that
// sends more: a wrong address, a broken box, a hostile one. Without it such a port would fill the disk and
// the memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "files/port_address.h"

namespace firn {

struct PortRate {
  double bytes_per_s = std::numeric_limits<double>::infinity();

  /// Returns the rate per second of wall time of an instrument whose time runs `scale` times faster.
  PortRate at(double scale) const { return {bytes_per_s * scale}; }
};

/// Returns the rate of the instrument at a port: "stage", "jet_b", in node time. docs/safety.md has
/// the table.
PortRate port_rate(std::string_view port);
/// The same; of the program of a driver class in Python, whose lines may be ten times as long as the bytes of
/// its instrument, that of a program.
PortRate port_rate(std::string_view port, const PortAddress& address);

/// A bucket of bytes that fills at the rate and holds kHeld_s seconds of it, at least kLeastHeld_bytes: so
/// much may have waited in the kernel while the process waited for its disk.
class RateMeter {
 public:
  static constexpr double kHeld_s = 2.0;
  static constexpr double kLeastHeld_bytes = 65536.0;

  explicit RateMeter(PortRate rate = {});
  /// Takes bytes that came. Returns "" or, where they are more than the rate allows, a sentence that says so;
  /// then they are not counted.
  std::string take(std::size_t bytes, std::int64_t wall_us);

 private:
  PortRate rate_;
  double held_ = 0.0;  // bytes that may still come now
  std::int64_t filled_us_ = 0;
};

}  // namespace firn
