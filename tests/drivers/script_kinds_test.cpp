// The other classes of instruments that a class in Python drives: the questions, judgements and refusals of
// each.
#include <catch2/catch.hpp>

#include <cmath>

#include "drivers/camera/script_camera.h"
#include "drivers/gas/script_gas.h"
#include "drivers/heater/script_heater.h"
#include "drivers/jet/script_jet.h"
#include "drivers/laser_point/script_point.h"
#include "drivers/laser_profiler/script_profiler.h"
#include "drivers/stage/script_stage.h"
#include "tests/drivers/script_bench.h"

using namespace firn::drivers;
using Catch::Contains;
using firn::DeviceState;
using firn::Outcome;
using firn::drivers::test::ScriptBench;

namespace {

ScriptOptions script_of(const char* node) { return {node, "own.py", "Own", "", false, 0.0}; }

const std::string kDeclared = "timeout_s=1 safe_bytes=33 ";

template <class Kind>
struct KindBench {
  template <class... Args>
  explicit KindBench(const std::string& declared, Args&&... args)
      : driver(std::forward<Args>(args)...), bench(driver) {
    bench.become_safe(kDeclared + declared);
  }
  template <class Order>
  void order(Order o) {
    bench.command([&](std::int64_t t, Effects& fx) { o(driver, t, fx); });
  }
  Result last() const {
    const auto all = bench.template all<Result>();
    REQUIRE_FALSE(all.empty());
    return all.back();
  }
  std::string fault() const {
    const auto all = bench.template all<Fault>();
    return all.empty() ? "" : all.back().text;
  }

  Kind driver;
  ScriptBench bench;
};

firn::DropletPattern row_of(int droplets) {
  firn::GridSpec grid;
  grid.nx = droplets;
  grid.ny = 1;
  grid.pitch_x_mm = grid.pitch_y_mm = 0.5;
  grid.origin_x_mm = 10.0;
  grid.origin_y_mm = 5.0;
  return firn::DropletPattern(grid, 1);
}

using StageBench = KindBench<ScriptStage>;

StageBench moving_stage(const std::string& declared = "has_fire=1 has_scan=1") {
  return StageBench(declared, script_of("stage"), StageOptions{});
}

void run_row(StageBench& b, int droplets) {
  b.order([&](ScriptStage& s, std::int64_t t, Effects& fx) {
    s.run_pass(row_of(droplets), 0, NAN, 20.0, t, fx);
  });
}

}  // namespace

TEST_CASE("a heater's readings are judged here, and a channel that is too hot is set to off", "[script]") {
  KindBench<ScriptHeater> b("", script_of("heater"), HeaterOptions{});
  b.order([](ScriptHeater& h, std::int64_t t, Effects& fx) { h.set({30.0, 25.0, -50.0}, t, fx); });
  CHECK(b.bench.newest() == "call read");
  b.bench.done(": celsius=20,20,20 heating=0,0,0");
  CHECK(b.bench.newest() == "call set *celsius=30,25,nan");
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kDone);
  b.bench.advance_us(1'000'000);
  CHECK(b.bench.newest() == "call read");
  b.bench.done(": celsius=60,20,20 heating=1,1,0");
  CHECK_THAT(b.fault(), Contains("too hot"));
  CHECK(b.bench.newest() == "call set *celsius=nan,25,nan");
  CHECK(b.bench.all<Temperatures>().size() == 2);
}

TEST_CASE("a heater's set point above high_degC reaches no class", "[script]") {
  KindBench<ScriptHeater> b("", script_of("heater"), HeaterOptions{});
  b.bench.done(": celsius=20,20,20 heating=0,0,0");
  const std::size_t before = b.bench.calls.size();
  b.order([](ScriptHeater& h, std::int64_t t, Effects& fx) { h.set({46.0, 25.0, -50.0}, t, fx); });
  CHECK(b.last().outcome == Outcome::kRefused);
  CHECK(b.bench.calls.size() == before);
}

