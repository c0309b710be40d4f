// A GRBL board as stage: the driver against the twin, two sides written from the same public documents.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>

#include "drivers/stage/grbl_stage.h"
#include "plant/twins/grbl.h"

using namespace firn::drivers;
using Catch::Contains;
using firn::DeviceState;
using firn::Outcome;

namespace {

struct Pulse {
  int axis;
  std::int64_t t_us;
  double x_mm, y_mm, vx_mm_s, vy_mm_s;
};

StageOptions grbl_options() {
  StageOptions o;
  o.counts_per_mm = 250.0;
  o.acceleration_mm_s2 = 500.0;
  o.max_speed_mm_s = 60.0;
  o.move_speed_mm_s = 50.0;
  o.raster_speed_mm_s = 20.0;
  o.laser_output = o.scan_box = firn::OnOff::kOn;
  return o;
}

firn::plant::StageParams grbl_params() {
  firn::plant::StageParams p;
  p.kind = "grbl";
  p.counts_per_mm = 250.0;
  p.ramp_rate_mm_s2 = 500.0;
  p.max_speed_mm_s = 60.0;
  p.low_limit_mm = {-50.0, -50.0, -10.0};
  p.high_limit_mm = {150.0, 150.0, 50.0};
  p.laser_output = true;
  p.box_pitch_mm = 0.5;
  return p;
}

class GrblRig : public firn::plant::Wires {
 public:
  explicit GrblRig(StageOptions options = grbl_options(), firn::plant::StageParams params = grbl_params())
      : twin(params, *this), stage(options) {
    twin.link().connect(now_us);
    step([&](Effects& fx) { stage.opened(now_us, fx); });
  }

  /// Up to a stage that is homed and safe.
  void get_ready() {
    REQUIRE(run([&] { return stage.safe(); }, 60.0));
  }

  void order(const std::function<void(std::int64_t, Effects&)>& give) {
    results.clear();
    step([&](Effects& fx) { give(now_us, fx); });
  }
  Result obeyed(const std::function<void(std::int64_t, Effects&)>& give, double limit_s = 120.0) {
    order(give);
    run([&] { return !results.empty(); }, limit_s);
    REQUIRE_FALSE(results.empty());
    return results.back();
  }
  void stop() {
    step([&](Effects& fx) { stage.safe_stop(now_us, fx); });
  }

  bool run(const std::function<bool()>& done, double limit_s) {
    const std::int64_t until_us = now_us + std::int64_t(limit_s * 1e6);
    while (!done()) {
      const std::int64_t next = std::min(
          {wake_us == 0 ? firn::plant::kNever : wake_us, twin.next_inner_us(), twin.link().next_send_us()});
      if (next > until_us) return false;
      now_us = std::max(now_us, next);
      if (twin.next_inner_us() <= now_us) {
        twin.step();
      } else if (twin.link().next_send_us() <= now_us) {
        const auto chunk = twin.link().pop_send();
        const auto bytes = std::as_bytes(std::span(chunk.bytes));
        if (chunk.close)
          step([&](Effects& fx) { stage.closed(now_us, fx); });
        else
          step([&](Effects& fx) { stage.received(bytes, now_us, fx); });
      } else {
        wake_us = 0;
        step([&](Effects& fx) { stage.woke(now_us, fx); });
      }
    }
    return true;
  }
  bool told(const std::string& words) const {
    for (const std::string& text : faults)
      if (text.find(words) != text.npos) return true;
    return false;
  }
  std::vector<Pulse> pulses_of(int axis) const {
    std::vector<Pulse> of;
    for (const Pulse& p : pulses)
      if (p.axis == axis) of.push_back(p);
    return of;
  }

  std::int64_t now_us = 1'000'000, wake_us = 0;
  firn::plant::GrblTwin twin;
  GrblStage stage;
  std::vector<Pulse> pulses;
  std::vector<Result> results;
  std::vector<std::string> faults;

