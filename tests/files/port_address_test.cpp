// The text of an instrument's port.
#include "files/port_address.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "core/grid/random.h"

using namespace firn;
using Catch::Contains;

TEST_CASE("A port's address reads back from its text, whatever its kind") {
  for (const char* text :
       {"sim:", "tcp:192.168.0.7:8000", "tcp:stage.lab:1", "tcp:[fe80::1]:65535", "unix:/run/stage",
        "serial:/dev/serial/by-id/usb-FTDI_A1?baud=9600&frame=8N1&open_wait_ms=0",
        "serial:/dev/ttyUSB0?baud=115200&frame=7E2&dtr=on&open_wait_ms=500",
        "serial:/dev/ttyS1?baud=300&frame=8O1&dtr=off&open_wait_ms=10000"}) {
    const PortAddress a = parse_port_address(text);
    CHECK(to_text(a) == text);
    CHECK(parse_port_address(to_text(a)) == a);
    CHECK(a.real() == (std::string_view(text) != "sim:"));
  }
}

TEST_CASE("An address that is none is refused by the piece that is wrong") {
  const std::pair<const char*, const char*> wrong[] = {
      {"", "sim:, tcp:HOST:PORT"},
      {"stage", "sim:, tcp:HOST:PORT"},
      {"http:x", "sim:, tcp:HOST:PORT"},
      {"sim:stage", "no place"},
      {"tcp:", "no host"},
      {"tcp::80", "no host"},
      {"tcp:a", "tcp:HOST:PORT"},
      {"tcp:a:0", "port '0'"},
      {"tcp:a:65536", "port '65536'"},
      {"tcp:a:8o", "port '8o'"},
      {"tcp:fe80::1:80", "brackets"},
      {"tcp:[fe80::1", "bracket"},
      {"tcp:[fe80::1]80", "tcp:[HOST]:PORT"},
      {"serial:", "no device file"},
      {"serial:/dev/x", "speed"},
      {"serial:/dev/x?baud=9601", "baud 9601"},
      {"serial:/dev/x?baud=fast", "baud 'fast'"},
      {"serial:/dev/x?baud=9600&frame=9N1", "frame '9N1'"},
      {"serial:/dev/x?baud=9600&dtr=maybe", "dtr=maybe"},
      {"serial:/dev/x?baud=9600&rts=on", "rts=on"},
      {"serial:/dev/x?baud=9600&open_wait_ms=-1", "open_wait_ms '-1'"},
      {"unix:", "no socket"},
      {"unix:a\nb", "control character"},
  };
  for (const auto& [text, why] : wrong) CHECK_THROWS_WITH(parse_port_address(text), Contains(why));
}

TEST_CASE("Whatever text stands for a port, it is read to an address that reads back, or refused") {
  RandomStream random(5, Purpose::kTest);
  const std::string pieces[] = {"tcp:", "serial:", "unix:", "sim:", ":", "[", "]", "?",  "&",   "=",
                                "baud", "frame",   "9600",  "8N1",  "x", "/", "%", "80", "dtr", "on"};
  int read = 0;
  for (int n = 0; n < 20'000; ++n) {
    std::string text;
    for (std::uint32_t k = random.below(9) + 1; k > 0; --k) text += pieces[random.below(std::size(pieces))];
    try {
      const PortAddress a = parse_port_address(text, PortDefaults{8000, 115200, 0});
      CHECK(parse_port_address(to_text(a)) == a);
      ++read;
    } catch (const std::invalid_argument&) {
    }
  }
  CHECK(read > 100);
}
