#include "files/port_address.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "core/options/number.h"

namespace firn {
namespace {

constexpr std::array<std::string_view, 6> kPixelFormats{"GREY", "Y10", "Y12", "Y16", "YUYV", "MJPG"};
constexpr std::array kBauds{300, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600};

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  throw std::invalid_argument("port '" + std::string(text) + "': " + why);
}

int number(std::string_view text, std::string_view piece, const char* name, int low, int high) {
  const std::optional<int> v = whole_number(piece, low, high);
  if (!v)
    refuse(text, std::string(name) + " '" + std::string(piece) + "' must be a whole number in [" +
                     std::to_string(low) + ", " + std::to_string(high) + "]");
  return *v;
}

void check_place(std::string_view text, std::string_view place, const char* what) {
  if (place.empty()) refuse(text, std::string("names no ") + what);
  for (const char c : place)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      refuse(text, std::string("has a control character in its ") + what);
}

PortAddress tcp(std::string_view text, std::string_view rest, const PortDefaults& defaults) {
  PortAddress a;
  a.kind = PortAddress::Kind::kTcp;
  std::string_view port;
  if (rest.starts_with("[")) {
    const std::size_t end = rest.find(']');
    if (end == std::string_view::npos) refuse(text, "the bracket of its host is not closed");
    a.place = rest.substr(1, end - 1);
    port = rest.substr(end + 1);
    if (!port.empty() && !port.starts_with(":")) refuse(text, "must be tcp:[HOST]:PORT");
    port.remove_prefix(std::min<std::size_t>(1, port.size()));
  } else {
    const std::size_t colon = rest.find(':');
    if (colon != rest.rfind(':')) refuse(text, "an IPv6 host stands in brackets");
    a.place = rest.substr(0, colon);
    if (colon != std::string_view::npos) port = rest.substr(colon + 1);
  }
  check_place(text, a.place, "host");
  if (port.empty() && defaults.tcp_port == 0) refuse(text, "must be tcp:HOST:PORT");
  a.tcp_port = port.empty() ? defaults.tcp_port : number(text, port, "port", 1, 65535);
  return a;
}

void take_frame(PortAddress& a, std::string_view text, std::string_view frame) {
  const bool good = frame.size() == 3 && (frame[0] == '7' || frame[0] == '8') &&
                    (frame[1] == 'N' || frame[1] == 'E' || frame[1] == 'O') &&
                    (frame[2] == '1' || frame[2] == '2');
  if (!good) refuse(text, "frame '" + std::string(frame) + "' must be 7 or 8, N, E or O, 1 or 2, as 8N1");
  a.data_bits = frame[0] - '0';
  a.parity = frame[1];
  a.stop_bits = frame[2] - '0';
}

/// Takes the device file and hands each "name=value" behind its '?' to `take`, which returns false for a name
/// that it does not know.
template <class Take>
void read_options(PortAddress& a, std::string_view text, std::string_view rest, const char* known,
                  Take take) {
  const std::size_t query = rest.find('?');
  a.place = rest.substr(0, query);
  check_place(text, a.place, "device file");
  std::string_view options = query == std::string_view::npos ? "" : rest.substr(query + 1);
  while (!options.empty()) {
    const std::string_view option = options.substr(0, options.find('&'));
    options.remove_prefix(std::min(options.size(), option.size() + 1));
    const std::size_t equals = option.find('=');
    if (!take(option.substr(0, equals),
              equals == std::string_view::npos ? std::string_view() : option.substr(equals + 1)))
      refuse(text, "option '" + std::string(option) + "' is none of " + known);
  }
}

PortAddress serial(std::string_view text, std::string_view rest, const PortDefaults& defaults) {
  PortAddress a;
  a.kind = PortAddress::Kind::kSerial;
  a.baud = defaults.baud;
  a.open_wait_ms = defaults.open_wait_ms;
  const auto take = [&](std::string_view name, std::string_view value) {
    if (name == "baud")
      a.baud = number(text, value, "baud", 300, 921600);
    else if (name == "frame")
      take_frame(a, text, value);
    else if (name == "open_wait_ms")
      a.open_wait_ms = number(text, value, "open_wait_ms", 0, 10000);
    else if (name == "dtr" && (value == "on" || value == "off" || value == "keep"))
      a.dtr = value == "on"    ? PortAddress::Dtr::kOn
              : value == "off" ? PortAddress::Dtr::kOff
                               : PortAddress::Dtr::kKeep;
    else
      return false;
    return true;
  };
  read_options(a, text, rest, "baud=N, frame=8N1, dtr=on|off|keep, open_wait_ms=N", take);
  if (a.baud == 0) refuse(text, "must name its speed, as serial:/dev/ttyUSB0?baud=9600");
  bool known = false;
  for (const int baud : kBauds) known = known || baud == a.baud;
  if (!known) refuse(text, "baud " + std::to_string(a.baud) + " is no usual speed (300 to 921600)");
  return a;
}

void take_size(PortAddress& a, std::string_view text, std::string_view size) {
  const std::size_t x = size.find('x');
  if (x == std::string_view::npos) refuse(text, "size '" + std::string(size) + "' must be as 1280x960");
  a.width_px = number(text, size.substr(0, x), "width", 16, 16384);
  a.height_px = number(text, size.substr(x + 1), "height", 16, 16384);
}

PortAddress v4l2(std::string_view text, std::string_view rest) {
  PortAddress a;
  a.kind = PortAddress::Kind::kV4l2;
  const auto take = [&](std::string_view name, std::string_view value) {
    if (name == "size")
      take_size(a, text, value);
    else if (name == "delay_us")
      a.delay_us = number(text, value, "delay_us", 0, 1'000'000);
    else if (name == "format" && std::ranges::find(kPixelFormats, value) != kPixelFormats.end())
      a.format = value;
    else
      return false;
    return true;
  };
  read_options(a, text, rest, "size=WxH, format=GREY|Y10|Y12|Y16|YUYV|MJPG, delay_us=N", take);
  return a;
}

}  // namespace

