#include "files/record/log_statistics.h"

#include <catch2/catch.hpp>
#include <cstdint>

using namespace firn::record;

namespace {

LogStatistics statistics_of(std::int64_t first_us, std::int64_t second_us) {
  LogStatistics statistics;
  Event e;
  e.channel = "MAP";
  for (const std::int64_t us : {first_us, second_us}) {
    e.utime_us = us;
    statistics.add(e);
  }
  return statistics;
}

}  // namespace

TEST_CASE("a step back in time is counted, with its size and place, at every distance a stamp can have") {
  const auto [first, second, largest] =
      GENERATE(table<std::int64_t, std::int64_t, std::int64_t>({{10, 7, 3},
                                                                {INT64_MAX, -1, INT64_MAX},
                                                                {INT64_MAX - 1, -1, INT64_MAX},
                                                                {INT64_MAX - 2, -1, INT64_MAX - 1},
                                                                {INT64_MAX, INT64_MIN, INT64_MAX},
                                                                {0, INT64_MIN, INT64_MAX}}));
  CAPTURE(first, second);
  const LogStatistics s = statistics_of(first, second);
  CHECK(s.steps().back == 1);
  CHECK(s.steps().largest_us == largest);
  CHECK(s.channels().at("MAP").steps.largest_us == largest);
}

TEST_CASE("The pauses of a channel whose messages come in bursts are no gaps, a far longer one is") {
  for (const int burst : {2, 10, 500}) {
    Intervals intervals;
    const int pauses = 40;
    for (int n = 0; n < burst * pauses; ++n) {
      intervals.add(1'000 + n % 7, 0);
      if (n % burst == 0) intervals.add(1'000'000 + n % 1013, 0);
    }
    INFO("bursts of " << burst);
    CHECK(intervals.gaps().count == 0);
    intervals.add(30'000'000, 0);
    CHECK(intervals.gaps().count == 1);
  }
}

TEST_CASE("A few long intervals of an even channel are gaps, however long they are") {
  for (const int few : {1, 3, 7}) {
    Intervals intervals;
    for (int n = 0; n < 300; ++n) intervals.add(100'000 + n % 11, 0);
    for (int n = 0; n < few; ++n) intervals.add(20'000'000 + n, 0);
    CHECK(intervals.gaps().count == std::uint64_t(few));
    CHECK(intervals.usual_us() == Approx(100'000).epsilon(0.07));
  }
}
