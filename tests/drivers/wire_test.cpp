#include <catch2/catch.hpp>

#include "tests/drivers/wire_exchange.h"

using namespace firn::drivers::test;

TEST_CASE("over serial lines and TCP no disturbed exchange gives a wrong answer or a repeated act",
          "[wire][I2]") {
  for (const RealWire::Kind kind : {RealWire::Kind::kSerial, RealWire::Kind::kTcp})
    exchange_under_faults(kind, 400, 11, [&](const ExchangeFigures& f) {
      INFO((kind == RealWire::Kind::kTcp ? "tcp " : "serial ") << f.instrument << ": " << f.first_wrong);
      CHECK(f.exchanges >= 400);
      CHECK(f.faults > 0);
      CHECK(f.wrong == 0);
      CHECK(f.repeats == 0);
    });
}

TEST_CASE("a path that is over while a reply is missing wakes no driver for nothing", "[wire][robot]") {
  exchange_under_faults(
      RealWire::Kind::kSerial, 9000, 27, [](const ExchangeFigures& f) { CHECK(f.wrong + f.repeats == 0); },
      "robot");  // a rig throws when time stands still
}
