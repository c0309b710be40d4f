#include "core/control/lines/line_controller.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/aerosol/paper_jobs.h"
#include "core/path/bytes.h"
#include "core/path/job_codec.h"

using namespace firn;
using namespace firn::control;

namespace {

LineSetup two_lines() {
  LineSetup s;
  s.job = {{0, -1}, {0, 2}, {{{0, 0}, {6, 0}, 3.0}, {{6, 1}, {0, 1}, 3.0}}};
  s.machine.axis = {4.0, 30.0};
  s.machine.flow_mm3_s = 0.005;
  s.machine.shutter_delay_s = 0.01;
  s.options.layers = 20;
  s.gains = {0.8, 0.1, 0.0, 2.0};
  s.output_limit = 0.4;
  return s;
}

/// Nature of the tests: section = flow x solids / speed, ends as late as the shutter's delays are off.
struct Nature {
  double open_s = 0.04, close_s = 0.06;
  std::vector<double> area;
  LineMeasurement measure(const LineController& c, const LineDecision& d, int layer, double flow) {
    if (area.empty()) area.assign(c.stations().size(), 0.0);
    LineMeasurement m;
    m.layer = layer;
    m.total = m.last = std::vector<LineReading>(c.stations().size());
    for (std::size_t s = 0; s < area.size(); ++s) {
      m.last[s].area_mm2 = flow * 0.005 * 0.2 / d.speed_mm_s[s];
      area[s] += m.last[s].area_mm2;
      m.total[s].area_mm2 = area[s];
    }
    m.start_error_mm = 3.0 * (open_s - d.open_delay_s);
    m.end_error_mm = 3.0 * (close_s - d.close_delay_s);
    return m;
  }
};

LineMeasurement unprinted(const LineController& c) {
  LineMeasurement m;
  m.total = m.last = std::vector<LineReading>(c.stations().size());
  m.start_error_mm = m.end_error_mm = NAN;
  return m;
}

}  // namespace

TEST_CASE("A constant error of the flow is gone after a few layers, and open loop keeps it") {
  for (const bool feedback : {true, false}) {
    LineSetup setup = two_lines();
    setup.feedback = feedback;
    LineController c(setup);
    Nature nature;
    LineDecision d = c.decide(unprinted(c));
    for (int layer = 1; layer <= 12; ++layer) {
      const LineMeasurement m = nature.measure(c, d, layer, 1.2);
      d = c.decide(m);
    }
    const double share = nature.area[3] / (12 * c.nominal_area_mm2(3));
    INFO("feedback " << feedback << ", share " << share);
    if (feedback)
      CHECK(std::abs(share - 1.0) < 0.005);
    else
      CHECK(share == Approx(1.2));
  }
}

TEST_CASE("A flow that drifts by 20 % over the print is fed forward: the last layers are met") {
  double worst[2] = {};
  for (const OnOff forward : {OnOff::kOff, OnOff::kOn}) {
    LineSetup setup = two_lines();
    setup.options.feed_forward = forward;
    LineController c(setup);
    Nature nature;
    LineDecision d = c.decide(unprinted(c));
    for (int layer = 1; layer <= 12; ++layer) {
      const LineMeasurement m = nature.measure(c, d, layer, 1.0 + 0.2 * layer / 12.0);
      d = c.decide(m);
      if (layer > 4)
        worst[forward == OnOff::kOn] = std::max(
            worst[forward == OnOff::kOn], std::abs(m.total[0].area_mm2 / c.nominal_area_mm2(0) - layer));
    }
  }
  CHECK(worst[1] < 0.02);
  CHECK(worst[1] < 0.5 * worst[0]);
}

TEST_CASE("The shutter's delays follow from starts and ends after one layer") {
  LineController c(two_lines());
  Nature nature;
  LineDecision d = c.decide(unprinted(c));
  CHECK(d.open_delay_s == 0.01);
  d = c.decide(nature.measure(c, d, 1, 1.0));
  CHECK(d.open_delay_s == Approx(0.04));
  CHECK(d.close_delay_s == Approx(0.06));
  LineSetup fixed = two_lines();
  fixed.options.identify_shutter = OnOff::kOff;
  LineController f(fixed);
  d = f.decide(unprinted(f));
  d = f.decide(nature.measure(f, d, 1, 1.0));
  CHECK(d.open_delay_s == 0.01);
}

TEST_CASE("A layer that is measured twice is learned from once") {
  LineController once(two_lines()), twice(two_lines());
  Nature nature;
  const LineMeasurement m = nature.measure(once, once.decide(unprinted(once)), 1, 1.3);
  twice.decide(unprinted(twice));
  twice.decide(m);
  const LineDecision a = once.decide(m), b = twice.decide(m);
  CHECK(a.speed_mm_s == b.speed_mm_s);
  CHECK(a.open_delay_s == b.open_delay_s);
}