 private:
  void step(const std::function<void(Effects&)>& act) {
    fx_.clear();
    act(fx_);
    for (const DriverEvent& e : fx_.events) {
      if (const auto* r = event_cast<Result>(e)) results.push_back(*r);
      if (const auto* f = event_cast<Fault>(e)) faults.push_back(f->text);
    }
    if (!fx_.tx.empty() && twin.link().connected()) twin.link().arrive(fx_.tx, now_us);
    wake_us = fx_.wake_us;
    if (!fx_.reopen) return;
    twin.link().disconnect();
    twin.link().connect(now_us);
    step([&](Effects& fx) { stage.opened(now_us, fx); });
  }
  void pulse(int axis, std::int64_t t_us, const double p[3], const double v[3]) override {
    pulses.push_back({axis, t_us, p[0], p[1], v[0], v[1]});
  }
  void softtrigger(std::int64_t, firn::plant::Port, int) override {}
  void lamp(std::int64_t, firn::plant::LampEvent, double) override {}
  void link_closed(std::int64_t, firn::plant::Port) override {}
  void note(std::int64_t, firn::plant::Port, firn::plant::DeviceEvent, std::int64_t) override {}

  Effects fx_;
};

firn::DropletPattern rows_of(int columns, int rows) {
  firn::GridSpec grid;
  grid.nx = columns;
  grid.ny = rows;
  grid.pitch_x_mm = grid.pitch_y_mm = 0.5;
  grid.origin_x_mm = 20.0;
  grid.origin_y_mm = 10.0;
  return firn::DropletPattern(grid, 1);
}

auto pass_of(GrblRig& rig, const firn::DropletPattern& pattern, double speed_mm_s = 20.0) {
  return [&rig, pattern, speed_mm_s](std::int64_t t, Effects& fx) {
    rig.stage.run_pass(pattern, 0, NAN, speed_mm_s, t, fx);
  };
}

}  // namespace

TEST_CASE("GRBL's status reports are read field by field", "[grbl]") {
  using firn::drivers::grbl::parse_report;
  using firn::drivers::grbl::State;
  const auto idle = parse_report("<Idle|MPos:0.000,-1.250,3.000|FS:0,0>");
  REQUIRE(idle);
  CHECK(idle->state == State::kIdle);
  CHECK(idle->of_machine);
  CHECK(idle->place_mm[1] == -1.25);
  const auto held =
      parse_report("<Hold:0|WPos:1.000,2.000,3.000|Bf:15,128|FS:500,8000|Ov:100,100,100|WCO:4,5,6>");
  REQUIRE(held);
  CHECK(held->state == State::kHoldComplete);
  CHECK_FALSE(held->of_machine);
  CHECK(held->offset_mm->at(2) == 6.0);
  CHECK(parse_report("<Run|MPos:0.000,0.000,0.000,7.000|F:0>"));  // a fourth axis
  for (const char* broken :
       {"", "<>", "<Idle>", "<Idle|MPos:0.0,0.0>", "<Idle|MPos:a,0,0>", "<Idling|MPos:0,0,0>",
        "Idle|MPos:0,0,0", "<Idle|MPos:0,0,0", "<Idle|MPos:0,0,0|WCO:1,2>"}) {
    INFO(broken);
    CHECK_FALSE(parse_report(broken));
  }
}

TEST_CASE("a GRBL board is held, reset, compared with the lab file and homed before it is safe", "[grbl]") {
  GrblRig rig;
  rig.get_ready();
  CHECK_THAT(rig.stage.identity(), Contains("1.1h.20190825:twin"));
  CHECK(rig.faults.empty());
  CHECK(std::abs(rig.twin.position_mm(rig.now_us)[0]) < 1e-9);
}

TEST_CASE("a GRBL board goes to a place and tells it", "[grbl]") {
  GrblRig rig;
  rig.get_ready();
  const Result r =
      rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.move_to(30.0, 20.0, 5.0, 40.0, t, fx); });
  CHECK(r.outcome == Outcome::kDone);
  CHECK(rig.twin.position_mm(rig.now_us)[0] == Approx(30.0).margin(1e-6));
  CHECK(rig.stage.position_mm(2) == Approx(5.0).margin(1e-3));
}

