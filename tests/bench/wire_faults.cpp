// Exchanges with every instrument over serial lines and TCP under the whole menu of a line's faults: answers
// against the truth, acts against commands, and the time until an instrument is usable again.
//   FIRN_EXCHANGES=10000 FIRN_INSTRUMENT=robot wire_faults   (without: all)
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "tests/drivers/wire_exchange.h"

using namespace firn::drivers::test;

TEST_CASE("exchanges over real lines under faults") {
  const char* wanted = std::getenv("FIRN_EXCHANGES");
  const long exchanges = wanted ? std::atol(wanted) : 10'000;
  const char* only = std::getenv("FIRN_INSTRUMENT");
  std::printf("%-7s %-15s %10s %9s %7s %6s %8s %10s after\n", "line", "instrument", "exchanges", "commands",
              "faults", "wrong", "repeats", "usable s");
  for (const RealWire::Kind kind : {RealWire::Kind::kSerial, RealWire::Kind::kTcp}) {
    const auto row = [&](const ExchangeFigures& f) {
      std::printf("%-7s %-15s %10lld %9lld %7lld %6lld %8lld %10.2f %s %s\n",
                  kind == RealWire::Kind::kTcp ? "tcp" : "serial", f.instrument.c_str(),
                  static_cast<long long>(f.exchanges), static_cast<long long>(f.commands),
                  static_cast<long long>(f.faults), static_cast<long long>(f.wrong),
                  static_cast<long long>(f.repeats), f.slowest_s, f.slowest_after.c_str(),
                  f.first_wrong.c_str());
      std::fflush(stdout);
      CHECK(f.wrong + f.repeats == 0);
    };
    exchange_under_faults(kind, exchanges, 27, row, only ? only : "");
  }
}
