// A point laser that the stage moves: the driver against the twin, two sides written from the same manual.
#include "drivers/laser_profiler/point_scan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "plant/twins/point_scan.h"

using namespace firn::drivers;
using Catch::Contains;
using firn::DeviceState;
using firn::Outcome;
using firn::plant::FaultKind;

namespace {

constexpr std::int64_t kPulse_us = 10'000;
constexpr double kHeight_mm = 0.25;  // where nothing else is said

LaserProfilerOptions point_options() {
  LaserProfilerOptions o;
  o.program = 3;
  o.offset_x_mm = 12.0;
  return o;
}

class PointRig {
 public:
  explicit PointRig(LaserProfilerOptions options = point_options(),
                    const firn::plant::ProfilerParams& params = {})
      : twin(params, [](std::int64_t) { return kHeight_mm; }), laser(options, {5.0, 0.5}) {
    twin.link().connect(now_us);
    step([&](Effects& fx) { laser.opened(now_us, fx); });
  }

  void get_ready() {
    REQUIRE(run([&] { return laser.safe(); }, 60.0));
  }
  void arm(int rows) {
    const std::size_t before = results.size();
    step([&](Effects& fx) { laser.arm(rows, now_us, fx); });
    REQUIRE(run([&] { return results.size() > before; }, 10.0));
    REQUIRE(results.back().outcome == Outcome::kReady);
  }
  void pulse(double height_mm) {
    run([] { return false; }, kPulse_us * 1e-6);
    twin.trigger(now_us, 0, std::vector<double>{height_mm});
  }
  Result end() {
    const std::size_t before = results.size();
    step([&](Effects& fx) { laser.end(now_us, fx); });
    REQUIRE(run([&] { return results.size() > before; }, 60.0));
    return results.back();
  }
  /// A swath of so many pulses, of which `n` is at a height of n / 100 mm.
  Result swath(int rows) {
    arm(rows);
    for (int n = 0; n < rows; ++n) pulse(0.01 * n);
    return end();
  }

  bool run(const std::function<bool()>& done, double limit_s) {
    const std::int64_t until_us = now_us + std::int64_t(limit_s * 1e6);
    while (!done()) {
      const std::int64_t next = std::min({wake_us == 0 ? firn::plant::kNever : wake_us, twin.next_inner_us(),
                                          twin.link().next_send_us(), reopen_us});
      if (next > until_us) {
        now_us = until_us;
        return false;
      }
      now_us = std::max(now_us, next);
      if (reopen_us <= now_us) {
        reopen_us = firn::plant::kNever;
        twin.link().connect(now_us);
        step([&](Effects& fx) { laser.opened(now_us, fx); });
      } else if (twin.next_inner_us() <= now_us) {
        twin.step();
      } else if (twin.link().next_send_us() <= now_us) {
        const auto chunk = twin.link().pop_send();
        if (chunk.close)
          step([&](Effects& fx) { laser.closed(now_us, fx); });
        else
          step([&](Effects& fx) { laser.received(std::as_bytes(std::span(chunk.bytes)), now_us, fx); });
      } else {
        wake_us = 0;
        step([&](Effects& fx) { laser.woke(now_us, fx); });
      }
    }
    return true;
  }
  bool told(const std::string& words) const {
    return std::ranges::any_of(faults, [&](const auto& t) { return t.find(words) != t.npos; });
  }
  void step(const std::function<void(Effects&)>& act) {
    Effects fx;
    act(fx);
    if (!fx.tx.empty()) twin.link().arrive(fx.tx, now_us);
    if (fx.reopen) {
      twin.link().disconnect();
      reopen_us = now_us + 10'000;
    }
    wake_us = fx.wake_us;
    for (const DriverEvent& e : fx.events) {
      if (const auto* r = event_cast<Result>(e)) results.push_back(*r);
      if (const auto* f = event_cast<Fault>(e)) faults.push_back(f->text);
      if (const auto* p = event_cast<ProfileRow>(e)) rows.push_back(*p);
      if (const auto* d = event_cast<ScanDone>(e)) done.push_back(*d);
    }
  }

  std::int64_t now_us = 1'000'000, wake_us = 0, reopen_us = firn::plant::kNever;
  firn::plant::PointScanTwin twin;
  PointScan laser;
  std::vector<Result> results;
  std::vector<std::string> faults;
  std::vector<ProfileRow> rows;
  std::vector<ScanDone> done;
};

}  // namespace

TEST_CASE("each pulse of the stage is a row of one point, in the order of the pulses", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  const Result r = rig.swath(40);
  CHECK(r.outcome == Outcome::kDone);
  REQUIRE(rig.rows.size() == 40);
  for (int n = 0; n < 40; ++n) {
    const ProfileRow& row = rig.rows[std::size_t(n)];
    CHECK(row.row == n);
    CHECK(row.x0_mm == 17.0);
    CHECK_FALSE(row.by_encoder);
    REQUIRE(row.z_mm.size() == 1);
    CHECK(double(row.z_mm[0]) == Approx(0.01 * n).margin(1e-6));
  }
  REQUIRE(rig.done.size() == 1);
  CHECK(rig.done[0].rows_received == 40);
  CHECK(rig.faults.empty());
}

TEST_CASE("heights have the laser's sign and zero", "[point_scan]") {
  LaserProfilerOptions options = point_options();
  options.z_sign = ZSign::kDown;
  options.z_zero_mm = 1.5;
  firn::plant::ProfilerParams params;
  params.upside_down = true;
  params.zero_mm = 1.5;
  PointRig rig(options, params);
  rig.get_ready();
  rig.swath(3);
  REQUIRE(rig.rows.size() == 3);
  CHECK(double(rig.rows[2].z_mm[0]) == Approx(0.02).margin(1e-6));
}

