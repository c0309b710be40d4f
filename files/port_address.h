// PortAddress says where the port of an instrument is: in the simulated world, behind TCP, a serial line or a
// Unix socket, at a V4L2 device or a folder of pictures, on a cassette, which plays an instrument's earlier
// answers, or behind a driver class in Python that reaches it itself. Its text stands in a lab file,
// `[devices.NODE] port`, and in the command line of a process.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace firn {

struct PortAddress {
  enum class Kind : std::uint8_t { kSimulated, kTcp, kSerial, kUnix, kCassette, kV4l2, kFolder, kPython };
  enum class Dtr : std::uint8_t {
    kKeep,
    kOn,
    kOff
  };  ///< modem line "data terminal ready" once the line is open

  Kind kind = Kind::kSimulated;
  std::string place;  ///< host, device file, socket, folder or cassette; empty in the simulated world
  int tcp_port = 0;   ///< 1 to 65535
  // Settings of serial lines.
  int baud = 0;
  int data_bits = 8;
  char parity = 'N';  ///< N, E, O
  int stop_bits = 1;
  Dtr dtr = Dtr::kKeep;
  int open_wait_ms = 0;  ///< after opening, before the first byte
  // Settings of V4L2 devices.
  int width_px = 0, height_px = 0;  ///< 0: as the device has them
  std::string format;               ///< "GREY", "Y10", …; empty: the deepest that it has
  double delay_us = 0.0;            ///< of the strobe, as another instrument was set
  /// Modules of the driver class in Python that speaks through this port: name and file of each. Not
  /// part of the text.
  std::vector<std::pair<std::string, std::string>> driver_files = {};

  bool real() const { return kind != Kind::kSimulated && kind != Kind::kCassette && kind != Kind::kFolder; }
  bool pictures() const { return kind == Kind::kV4l2 || kind == Kind::kFolder; }
  bool operator==(const PortAddress&) const = default;
};

/// Serial line and TCP port of a device where an address names none.
struct PortDefaults {
  int tcp_port = 0;  ///< 0: the address must name it
  int baud = 0;      ///< 0: the address must name it
  int open_wait_ms = 0;
};

/// Reads "sim:", "tcp:HOST[:PORT]", "serial:FILE[?baud=N&frame=8N1&dtr=on|off|keep&open_wait_ms=N]",
/// "unix:PATH", "cassette:FILE" (files/cassette.h), and of cameras "v4l2:FILE[?size=WxH&format=F&delay_us=N]"
/// or "folder:PATH"; "python:" is the instrument of a driver class in Python that opens it itself. An IPv6
/// host stands in brackets.
/// @throws std::invalid_argument naming the piece and its required form
PortAddress parse_port_address(std::string_view text, const PortDefaults& defaults = {});

/// Returns the address "unix:PATH".
PortAddress unix_port(std::string path);

/// Returns the text that parse_port_address() reads back to the same address.
std::string to_text(const PortAddress& address);

}  // namespace firn
