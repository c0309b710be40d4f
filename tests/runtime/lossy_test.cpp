#include <catch2/catch.hpp>

#include <algorithm>

#include "runtime/lossy.h"

using namespace firn;

namespace {

using Log = std::vector<std::pair<std::int64_t, int>>;  // time, which datagram

Log run(const LossyOptions& options, LossyCounts* counts = nullptr) {
  Lossy lossy(options);
  Log log;
  std::int64_t now = 0;
  const Lossy::Sink sink = [&](std::string_view channel, std::span<const std::byte> b) {
    REQUIRE(channel == "ENABLE");
    log.emplace_back(now, int(b[0]) + 256 * int(b[1]));
  };
  for (int n = 0; n < 20'000; ++n, now += 50) {
    const std::byte b[2] = {std::byte(n), std::byte(n >> 8)};
    lossy.release(now, sink);
    lossy.receive("ENABLE", b, now, sink);
  }
  for (now += 1'000'000; lossy.due_us() <= now;) lossy.release(now, sink);
  if (counts) *counts = lossy.counts();
  return log;
}

}  // namespace

TEST_CASE("a network without faults hands everything on at once") {
  LossyCounts counts;
  const Log log = run({}, &counts);
  REQUIRE(log.size() == 20'000);

  CHECK(std::is_sorted(log.begin(), log.end()));
  CHECK(counts.injected() == 0);
}

TEST_CASE("the counts say what was done, at the asked rates") {
  LossyCounts c;
  const Log log = run({0.1, 0.05, 0.2, 0.1, 0.01, 3}, &c);
  CHECK(c.lost + c.passed == 20'000);
  CHECK(log.size() == c.passed + c.duplicated);
  CHECK(double(c.lost) == Approx(2000).epsilon(0.1));
  CHECK(double(c.duplicated) == Approx(900).epsilon(0.15));
  CHECK(double(c.delayed) == Approx(1800).epsilon(0.15));
  CHECK(double(c.reordered) == Approx(18000 * 0.9 * 0.2).epsilon(0.15));
  int overtaken = 0;
  for (std::size_t n = 1; n < log.size(); ++n) overtaken += log[n].second < log[n - 1].second;
  CHECK(overtaken > 1000);
}

TEST_CASE("the same seed, node and incarnation give the same faults, others give others") {
  LossyOptions o{0.1, 0.1, 0.1, 0.1, 0.01, 3, 4, 0};
  const Log log = run(o);
  CHECK(run(o) == log);
  o.incarnation = 1;
  CHECK(run(o) != log);
  o.incarnation = 0;
  o.node = 5;
  CHECK(run(o) != log);
}

TEST_CASE("fault counts survive their text form, and other text is refused") {
  const LossyCounts c{1, 22, 333, 4444, 55555};
  const LossyCounts d = parse_lossy_counts(to_text(c));
  CHECK(to_text(d) == to_text(c));
  CHECK(d.injected() == 22 + 333 + 4444 + 55555);
  CHECK_THROWS(parse_lossy_counts("lost 3"));
  CHECK_THROWS(parse_lossy_counts(""));
}