TEST_CASE(
    "A way begins and ends at rest, goes through its knots, and the shutter is open over the job's length") {
  LineController c(two_lines());
  const LineDecision d = c.decide(unprinted(c));
  const LineWay& w = d.way;
  REQUIRE(w.t_s.size() > 4);
  CHECK(w.t_s.front() == 0.0);
  for (std::size_t k = 1; k < w.t_s.size(); ++k) {
    CHECK(w.t_s[k] > w.t_s[k - 1]);
    // Constant acceleration: the mean of two speeds times the time is the way.
    const double dt = w.t_s[k] - w.t_s[k - 1];
    CHECK(w.x_mm[k] - w.x_mm[k - 1] == Approx(0.5 * (w.vx_mm_s[k] + w.vx_mm_s[k - 1]) * dt).margin(1e-6));
    CHECK(w.y_mm[k] - w.y_mm[k - 1] == Approx(0.5 * (w.vy_mm_s[k] + w.vy_mm_s[k - 1]) * dt).margin(1e-6));
  }
  for (const double v : {w.vx_mm_s.front(), w.vy_mm_s.front(), w.vx_mm_s.back(), w.vy_mm_s.back()})
    CHECK(std::abs(v) < 1e-6);
  REQUIRE(w.switch_mm.size() == 4);
  // At constant speed over the lines, both delays alike.
  CHECK(w.switch_mm[1] - w.switch_mm[0] == Approx(6.0).margin(0.01));
  CHECK(w.switch_mm[3] - w.switch_mm[2] == Approx(6.0).margin(0.01));
}

TEST_CASE("Speeds that differ along one line stay on the line, without a loop") {
  LineSetup setup = two_lines();
  LineController c(setup);
  LineDecision d = c.decide(unprinted(c));
  Nature nature;
  LineMeasurement m = nature.measure(c, d, 1, 1.0);
  for (std::size_t s = 0; s < m.total.size(); ++s) {
    m.last[s].area_mm2 *= 1.0 + 0.1 * double(s % 6);
    m.total[s].area_mm2 = m.last[s].area_mm2;
  }
  d = c.decide(m);
  CHECK(d.kind == PlanDecision::kPrint);
  CHECK(d.speed_mm_s[0] != d.speed_mm_s[4]);
  CHECK(d.way.switch_mm.size() == 4);
  for (const double v : d.speed_mm_s) {
    CHECK(v <= 0.98 * 4.0);
    CHECK(v >= 0.7 * 3.0);
  }
}

TEST_CASE("Stations are whole stretches, know the room beside them, and ends know whether they are free") {
  const PrintJob job{
      {0, 0}, {0, 0}, {{{0, 0}, {3.3, 0}, 3.0}, {{3.3, 0}, {3.3, 2}, 3.0}, {{0, 0.4}, {2, 0.4}, 3.0}}};
  const auto stations = line_stations(job, 1.0);
  REQUIRE(stations.size() == 4 + 2 + 2);
  CHECK(stations[0].to_mm == Approx(0.825));
  CHECK(stations[0].room_mm == Approx(0.4));
  CHECK(stations[3].room_mm == 0.0);          // at the corner
  CHECK(stations[5].room_mm == Approx(1.0));  // to the corner
  const auto ends = line_ends(job, 0.5);
  REQUIRE(ends.size() == 4);
  CHECK(!ends[0].free);
  CHECK(ends[1].free);
  CHECK(!ends[2].free);
  CHECK(!ends[3].free);
}

TEST_CASE("A curve of segments is one line: its stations have the room of the curve, open or closed") {
  for (const int sides : {13, 24, 100}) {
    for (const bool closed : {false, true}) {
      const double radius = 3.5, turn = 2.0 * 3.141592653589793 / sides;
      const auto corner = [&](int n) {
        return Point2{radius * std::cos(n % sides * turn), radius * std::sin(n % sides * turn)};
      };
      PrintJob job{corner(0), corner(0), {}};
      for (int n = 0; n < (closed ? sides : sides / 2); ++n)
        job.segments.push_back({corner(n), corner(n + 1), 3.0});
      for (const LineStation& s : line_stations(job, 1.0)) {
        INFO(sides << " sides, segment " << s.segment);
        CHECK(s.room_mm > 0.5 * radius);
        CHECK(s.line == 0);
      }
    }
  }
}

TEST_CASE("A job is read back from its bytes, and damaged bytes are refused by place") {
  const PrintJob job = motion::thompson_fig7();
  const auto bytes = encode_job(job);
  const PrintJob back = decode_job(bytes);
  REQUIRE(back.segments.size() == job.segments.size());
  CHECK(back.segments[2].to == job.segments[2].to);
  CHECK(back.end == job.end);
  for (std::size_t n = 0; n < bytes.size(); n += 7)
    CHECK_THROWS_AS(decode_job(std::span(bytes).first(n)), FormatError);
}

TEST_CASE("A job that the machine cannot print is refused with segment and reason") {
  LineSetup setup = two_lines();
  setup.job.segments[1].speed_mm_s = 9.0;
  CHECK_THROWS_WITH(LineController(setup), Catch::Contains("segments["));
  setup.job.segments.clear();
  CHECK_THROWS_WITH(LineController(setup), Catch::Contains("no segments"));
  CHECK_THROWS_WITH(decode_job(encode_job(setup.job)), Catch::Contains("no segments"));
}
