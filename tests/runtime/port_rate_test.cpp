#include "runtime/port_rate.h"

#include <catch2/catch.hpp>
#include <vector>

#include "core/grid/random.h"
#include "lcmtypes/channels.h"

using namespace firn;

TEST_CASE("in every span of time a port hands over what its rate fills and its bucket holds at most") {
  RandomStream random(7, Purpose::kTest);
  for (int draw = 0; draw < 200; ++draw) {
    const double rate = 100.0 + double(random.below(10'000'000));
    const double held = std::max(RateMeter::kHeld_s * rate, RateMeter::kLeastHeld_bytes);
    RateMeter meter(PortRate{rate});
    std::vector<std::pair<std::int64_t, double>> taken;  // when [us], how many bytes
    std::int64_t now_us = 1;
    for (int n = 0; n < 100; ++n) {
      now_us += std::int64_t(random.below(50'000));
      const std::size_t bytes = 1 + random.below(std::uint32_t(rate / 4.0) + 20'000);
      if (meter.take(bytes, now_us).empty()) taken.emplace_back(now_us, double(bytes));
    }
    for (std::size_t first = 0; first < taken.size(); ++first) {
      double sum = 0.0;
      for (std::size_t n = first; n < taken.size(); ++n) {
        sum += taken[n].second;
        const double passed_s = double(taken[n].first - taken[first].first) * 1e-6;
        REQUIRE(sum <= held + rate * passed_s + 1.0);
      }
    }
  }
}

TEST_CASE("an instrument that sends as fast as its line carries is never cut off") {
  for (const NodeInfo& node : nodes()) {
    if (!node.driver) continue;
    const PortRate rate = port_rate(node.name);
    RateMeter meter(rate);
    for (std::int64_t ms = 1; ms <= 20'000; ++ms)
      REQUIRE(meter.take(std::size_t(rate.bytes_per_s / 1000.0), ms * 1000).empty());
  }
}

TEST_CASE("the time in which a process waits for its disk is no flood of its instrument") {
  RateMeter meter(PortRate{1e6});
  REQUIRE(meter.take(1'000, 1).empty());
  CHECK(meter.take(1'900'000, 2'000'001).empty());  // bytes of two seconds
}