TEST_CASE("each droplet of a pass is one pulse of the laser output at its place, at the pass's speed",
          "[grbl]") {
  GrblRig rig;
  rig.get_ready();
  const firn::DropletPattern pattern = rows_of(12, 3);
  const Result r = rig.obeyed(pass_of(rig, pattern));
  INFO(r.text);
  REQUIRE(r.outcome == Outcome::kDone);
  const auto pulses = rig.pulses_of(0);
  REQUIRE(pulses.size() == 36);
  std::vector<int> hits(36, 0);
  for (const Pulse& p : pulses) {
    const double i = (p.x_mm - 20.0) / 0.5, j = (p.y_mm - 10.0) / 0.5;
    CHECK(std::abs(i - std::round(i)) * 0.5 < 0.0021);  // half a step of 1/250 mm
    CHECK(std::abs(std::abs(p.vx_mm_s) - 20.0) < 0.5);
    ++hits.at(std::size_t(std::lround(i) + 12 * std::lround(j)));
  }
  CHECK(hits == std::vector<int>(36, 1));
  CHECK_FALSE(rig.twin.output());
}

TEST_CASE("a scan's rows are pulses of the box at each pitch of Y, in one steady move", "[grbl]") {
  GrblRig rig;
  rig.get_ready();
  const Result r =
      rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.scan(15.0, 10.0, NAN, 0.5, 20, 10.0, t, fx); });
  CHECK(r.outcome == Outcome::kDone);
  const auto pulses = rig.pulses_of(1);
  REQUIRE(pulses.size() == 20);
  for (std::size_t k = 0; k < 20; ++k) CHECK(pulses[k].y_mm == Approx(10.0 + 0.5 * double(k)).margin(1e-6));
  CHECK(rig.pulses_of(0).empty());
}

TEST_CASE("what a GRBL board cannot do is refused by name, and nothing is sent", "[grbl]") {
  StageOptions none = grbl_options();
  none.laser_output = none.scan_box = firn::OnOff::kOff;
  GrblRig rig(none);
  rig.get_ready();
  CHECK_THAT(rig.obeyed(pass_of(rig, rows_of(4, 1))).text, Contains("stage.laser_output"));
  CHECK_THAT(
      rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.scan(0, 0, NAN, 0.5, 5, 5.0, t, fx); }).text,
      Contains("stage.scan_box"));
  CHECK_THAT(rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.trace({}, NAN, t, fx); }).text,
             Contains("follows no ways"));
  CHECK(rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.move_to(151, 0, 0, 5.0, t, fx); }).outcome ==
        Outcome::kRefused);
  CHECK_FALSE(rig.twin.moving());

  GrblRig slow;
  slow.get_ready();
  const Result fast = slow.obeyed(pass_of(slow, rows_of(4, 1), 50.0));  // 100 droplets/s are 200 lines/s
  CHECK(fast.outcome == Outcome::kRefused);
  CHECK_THAT(fast.text, Contains("100 droplets/s are 200 lines/s") && Contains("stage.lines_per_s = 150"));
}

TEST_CASE("a stop in a row decelerates, keeps the place and leaves the row in doubt", "[grbl]") {
  GrblRig rig;
  rig.get_ready();
  rig.order(pass_of(rig, rows_of(40, 2)));
  REQUIRE(rig.run([&] { return rig.pulses.size() >= 10; }, 30.0));
  rig.stop();
  REQUIRE(rig.run([&] { return rig.stage.safe(); }, 30.0));
  const std::size_t fired = rig.pulses.size();
  REQUIRE(rig.results.size() == 1);
  CHECK(rig.results[0].outcome == Outcome::kUnknown);
  CHECK(rig.results[0].unknown_from == 0);
  CHECK(rig.results[0].unknown_to == 40);
  CHECK(fired < 20);  // 20 mm/s, 0.4 mm to stand, and the part of the line that had been read
  rig.run([] { return false; }, 5.0);
  CHECK(rig.pulses.size() == fired);
  CHECK_FALSE(rig.told("place is lost"));
  CHECK(rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.move_to(0, 0, 0, 40.0, t, fx); }).outcome ==
        Outcome::kDone);
}