TEST_CASE("readings of the wrong number are a fault by name", "[script]") {
  KindBench<ScriptHeater> b("", script_of("heater"), HeaterOptions{});
  b.order([](ScriptHeater& h, std::int64_t t, Effects& fx) { h.set({30.0, 25.0, -50.0}, t, fx); });
  b.bench.done(": celsius=20 heating=0");
  CHECK_THAT(b.fault(), Contains("heater: own.py: Own.read: it returns no three numbers"));
}

TEST_CASE("the sheath's gas flows before the atomizer's, and both must be there", "[script]") {
  KindBench<ScriptGas> b("", script_of("gas"), GasOptions{});
  const auto read = [&](double atomizer, double sheath) {
    b.bench.done(": sccm=" + std::to_string(atomizer) + "," + std::to_string(sheath) + " kpa=101,101");
  };
  b.order([](ScriptGas& g, std::int64_t t, Effects& fx) { g.set(20.0, 40.0, t, fx); });
  if (b.bench.newest() == "call read") read(0, 0);
  CHECK(b.bench.newest() == "call set atomizer_sccm=0 sheath_sccm=40");
  b.bench.done();
  CHECK(b.bench.newest() == "call read");
  read(0, 40);
  CHECK(b.bench.newest() == "call set atomizer_sccm=20 sheath_sccm=40");
  b.bench.done();
  read(20, 40);
  CHECK(b.last().outcome == Outcome::kDone);
  CHECK(b.driver.state() == DeviceState::kActive);
}

TEST_CASE("a pressure behind the nozzle beyond its limit ends the gas", "[script]") {
  KindBench<ScriptGas> b("", script_of("gas"), GasOptions{});
  b.order([](ScriptGas& g, std::int64_t t, Effects& fx) { g.set(20.0, 40.0, t, fx); });
  b.bench.done(": sccm=0,0 kpa=101,150");
  CHECK_THAT(b.fault(), Contains("150.0 kPa behind the nozzle"));
  CHECK(b.bench.newest() == "stop");
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kFailed);
}

TEST_CASE("an atomizer's gas without a sheath's reaches no class", "[script]") {
  KindBench<ScriptGas> b("", script_of("gas"), GasOptions{});
  b.order([](ScriptGas& g, std::int64_t t, Effects& fx) { g.set(20.0, 0.0, t, fx); });
  CHECK(b.last().outcome == Outcome::kRefused);
  for (const std::string& call : b.bench.calls) CHECK(call.find(" set ") == call.npos);
}

TEST_CASE("a point laser gives a reading, and nothing where the class has none", "[script]") {
  KindBench<ScriptPoint> b("", script_of("laser_point"), LaserPointOptions{});
  const auto read = [&](const char* answer) {
    b.order([](ScriptPoint& p, std::int64_t t, Effects& fx) { p.reading(t, fx); });
    b.bench.done(answer);
    return b.bench.all<Samples>().back().z_mm.at(0);
  };
  CHECK(read(": value=1.25") == 1.25f);
  CHECK(std::isnan(read(": value=nan")));
}

TEST_CASE("a point laser without arm() takes no series, by name", "[script]") {
  KindBench<ScriptPoint> b("", script_of("laser_point"), LaserPointOptions{});
  b.order([](ScriptPoint& p, std::int64_t t, Effects& fx) { p.arm(0, 100, 0.01, t, fx); });
  CHECK(b.last().outcome == Outcome::kRefused);
  CHECK_THAT(b.last().text, Contains("Own has no method arm()"));
}

TEST_CASE("a series of a point laser ends with the samples that came", "[script]") {
  KindBench<ScriptPoint> b("has_arm=1 has_collect=1", script_of("laser_point"), LaserPointOptions{});
  b.order([](ScriptPoint& p, std::int64_t t, Effects& fx) { p.arm(1, 4, 0.01, t, fx); });
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kReady);
  b.order([](ScriptPoint& p, std::int64_t t, Effects& fx) { p.collect(t, fx); });
  b.bench.done(": value=1,2,3");
  CHECK(b.last().counted == 3);
  CHECK(b.bench.all<Samples>().back().period_s == 0.01);
}