PortAddress parse_port_address(std::string_view text, const PortDefaults& defaults) {
  const std::size_t colon = text.find(':');
  const std::string_view scheme = text.substr(0, colon),
                         rest = colon == std::string_view::npos ? "" : text.substr(colon + 1);
  if (colon != std::string_view::npos) {
    if (scheme == "sim" && rest.empty()) return {};
    if (scheme == "sim") refuse(text, "the simulated world's ports have no place: \"sim:\"");
    if (scheme == "python") {
      if (!rest.empty()) refuse(text, "the class stands in devices.NODE.kind: \"python:\"");
      PortAddress a;
      a.kind = PortAddress::Kind::kPython;
      return a;
    }
    if (scheme == "tcp") return tcp(text, rest, defaults);
    if (scheme == "serial") return serial(text, rest, defaults);
    if (scheme == "unix") {
      check_place(text, rest, "socket");
      return unix_port(std::string(rest));
    }
    if (scheme == "v4l2") return v4l2(text, rest);
    if (scheme == "folder") {
      check_place(text, rest, "folder");
      PortAddress a = unix_port(std::string(rest));
      a.kind = PortAddress::Kind::kFolder;
      return a;
    }
    if (scheme == "cassette") {
      check_place(text, rest, "file");
      PortAddress a = unix_port(std::string(rest));
      a.kind = PortAddress::Kind::kCassette;
      return a;
    }
  }
  refuse(
      text,
      "must be sim:, tcp:HOST:PORT, serial:FILE?baud=N, unix:PATH, cassette:FILE or python:, or of a camera "
      "v4l2:FILE or folder:PATH");
}

PortAddress unix_port(std::string path) {
  PortAddress a;
  a.kind = PortAddress::Kind::kUnix;
  a.place = std::move(path);
  return a;
}

std::string to_text(const PortAddress& a) {
  switch (a.kind) {
    case PortAddress::Kind::kSimulated:
      break;
    case PortAddress::Kind::kTcp: {
      const bool v6 = a.place.find(':') != std::string::npos;
      return "tcp:" + (v6 ? "[" + a.place + "]" : a.place) + ":" + std::to_string(a.tcp_port);
    }
    case PortAddress::Kind::kSerial: {
      std::string text = "serial:" + a.place + "?baud=" + std::to_string(a.baud) +
                         "&frame=" + std::to_string(a.data_bits) + a.parity + std::to_string(a.stop_bits);
      if (a.dtr != PortAddress::Dtr::kKeep) text += a.dtr == PortAddress::Dtr::kOn ? "&dtr=on" : "&dtr=off";
      return text + "&open_wait_ms=" + std::to_string(a.open_wait_ms);
    }
    case PortAddress::Kind::kUnix:
      return "unix:" + a.place;
    case PortAddress::Kind::kCassette:
      return "cassette:" + a.place;
    case PortAddress::Kind::kFolder:
      return "folder:" + a.place;
    case PortAddress::Kind::kPython:
      return "python:";
    case PortAddress::Kind::kV4l2: {
      std::string options;
      const auto add = [&](const std::string& option) { options += (options.empty() ? "?" : "&") + option; };
      if (a.width_px > 0) add("size=" + std::to_string(a.width_px) + "x" + std::to_string(a.height_px));
      if (!a.format.empty()) add("format=" + a.format);
      if (a.delay_us > 0.0) add("delay_us=" + std::to_string(int(a.delay_us)));
      return "v4l2:" + a.place + options;
    }
  }
  return "sim:";
}

}  // namespace firn