TEST_CASE("a hard limit is told with its meaning, and only homing leaves it", "[grbl]") {
  GrblRig rig;
  rig.get_ready();
  rig.order([&](std::int64_t t, Effects& fx) { rig.stage.move_to(100, 0, 0, 10.0, t, fx); });
  rig.run([] { return false; }, 1.0);
  rig.twin.trip(rig.now_us, 1);
  REQUIRE(rig.run([&] { return !rig.results.empty(); }, 30.0));
  CHECK(rig.results[0].outcome == Outcome::kFailed);
  CHECK(rig.told("hard limit: the place is lost"));
  CHECK(rig.stage.state() == DeviceState::kFault);
  CHECK(rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.move_to(0, 0, 0, 10.0, t, fx); }).outcome ==
        Outcome::kRefused);
  CHECK(rig.obeyed([&](std::int64_t t, Effects& fx) { rig.stage.home(t, fx); }).outcome == Outcome::kDone);
  REQUIRE(rig.run([&] { return rig.stage.safe(); }, 30.0));
}

TEST_CASE("a board with other steps than the lab file is refused by setting and key", "[grbl]") {
  GrblRig rig;
  rig.twin.trip(rig.now_us, 4);
  rig.run([&] { return rig.stage.state() == DeviceState::kFault; }, 30.0);
  CHECK(rig.told("$100 = 125 steps/mm; stage.counts_per_mm = 250"));
}

TEST_CASE("a board that loses its power in a move is named, and its place is not trusted", "[grbl]") {
  GrblRig rig;
  rig.get_ready();
  rig.order([&](std::int64_t t, Effects& fx) { rig.stage.move_to(100, 0, 0, 10.0, t, fx); });
  rig.run([] { return false; }, 1.0);
  rig.twin.reboot(rig.now_us);
  REQUIRE(rig.run([&] { return !rig.results.empty(); }, 30.0));
  CHECK(rig.told("the board has started anew"));
  CHECK(rig.stage.state() == DeviceState::kFault);
}

TEST_CASE("no fault of the line makes a GRBL pass done that was not fired as a whole", "[grbl]") {
  using firn::plant::FaultKind;
  const firn::DropletPattern pattern = rows_of(8, 2);
  for (const FaultKind kind : {FaultKind::kDropReply, FaultKind::kDelayReply, FaultKind::kSplitReply,
                               FaultKind::kFlipBit, FaultKind::kEcho, FaultKind::kStray, FaultKind::kHang})
    for (const double at_s : {0.05, 0.4, 0.9}) {
      GrblRig rig;
      rig.get_ready();
      rig.order(pass_of(rig, pattern));
      rig.run([] { return false; }, at_s);
      rig.twin.link().inject({"stage", kind, 3, 300'000}, rig.now_us);
      if (kind == FaultKind::kHang) {
        rig.run([] { return false; }, 8.0);
        rig.twin.link().inject({"stage", FaultKind::kResume, 1, 0}, rig.now_us);
      }
      rig.run([&] { return !rig.results.empty(); }, 120.0);
      INFO(firn::plant::fault_name(kind) << " at " << at_s << " s");
      REQUIRE(rig.results.size() == 1);
      const Result& r = rig.results[0];
      INFO(r.text);
      const auto fired = std::int64_t(rig.pulses_of(0).size());
      if (r.outcome == Outcome::kDone) CHECK(fired == 16);
      if (r.outcome == Outcome::kNone) CHECK(fired == 0);
      CHECK(fired <= 16);
      if (r.outcome == Outcome::kUnknown) {
        CHECK(r.unknown_from <= fired);
        CHECK(r.unknown_to >= fired);
      }
      CHECK_FALSE(rig.twin.output());
    }
}