TEST_CASE("a jet that is seen disarmed leaves its pass in doubt", "[script]") {
  KindBench<ScriptJet> b("has_armed=1", script_of("jet"));
  b.order([](ScriptJet& j, std::int64_t t, Effects& fx) { j.arm(100, t, fx); });
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kReady);
  b.bench.advance_us(1'000'000);
  CHECK(b.bench.newest() == "call armed");
  b.bench.done(": value=0");
  CHECK(b.bench.newest() == "stop");
  b.bench.done();
  b.order([](ScriptJet& j, std::int64_t t, Effects& fx) { j.disarm(t, fx); });
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kUnknown);
  CHECK(b.last().unknown_to == 100);
}

TEST_CASE("a jet that counts tells its droplets", "[script]") {
  KindBench<ScriptJet> b("", script_of("jet"));
  b.order([](ScriptJet& j, std::int64_t t, Effects& fx) { j.arm(100, t, fx); });
  b.bench.done();
  b.order([](ScriptJet& j, std::int64_t t, Effects& fx) { j.disarm(t, fx); });
  b.bench.done(": value=97");
  CHECK(b.last().outcome == Outcome::kDone);
  CHECK(b.last().counted == 97);
}

TEST_CASE("a jet whose program dies while armed leaves its pass in doubt", "[script]") {
  KindBench<ScriptJet> b("", script_of("jet"));
  b.order([](ScriptJet& j, std::int64_t t, Effects& fx) { j.arm(100, t, fx); });
  b.bench.done();
  b.bench.close_program();
  CHECK(b.bench.line == "!");
  CHECK_THAT(b.fault(), Contains("its program has ended"));
  b.bench.advance_us(200'000);
  b.bench.open_program();
  b.bench.done(": " + kDeclared);
  b.bench.done();
  b.bench.done(":jet");
  b.bench.done();
  b.order([](ScriptJet& j, std::int64_t t, Effects& fx) { j.disarm(t, fx); });
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kUnknown);
}

TEST_CASE("a camera's picture has the rows that the class returned", "[script]") {
  KindBench<ScriptCamera> b("", script_of("camera"), CameraOptions{});
  b.order([](ScriptCamera& c, std::int64_t t, Effects& fx) { c.sweep({1, 30.0, 0.0, 0.0, 0.0}, t, fx); });
  CHECK(b.bench.newest() == "call picture delay_us=30 exposure_us=100 gain_db=0");
  std::string pixels;
  for (int n = 0; n < 16 * 20; ++n) pixels += (n == 0 ? "" : ",") + std::to_string(n % 200);
  b.bench.done(": value=" + pixels + " value_rows=16");
  REQUIRE(b.bench.all<CameraShot>().size() == 1);
  const Picture p = b.bench.all<CameraShot>().front().picture;
  CHECK(p.width == 20);
  CHECK(p.height == 16);
  CHECK(p.pixels[21] == 21);
  CHECK(b.last().outcome == Outcome::kDone);
}

TEST_CASE("a picture that is none is a fault by name", "[script]") {
  for (const char* answer :
       {": value=1,2,3", ": value=1,2,3 value_rows=1", ": pixels=300 pixels_rows=1 white=255"}) {
    KindBench<ScriptCamera> b("", script_of("camera"), CameraOptions{});
    b.order([](ScriptCamera& c, std::int64_t t, Effects& fx) { c.sweep({1, 30.0, 0.0, 0.0, 0.0}, t, fx); });
    b.bench.done(answer);
    INFO(answer);
    CHECK_THAT(b.fault(), Contains("camera: own.py: Own.picture: "));
  }
}

