#include "files/record/log_statistics.h"

#include <catch2/catch.hpp>
#include <cstdint>

using namespace firn::logfile;

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