TEST_CASE("places without a value are rows without one", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  rig.arm(3);
  rig.pulse(0.1);
  rig.pulse(std::nan(""));
  rig.pulse(0.3);
  rig.end();
  REQUIRE(rig.rows.size() == 3);
  CHECK(std::isnan(rig.rows[1].z_mm[0]));
  CHECK(double(rig.rows[2].z_mm[0]) == Approx(0.3).margin(1e-6));
}

TEST_CASE("of a swath with a value too few or too many no row is used, and that is said", "[point_scan]") {
  for (const int pulses : {9, 11, 0, 30}) {
    PointRig rig;
    rig.get_ready();
    rig.arm(10);
    for (int n = 0; n < pulses; ++n) rig.pulse(0.01 * n);
    const Result r = rig.end();
    INFO(pulses);
    CHECK(r.outcome == Outcome::kDone);
    CHECK(rig.rows.empty());
    REQUIRE(rig.done.size() == 1);
    CHECK(rig.done[0].rows_expected == 10);
    CHECK(rig.done[0].rows_received == 0);
    CHECK(rig.told("of 10 pulses: the rows they belong to cannot be told"));
    rig.swath(5);
    CHECK(rig.rows.size() == 5);
  }
}

TEST_CASE("an input that bounces and a cable that is off lose the swath, not its order", "[point_scan]") {
  for (const int fault : {3, 4}) {
    PointRig rig;
    rig.get_ready();
    rig.twin.trip(rig.now_us, fault);
    rig.swath(10);
    INFO(fault);
    CHECK(rig.rows.empty());
    CHECK(rig.told("none is used"));
  }
}

TEST_CASE("a damaged value never moves the values behind it", "[point_scan]") {
  for (std::int64_t bit = 0; bit < 14 * 8; ++bit) {
    PointRig rig;
    rig.get_ready();
    rig.arm(10);
    rig.pulse(0.0);
    rig.twin.link().inject({"laser_profiler", FaultKind::kFlipBit, bit, 0}, rig.now_us);
    for (int n = 1; n < 10; ++n) rig.pulse(0.01 * n);
    rig.end();
    INFO("bit " << bit);
    if (rig.rows.empty()) continue;  // it was lost
    REQUIRE(rig.rows.size() == 10);
    for (int n = 2; n < 10; ++n)
      CHECK(double(rig.rows[std::size_t(n)].z_mm[0]) == Approx(0.01 * n).margin(1e-6));
  }
}

TEST_CASE("a dark head gives rows without values, and one that sticks equal ones", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  rig.twin.trip(rig.now_us, 1);
  rig.swath(4);
  REQUIRE(rig.rows.size() == 4);
  for (const ProfileRow& row : rig.rows) CHECK(std::isnan(row.z_mm[0]));
  rig.twin.trip(rig.now_us, 2);
  rig.rows.clear();
  rig.swath(4);
  REQUIRE(rig.rows.size() == 4);
  CHECK(std::isnan(rig.rows[3].z_mm[0]));
}

TEST_CASE("a link that is lost in a swath loses it by name, and the next one is measured", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  rig.arm(10);
  for (int n = 0; n < 5; ++n) rig.pulse(0.01 * n);
  rig.twin.link().close(rig.now_us);
  rig.run([&] { return rig.laser.state() != DeviceState::kArmed; }, 1.0);
  CHECK(rig.told("link lost during a scan"));
  rig.reopen_us = rig.now_us + 1;
  rig.get_ready();
  CHECK(rig.rows.empty());
  REQUIRE(rig.done.size() == 1);
  CHECK(rig.done[0].rows_received == 0);
  rig.swath(10);
  CHECK(rig.rows.size() == 10);
}

TEST_CASE("a laser that starts anew with another program is set up before it measures again",
          "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  CHECK_THAT(rig.laser.identity(), Contains("program 3"));
  rig.twin.reboot(rig.now_us);
  rig.run([&] { return rig.told("is in program 0, not in 3"); }, 10.0);
  CHECK(rig.told("is in program 0, not in 3"));
  rig.get_ready();
  CHECK_THAT(rig.laser.identity(), Contains("program 3"));
}

TEST_CASE("a stop ends a swath without rows, and leaves the laser ready", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  rig.arm(10);
  for (int n = 0; n < 5; ++n) rig.pulse(0.01 * n);
  rig.step([&](Effects& fx) { rig.laser.safe_stop(rig.now_us, fx); });
  CHECK(rig.laser.safe());
  CHECK(rig.rows.empty());
  REQUIRE(rig.done.size() == 1);
  rig.swath(6);
  CHECK(rig.rows.size() == 6);
}

TEST_CASE("pulses before the arming belong to no row", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  for (int n = 0; n < 3; ++n) rig.pulse(9.0);
  rig.swath(5);
  REQUIRE(rig.rows.size() == 5);
  CHECK(double(rig.rows[0].z_mm[0]) == Approx(0.0).margin(1e-6));
}

TEST_CASE("a person reads one height", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  rig.step([&](Effects& fx) { rig.laser.serve("read", {}, rig.now_us, fx); });
  REQUIRE(rig.run([&] { return !rig.results.empty(); }, 5.0));
  REQUIRE(rig.rows.size() == 1);
  CHECK(double(rig.rows[0].z_mm[0]) == Approx(kHeight_mm));
}

TEST_CASE("a laser that falls silent is told within its time", "[point_scan]") {
  PointRig rig;
  rig.get_ready();
  rig.twin.link().inject({"laser_profiler", FaultKind::kHang, 0, 0}, rig.now_us);
  CHECK(rig.run([&] { return rig.told("no answer for"); }, 30.0));
}
