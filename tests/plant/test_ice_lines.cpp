#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "plant/ice/heat.h"
#include "plant/ice/line.h"

using namespace firn;
using namespace firn::plant;

namespace {

IceWorldConfig quiet() {
  IceWorldConfig c;
  for (IceLineParams& line : c.line) line.pulsation = 0.0;
  return c;
}

// The same line with the valve open for a while instead of a blow at once: s and the volume by Runge-Kutta.
struct FineLine {
  explicit FineLine(const IceLineParams& params) : p(params) {}
  double flow(double s) const { return open_flow_mm3_s(p, p.tank_pressure_kpa * (1.0 - s), 20.0); }
  double rate(double s, bool open) const {
    return -s / p.line_tau_s + (open ? p.line_drop * flow(s) / (p.full_flow_mm3_s * p.line_tau_s) : 0.0);
  }
  double run(double span_s, bool open) {
    const int steps = std::max(1, int(span_s / 2e-6));
    const double h = span_s / steps;
    double volume = 0.0;
    for (int n = 0; n < steps; ++n) {
      const double a = rate(sag, open), b = rate(sag + 0.5 * h * a, open), c = rate(sag + 0.5 * h * b, open);
      const double d = rate(sag + h * c, open);
      if (open) volume += h * flow(sag + 0.5 * h * a);
      sag += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    return volume;
  }
  IceLineParams p;
  double sag = 0.0;
};

}  // namespace

TEST_CASE("The lines of Table 2-2: viscosity at 40 degC, 200 mm3/s through the open valve, more when warm") {
  const IceWorldConfig c;
  CHECK(viscosity_mm2_s(c.line[0], 40.0) == Approx(0.685));
  CHECK(viscosity_mm2_s(c.line[1], 40.0) == Approx(4.7));
  CHECK(viscosity_mm2_s(c.line[0], 20.0) ==
        Approx(1.045).epsilon(0.02));  // water: 1.004 at 20, 0.658 at 40 degC
  for (const IceLineParams& line : c.line) {
    CHECK(open_flow_mm3_s(line, line.tank_pressure_kpa, 20.0) == Approx(200.0));
    CHECK(open_flow_mm3_s(line, line.tank_pressure_kpa, 30.0) > 200.0);
    CHECK(open_flow_mm3_s(line, 0.0, 20.0) == 0.0);
  }
  const auto ratio = [&](int n) {
    return open_flow_mm3_s(c.line[std::size_t(n)], c.line[std::size_t(n)].tank_pressure_kpa, 30.0) / 200.0;
  };
  CHECK(ratio(1) > ratio(0));  // the viscous one gains more
}

TEST_CASE("Flow rises with frequency as in Fig. 6-1: in proportion at first, ever less at high frequency") {
  const IceWorldConfig c = quiet();
  for (int n = 0; n < 2; ++n) {
    const Line line(c.line[std::size_t(n)], 1, n);
    const double low = line.steady_pulse_mm3(2.0, 0.00125);
    CHECK(low == Approx(0.25).epsilon(1e-3));  // 200 mm3/s x 1.25 ms: 4 Hz/(mm3/s), the thesis's c_ff
    CHECK(line.steady_pulse_mm3(60.0, 0.00125) == Approx(low).epsilon(0.01));
    double before = 0.0, slope_before = 1e9;
    for (double hz = 20.0; hz <= 500.0; hz += 20.0) {
      const double flow = hz * line.steady_pulse_mm3(hz, 0.00125);
      CHECK(flow > before);
      CHECK(flow - before < slope_before + 1e-9);
      slope_before = flow - before;
      before = flow;
    }
    CHECK(before < 0.85 * 500.0 * low);
    CHECK(before < 200.0);
  }
}

TEST_CASE("Pulse by pulse the volume settles on the closed form of a steady frequency") {
  const IceWorldConfig c = quiet();
  for (const double hz : {5.0, 40.0, 125.0, 333.0, 500.0}) {
    Line line(c.line[1], 3, 1);
    double volume = 0.0;
    for (int k = 0; k < 400; ++k) volume = line.pulse(k / hz, 0.00125);
    CHECK(volume == Approx(line.steady_pulse_mm3(hz, 0.00125)).epsilon(1e-9));
  }
}

TEST_CASE("Volumes given per pulse agree with a fine integration of the open and closed valve") {
  IceWorldConfig c = quiet();
  RandomStream random(5, Purpose::kTest);
  for (std::size_t n = 0; n < 2; ++n) {
    c.line[n].recovery_share = 0.0;  // the opening itself is given in both
    Line line(c.line[n], 1, int(n));
    FineLine fine(c.line[n]);
    double t_s = 0.0, all = 0.0, all_fine = 0.0, worst = 0.0;
    for (int k = 0; k < 300; ++k) {
      const double gap_s = k % 40 == 0 ? 0.3 : random.uniform(0.0009, 0.012);
      const double v = line.pulse(t_s, 0.00125), w = fine.run(0.00125, true);
      fine.run(gap_s, false);
      t_s += 0.00125 + gap_s;
      all += v;
      all_fine += w;
      worst = std::max(worst, std::abs(v / w - 1.0));
    }
    INFO("line " << n << ", worst pulse " << worst);
    CHECK(worst < 2e-3);
    CHECK(all == Approx(all_fine).epsilon(1e-3));
  }
}

TEST_CASE("Drift goes to either side and comes in the end to what was planted") {
  for (const double drift : {-0.2, 0.2}) {
    IceWorldConfig c = quiet();
    c.line[0].drift = drift;
    Line line(c.line[0], 1, 0);
    const double at_first = line.steady_pulse_mm3(20.0, 0.00125);
    line.set_slow({}, c.line[0].drift_tau_s);
    CHECK(line.steady_pulse_mm3(20.0, 0.00125) ==
          Approx(at_first * (1.0 + drift * (1.0 - std::exp(-1.0)))).epsilon(2e-4));
    line.set_slow({}, 1e7);
    CHECK(line.steady_pulse_mm3(20.0, 0.00125) == Approx(at_first * (1.0 + drift)).epsilon(2e-4));
  }
}

TEST_CASE("An empty tank and a blocked line let the flow go to nothing, and it comes back") {
  const IceWorldConfig c = quiet();
  for (const bool empty : {true, false}) {
    Line line(c.line[0], 1, 0);
    double t_s = 0.0;
    const auto run = [&](double for_s) {
      double v = 0.0;
      for (const double end = t_s + for_s; t_s < end; t_s += 0.02) v = line.pulse(t_s, 0.00125);
      return v;
    };
    const double before = run(1.0);
    if (empty)
      line.set_slow({20.0, 0.0, true}, t_s);
    else
      line.block(true);
    CHECK(run(1.0) < 1e-3 * before);
    if (empty)
      line.set_slow({20.0, 0.0, false}, t_s);
    else
      line.block(false);
    CHECK(run(1.0) == Approx(before).epsilon(1e-3));
  }
}

TEST_CASE("A thermostat switches with the period of the closed form") {
  IceWorldConfig c;
  c.heat.link_W_K = {0.0, 0.0};
  Heat heat(c);
  const double tau_s = c.heat.capacity_J_K[1] / c.heat.loss_W_K[1];
  const double low = c.heat.set_degC[1] - c.heat.hysteresis_K,
               high = c.heat.set_degC[1] + c.heat.hysteresis_K;
  const double hot = c.heat.ambient_degC + c.heat.heater_W[1] / c.heat.loss_W_K[1];
  const double on_s = tau_s * std::log((hot - low) / (hot - high));
  const double off_s = tau_s * std::log((high - c.heat.ambient_degC) / (low - c.heat.ambient_degC));
  std::vector<double> switched_s;
  bool before = heat.relay(1);
  for (std::int64_t t_us = 0; t_us < 3'600'000'000; t_us += 10'000) {
    heat.advance(t_us);
    if (heat.relay(1) != before) switched_s.push_back(double(t_us) * 1e-6);
    before = heat.relay(1);
  }
  REQUIRE(switched_s.size() > 20);
  const std::size_t pairs = (switched_s.size() - 3) / 2;
  const double period_s = (switched_s[1 + 2 * pairs] - switched_s[1]) / double(pairs);
  CHECK(period_s == Approx(on_s + off_s).epsilon(2e-4));
}

TEST_CASE("Coils gain 20 % of flow at 500 Hz, slowly, and how often the plant looks does not matter") {
  const IceWorldConfig c;
  Heat often(c), seldom(c);
  for (int k = 0; k < 500 * 60; ++k) {
    often.fired(0, 0.2);
    seldom.fired(0, 0.2);
    const auto t_us = std::int64_t(k + 1) * 2000;
    if (k % 5 == 4) often.advance(t_us);
    seldom.keep_up(t_us);
  }
  often.advance(60'000'000);
  seldom.advance(60'000'000);
  const double closed = 0.20 * (1.0 - std::exp(-60.0 / c.line[0].coil_tau_s));
  CHECK(often.state().coil[0] == Approx(closed).epsilon(1e-5));
  CHECK(seldom.state().coil[0] == Approx(closed).epsilon(1e-5));
  CHECK(seldom.state().section_degC[0] == Approx(often.state().section_degC[0]).margin(0.02));
  CHECK(seldom.state().tank_mm3[0] == Approx(c.line[0].tank_mm3 - 6000.0).epsilon(1e-9));
  CHECK(often.state().coil[1] == 0.0);
}

TEST_CASE("A tank runs empty at its time and stays empty") {
  IceWorldConfig c;
  c.line[1].tank_mm3 = 10.0;
  Heat heat(c);
  for (int k = 0; k < 100; ++k) heat.fired(1, 0.25);
  heat.advance(1'000'000);
  CHECK(heat.state().tank_mm3[1] == 0.0);
  heat.advance(5'000'000);
  CHECK(heat.state().tank_mm3[1] == 0.0);
  CHECK(heat.state().tank_mm3[0] == c.line[0].tank_mm3);
}

TEST_CASE(
    "Without heater (a) the laser's heater keeps the valves from freezing, and without both they freeze") {
  const IceWorldConfig c;
  Heat one(c), none(c);
  one.break_heater(0, true);
  none.break_heater(0, true);
  none.break_heater(1, true);
  none.break_heater(2, true);
  one.advance(3'600'000'000);
  none.advance(3'600'000'000);
  CHECK(one.state().section_degC[0] > c.heat.freeze_sme_degC);
  CHECK(one.state().section_degC[0] < c.heat.set_degC[0] - c.heat.hysteresis_K);
  CHECK(none.state().section_degC[0] < c.heat.freeze_degC);
}

TEST_CASE("An open thermocouple shows nothing and switches its heater off, and a stuck relay heats on") {
  const IceWorldConfig c;
  Heat open(c), stuck(c);
  open.open_thermocouple(2, true);
  stuck.stick_relay(1, true);
  open.advance(600'000'000);
  stuck.advance(600'000'000);
  CHECK(std::isnan(open.shown_degC(2)));
  CHECK_FALSE(open.relay(2));
  CHECK(stuck.state().section_degC[1] > c.heat.set_degC[1] + 5.0);
  stuck.stick_relay(1, false);
  CHECK_FALSE(stuck.relay(1));
}