TEST_CASE("a profiler's rows are passed on until the scan is complete", "[script]") {
  KindBench<ScriptProfiler> b("", script_of("laser_profiler"), LaserProfilerOptions{}, 1000.0);
  b.order([](ScriptProfiler& p, std::int64_t t, Effects& fx) { p.arm(3, t, fx); });
  b.bench.done();
  CHECK(b.bench.newest() == "call rows");
  b.bench.done();
  b.bench.advance_us(4'000);
  b.bench.done(": row=0,1 y_mm=1.5,2 x0_mm=0 dx_mm=0.5 z_mm=1,2,3,4");
  b.bench.advance_us(4'000);
  b.bench.done(": row=2 y_mm=2.5 x0_mm=0 dx_mm=0.5 z_mm=5,nan");
  const auto rows = b.bench.all<ProfileRow>();
  REQUIRE(rows.size() == 3);
  CHECK(rows[1].z_mm == std::vector<float>{3, 4});
  CHECK(rows[0].encoder_count == 1500);
  CHECK(b.bench.all<ScanDone>().front().rows_received == 3);
}

TEST_CASE("a row that is none of the scan is a fault by name", "[script]") {
  KindBench<ScriptProfiler> b("", script_of("laser_profiler"), LaserProfilerOptions{}, 1000.0);
  b.order([](ScriptProfiler& p, std::int64_t t, Effects& fx) { p.arm(3, t, fx); });
  b.bench.done();
  b.bench.done(": row=3 y_mm=1 x0_mm=0 dx_mm=0.5 z_mm=1,2");
  CHECK_THAT(b.fault(), Contains("Own.rows: row 3"));
}

TEST_CASE("a stage's row is a move to its start and one firing move, whose pulses are counted", "[script]") {
  StageBench b = moving_stage();
  run_row(b, 3);
  CHECK(b.bench.newest() == "call position");
  b.bench.done(": value=0,0,0");
  CHECK_THAT(b.bench.newest(), Contains("call move speed_mm_s=50 x_mm=") && Contains("y_mm=5"));
  b.bench.done();
  CHECK_THAT(b.bench.newest(), Contains("call fire *at_mm=10,10.5,11 "));
  b.bench.done(": value=3");
  CHECK(b.last().outcome == Outcome::kDone);
  CHECK(b.last().counted == 3);
}

TEST_CASE("a row of which a stage counted fewer pulses is in doubt as a whole", "[script]") {
  StageBench b = moving_stage();
  run_row(b, 3);
  b.bench.done(": value=0,0,0");
  b.bench.done();
  b.bench.done(": value=2");
  CHECK_THAT(b.fault(), Contains("2 of 3 pulses came"));
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kUnknown);
  CHECK(b.last().unknown_from == 0);
  CHECK(b.last().unknown_to == 3);
}

TEST_CASE("a stage that hangs on its way to the start has fired nothing", "[script]") {
  StageBench b = moving_stage();
  run_row(b, 3);
  b.bench.done(": value=0,0,0");
  b.bench.advance_us(60'000'000);
  CHECK(b.bench.line == "!");
  CHECK(b.last().outcome == Outcome::kNone);
  CHECK_THAT(b.fault(), Contains("Own.move: it has not returned within"));
}

TEST_CASE("a move may take as long as its way needs beyond the time of a method", "[script]") {
  StageBench b = moving_stage();
  b.order([](ScriptStage& s, std::int64_t t, Effects& fx) { s.move_to(100.0, NAN, NAN, 10.0, t, fx); });
  b.bench.done(": value=0,0,0");
  b.bench.advance_us(10'000'000);  // 100 mm at 10 mm/s
  CHECK(b.bench.line.empty());
  b.bench.done();
  CHECK(b.last().outcome == Outcome::kDone);
}

TEST_CASE("a stage without fire() refuses a pass by name, one without scan() a scan", "[script]") {
  StageBench b = moving_stage("has_move=1");
  run_row(b, 3);
  CHECK_THAT(b.last().text, Contains("Own has no method fire()"));
  b.order([](ScriptStage& s, std::int64_t t, Effects& fx) { s.scan(0, 0, NAN, 0.5, 10, 5.0, t, fx); });
  CHECK_THAT(b.last().text, Contains("Own has no method scan()"));
  CHECK(b.bench.calls.empty());
}

TEST_CASE("a stage in Python keeps the soft limits of every stage", "[script]") {
  StageBench b = moving_stage();
  b.order([](ScriptStage& s, std::int64_t t, Effects& fx) { s.move_to(151.0, NAN, NAN, 10.0, t, fx); });
  CHECK(b.last().outcome == Outcome::kRefused);
  CHECK(b.bench.calls.empty());
}
