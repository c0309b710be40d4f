#include "runtime/port_rate.h"

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

// A byte on a serial line is ten bits. Four times the rate of the line: an address may name a faster line,
// and an adapter hands over in pieces.
constexpr double serial(double baud) { return 4.0 * baud / 10.0; }

struct Row {
  std::string_view port;
  double bytes_per_s;
};
constexpr Row kRows[] = {
    {"stage", 1e6},           // replies of some bytes to lines of text, over TCP
    {"robot", 1e6},           // lines of text, over TCP
    {"laser_profiler", 8e6},  // a profile of 3,200 points is 8 kB; a thousand a second
    {"camera", 125e6},        // pictures over a network of 1 Gbit/s
    {"jet", serial(19200)},   // the faster one of the two kinds
    {"jet_b", serial(19200)},
    {"lamp", serial(19200)},
    {"gas", serial(19200)},
    {"heater", serial(9600)},
    {"valve_a", serial(115200)},
    {"valve_b", serial(115200)},
    {"laser_point", serial(115200)},
};
constexpr double kOther = 1e6;    // an instrument without a row
constexpr double kProgram = 1e9;  // a camera's pictures, written out

}  // namespace

PortRate port_rate(std::string_view port) {
  const auto row = std::ranges::find(kRows, port, &Row::port);
  return {row == std::end(kRows) ? kOther : row->bytes_per_s};
}

PortRate port_rate(std::string_view port, const PortAddress& address) {
  return address.kind == PortAddress::Kind::kPython ? PortRate{kProgram} : port_rate(port);
}

RateMeter::RateMeter(PortRate rate)
    : rate_(rate), held_(std::max(kHeld_s * rate.bytes_per_s, kLeastHeld_bytes)) {}

std::string RateMeter::take(std::size_t bytes, std::int64_t wall_us) {
  if (std::isinf(rate_.bytes_per_s)) return {};
  const double passed_s =
      filled_us_ == 0 ? 0.0 : double(std::max<std::int64_t>(0, wall_us - filled_us_)) * 1e-6;
  filled_us_ = wall_us;
  held_ =
      std::min(held_ + passed_s * rate_.bytes_per_s, std::max(kHeld_s * rate_.bytes_per_s, kLeastHeld_bytes));
  if (double(bytes) > held_)
    return "more than the " + std::to_string(std::llround(rate_.bytes_per_s)) +
           " bytes/s came that its instrument can send";
  held_ -= double(bytes);
  return {};
}

}  // namespace firn
