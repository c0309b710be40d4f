// The profiler at speed: driver and twin meet byte for byte, with a host that is late now and then.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "plant/twins/laser_profiler.h"

using namespace firn;
using namespace firn::drivers;

namespace {

constexpr int kPoints = 800;
constexpr std::int64_t kRow_us = 1000;

struct Scan {
  std::vector<ProfileRow> rows;
  ScanDone done;
  bool over = false;
};

// Heights that tell row and point apart.
double height_mm(int row, int n) { return double(row % 500) * 1e-3 + double(n % 7) * 1e-4; }

// A host that handles what has come every `step_us`, and stalls for up to `stall_us` with probability 1 in
// 50.
Scan scan(ProfileRead read, int rows, std::int64_t stall_us, std::uint64_t seed) {
  plant::ProfilerParams params;
  params.points = kPoints;
  plant::ProfilerTwin twin(params, 0.0, 0.005);
  LaserProfilerOptions options;
  options.read = read;
  options.poll_s = 0.004;
  LaserProfiler driver(options);
  Scan s;
  RandomStream random(seed, Purpose::kTest);
  std::int64_t now_us = 1'000'000, wake_us = 0, begun_us = 0;
  int triggered = 0;
  std::vector<double> line(kPoints);
  const auto take = [&](Effects& fx) {
    if (!fx.tx.empty()) twin.take(fx.tx, now_us);
    wake_us = fx.wake_us;
    for (DriverEvent& e : fx.events) {
      if (const auto* r = event_cast<ProfileRow>(e)) s.rows.push_back(*r);
      if (const auto* d = event_cast<ScanDone>(e)) {
        s.done = *d;
        s.over = true;
      }
      if (const auto* r = event_cast<Result>(e); r && r->outcome == Outcome::kReady) begun_us = now_us;
    }
  };
  Effects fx;
  twin.link().connect(now_us);
  driver.opened(now_us, fx);
  take(fx);
  bool armed = false;
  for (const std::int64_t end_us = now_us + 300'000'000; !s.over && now_us < end_us;) {
    const std::int64_t host_us =
        now_us + (random.below(50) == 0 ? std::int64_t(random.below(std::uint32_t(stall_us))) : 300);
    while (begun_us != 0 && triggered < rows && begun_us + (triggered + 1) * kRow_us <= host_us) {
      for (int n = 0; n < kPoints; ++n) line[std::size_t(n)] = height_mm(triggered, n);
      ++triggered;
      twin.trigger(begun_us + triggered * kRow_us, triggered * 10, line);
    }
    now_us = host_us;
    while (twin.link().next_send_us() <= now_us) {
      const auto chunk = twin.link().pop_send();
      Effects got;
      driver.received(std::as_bytes(std::span(chunk.bytes.data(), chunk.bytes.size())), now_us, got);
      take(got);
    }
    Effects woken;
    if (wake_us != 0 && wake_us <= now_us) {
      driver.woke(now_us, woken);
      take(woken);
    }
    if (!armed && driver.safe()) {
      armed = true;
      Effects arming;
      driver.arm(rows, now_us, arming);
      take(arming);
    }
    if (triggered == rows && now_us > begun_us + rows * kRow_us + 500'000 && !driver.busy()) {
      Effects ending;
      driver.end(now_us, ending);
      take(ending);
    }
  }
  return s;
}

}  // namespace

TEST_CASE("2,000 rows at 1 kHz come whole and in order from the profiler's memory, with a host that is late",
          "[laser][corrected:ljv-memory]") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scan s = scan(ProfileRead::kMemory, 2000, 250'000, seed);
    REQUIRE(s.over);
    REQUIRE(s.rows.size() == 2000);
    CHECK(s.done.rows_received == 2000);
    for (int r = 0; r < 2000; ++r) {
      const ProfileRow& row = s.rows[std::size_t(r)];
      REQUIRE(row.row == r);
      REQUIRE(row.encoder_count == (r + 1) * 10);
      REQUIRE(row.z_mm.size() == std::size_t(kPoints));
      for (const int n : {0, 1, 399, 799})
        REQUIRE(double(row.z_mm[std::size_t(n)]) == Approx(height_mm(r, n)).margin(1e-6));
    }
  }
}

TEST_CASE("by its newest profile alone the same scan loses rows", "[laser][corrected:ljv-memory]") {
  const Scan s = scan(ProfileRead::kNewest, 2000, 250'000, 1);
  CHECK(s.rows.size() < 1000);
}

TEST_CASE("rows that the profiler's memory holds no more are absent, the others come", "[laser]") {
  const Scan s = scan(ProfileRead::kMemory, 12'000, 12'000'000, 5);  // the memory holds 4,096
  REQUIRE(s.over);
  CHECK(s.rows.size() >= 4096);
  CHECK(s.rows.size() < 12'000);
  for (std::size_t n = 1; n < s.rows.size(); ++n) REQUIRE(s.rows[n].row > s.rows[n - 1].row);
  CHECK(s.rows.back().row == 11'999);
}
