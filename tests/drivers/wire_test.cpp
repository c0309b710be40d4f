#include <catch2/catch.hpp>

#include "tests/drivers/wire_exchange.h"

using namespace firn::drivers::test;

TEST_CASE("over serial lines and TCP no disturbed exchange gives a wrong answer or a repeated act",
          "[wire][I2]") {
  for (const RealWire::Kind kind : {RealWire::Kind::kSerial, RealWire::Kind::kTcp})
    for (const ExchangeFigures& f : exchange_under_faults(kind, 400, 11)) {
      INFO((kind == RealWire::Kind::kTcp ? "tcp " : "serial ") << f.instrument << ": " << f.first_wrong);
      CHECK(f.exchanges >= 400);
      CHECK(f.faults > 0);
      CHECK(f.wrong == 0);
      CHECK(f.repeats == 0);
    }
}
