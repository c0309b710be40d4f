// Stands in for test_valve_avr.cpp where the packages under [firmware] of scripts/packages.txt are missing.
#include <catch2/catch.hpp>

#include "tests/support/skip.h"

TEST_CASE("the valve's binary runs in simavr") {
  CHECK_NOTHROW(firn::test::skip("avr", "gcc-avr, avr-libc or libsimavr-dev is not installed"));
}
