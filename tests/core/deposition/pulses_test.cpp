#include "core/deposition/pulses.h"

#include <catch2/catch.hpp>

#include "core/deposition/delivery.h"
#include "tests/core/deposition/demands.h"

using namespace firn;
using namespace firn::deposition;
using namespace firn::deposition::test;

namespace {

const ValveLimits kPulseLimits;
ValveSetting proportional_valve(double pulse_s = 0.00125) {
  return {pulse_s, FlowCurve::proportional(kFeedForward, 500.0)};
}

// A closed form to count by: with nu = c_ff Q and Q = A c, drop k lies where the path is (k - 1/2) / (c_ff A)
// long.
double drops_per_mm(double width_mm) { return kFeedForward * width_mm * kLayer_mm; }

// The instants that plan_pulses() fires at for a frequency, each to half a tick.
std::vector<double> pulse_instants_s(const std::vector<double>& frequency_hz) {
  FlowDemand d{kStep, frequency_hz, std::vector<double>(frequency_hz.size(), 1.0), {}};
  for (double& flow : d.flow_mm3_s) flow /= kFeedForward;
  std::vector<double> instants;
  for (const PulseTrain& train : plan_pulses(d, proportional_valve(), kPulseLimits).trains)
    for (const std::uint16_t tick : train.ticks) instants.push_back(tick * kPulseLimits.tick_s);
  return instants;
}

}  // namespace

TEST_CASE(
    "Eq. (6.5) as printed sums rectangles, and the integral lags it by half a step of the last frequency") {
  const std::vector<double> nu{0.0, 100.0, 200.0, 200.0, 0.0};
  CHECK(pulses_needed_as_printed(nu, 0.01) == std::vector<double>{0.0, 1.0, 3.0, 5.0, 5.0});
  CHECK(pulses_needed(nu, 0.01) == std::vector<double>{0.0, 0.5, 2.0, 4.0, 5.0});
  // At steady frequency that lead is delta / 2 of time: 8 ms, 1 mm of path at 125 mm/s.
  const std::vector<double> steady(100, 50.0);
  CHECK(pulses_needed_as_printed(steady, kStep)[99] - pulses_needed(steady, kStep)[99] ==
        Approx(50.0 * kStep));
  CHECK(pulses_needed_as_printed(nu, 0.01)[3] - pulses_needed(nu, 0.01)[3] == Approx(0.5 * 0.01 * 200.0));
}

TEST_CASE("Erratum (6.6): pulses stand at 0.5, 1.5, ... ceil(max - 0.5) - 0.5") {
  for (const auto& [needed, count] : {std::pair{0.0, 0},
                                      {0.5, 0},
                                      {0.51, 1},
                                      {1.0, 1},
                                      {1.5, 1},
                                      {1.6, 2},
                                      {10.2, 10},
                                      {10.5, 10},
                                      {10.6, 11}})
    CHECK(pulse_count(needed) == count);
  RandomStream random(63, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> nu;
    for (std::uint32_t n = 2 + random.below(60); n > 0; --n)
      nu.push_back(random.below(5) == 0 ? 0.0 : random.uniform(0.0, 400.0));
    const std::vector<double> instants = pulse_instants_s(nu), needed = pulses_needed(nu, kStep);
    REQUIRE(std::int64_t(instants.size()) == pulse_count(needed.back()));
    for (std::size_t k = 0; k < instants.size(); ++k) {  // brute force: fine sums up to the instant
      double sum = 0.0;
      const int parts = 4000;
      for (int n = 0; n < parts; ++n) {
        const double t = instants[k] * (n + 0.5) / parts, i = t / kStep;
        const std::size_t at = std::min(std::size_t(i), nu.size() - 2);
        sum += (nu[at] + (nu[at + 1] - nu[at]) * (i - double(at))) * instants[k] / parts;
      }
      REQUIRE(sum == Approx(double(k) + 0.5).margin(0.5 * kPulseLimits.tick_s * 400.0));
      if (k == 20) break;
    }
  }
}

TEST_CASE("With a proportional valve each drop lands where counting says, to half a tick") {
  RandomStream random(64, Purpose::kTest);
  for (double width : {kBoundary_mm, kFill_mm})
    for (int trial = 0; trial < 30; ++trial) {
      const FlowDemand d = demand_of(random_speeds(random, random.uniform(5, 400), 125.0), width);
      const PulsePlan plan = plan_pulses(d, proportional_valve(), kPulseLimits);
      REQUIRE(plan.problem.empty());
      REQUIRE(plan.trains.size() == 1);
      const DemandIntegral path(d);
      const auto& ticks = plan.trains[0].ticks;
      REQUIRE(std::int64_t(ticks.size()) == pulse_count(path.total_length_mm() * drops_per_mm(width)));
      for (std::size_t k = 0; k < ticks.size(); ++k) {
        const double t = path.time_at_length_s((double(k) + 0.5) / drops_per_mm(width));
        REQUIRE(std::abs(ticks[k] * kPulseLimits.tick_s - t) <= 0.5 * kPulseLimits.tick_s + 1e-9);
        if (k > 0) REQUIRE(ticks[k] > ticks[k - 1]);
      }
      CHECK(plan.min_drops_per_mm == Approx(drops_per_mm(width)));
    }
}

TEST_CASE(
    "Delivered volume is within half a drop and one tick of what is wanted, at every point of every path") {
  RandomStream random(65, Purpose::kTest);
  double worst_drops = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    FlowDemand d = demand_of(
        random_speeds(random, trial % 50 < 2 ? 5000.0 : random.uniform(1, 300), random.uniform(60, 125)),
        random.uniform(0.8, 3.0));
    corrected_flow(std::vector<double>(d.flow_mm3_s),
                   random_action(random, d.flow_mm3_s.size(), random.uniform(0, 1.2)), d.flow_mm3_s);
    const ValveSetting setting{0.00125,
                               trial % 2 ? bent_curve(random) : FlowCurve::proportional(kFeedForward, 500.0)};
    clip_flow(d, max_flow_mm3_s(setting, kPulseLimits));
    const PulsePlan plan = plan_pulses(d, setting, kPulseLimits);
    const std::vector<Drop> drops = drops_of(plan, d, setting.curve, kPulseLimits.tick_s);
    const DeliveryError error =
        count_delivery(d, drops, granted_by(d, setting.curve, kPulseLimits.tick_s), 0.0);
    if (!plan.problem.empty()) continue;  // 5 m may need more than 131 s
    INFO("trial " << trial << " worst " << error.worst_mm3 << " at " << error.worst_at_s);
    REQUIRE(error.worst_excess_mm3 <= 1e-9);
    if (!drops.empty()) worst_drops = std::max(worst_drops, error.worst_mm3 / setting.curve.drop_mm3(10.0));
  }
  CHECK(worst_drops > 0.5);  // the bound is not idle
  CHECK(worst_drops < 1.6);
}

TEST_CASE("Over any 70 mm of boundary and any 35 mm of fill the volume is right to 1 %") {
  RandomStream random(66, Purpose::kTest);
  for (const auto& [width, window] : {std::pair{kBoundary_mm, 70.0}, {kFill_mm, 35.0}}) {
    double worst = 0.0;
    for (int trial = 0; trial < 100; ++trial) {
      const FlowDemand d = demand_of(random_speeds(random, 300.0, random.uniform(15, 125)), width);
      const ValveSetting setting = proportional_valve();
      const DeliveryError error = count_delivery(
          d, drops_of(plan_pulses(d, setting, kPulseLimits), d, setting.curve, kPulseLimits.tick_s), {},
          window);
      worst = std::max(worst, error.window_worst);
    }
    INFO("width " << width);
    CHECK(worst <= 0.01);
    CHECK(worst > 0.005);
  }
}

TEST_CASE(
    "Over every window at any control action the volume is right to one drop and the flow of one tick") {
  // u != 0: a window's volume is no whole number of drops. Every window of the length is counted, wherever it
  // starts.
  RandomStream random(68, Purpose::kTest);
  int below_one_percent = 0;
  for (const auto& [width, window] : {std::pair{kBoundary_mm, 70.0}, {kFill_mm, 35.0}})
    for (int trial = 0; trial < 60; ++trial) {
      const double u = trial % 3 == 0 ? 0.0 : random.uniform(-0.5, 0.5), hz = trial % 2 ? kFeedForward : 12.0;
      const double fastest = std::min(125.0, 450.0 / (hz * width * kLayer_mm * (1.0 + u)));
      FlowDemand d = demand_of(
          random_speeds(random, 300.0, random.uniform(std::min(15.0, 0.9 * fastest), fastest)), width);
      const double top = *std::max_element(d.speed_mm_s.begin(), d.speed_mm_s.end());
      corrected_flow(std::vector<double>(d.flow_mm3_s), std::vector<double>(d.flow_mm3_s.size(), u),
                     d.flow_mm3_s);
      const ValveSetting setting{0.0005, FlowCurve::proportional(hz, 500.0)};
      const DeliveryError error = count_delivery(
          d, drops_of(plan_pulses(d, setting, kPulseLimits), d, setting.curve, kPulseLimits.tick_s), {},
          window);
      const double bound = window_error_bound(d, setting.curve, kPulseLimits.tick_s, window);
      INFO("width " << width << " u " << u << " hz " << hz << " top " << top);
      CHECK(error.window_worst <= bound + 1e-9);
      CHECK(bound <= (1.0 / hz + top * width * kLayer_mm * (1.0 + u) * kPulseLimits.tick_s) /
                             (window * width * kLayer_mm * (1.0 + u)) +
                         1e-9);  // closed form
      if (bound <= 0.01) ++below_one_percent;
    }
  CHECK(below_one_percent > 20);
}

TEST_CASE("Erratum chapter 6: the frequency that is drawn as nominal is the corrected one, h(Q_cor)") {
  RandomStream random(67, Purpose::kTest);
  FlowDemand d = demand_of(random_speeds(random, 200.0, 100.0), kBoundary_mm);
  const std::size_t nominal = plan_pulses(d, proportional_valve(), kPulseLimits).trains[0].ticks.size();
  corrected_flow(std::vector<double>(d.flow_mm3_s), std::vector<double>(d.flow_mm3_s.size(), 0.3),
                 d.flow_mm3_s);
  const std::size_t corrected = plan_pulses(d, proportional_valve(), kPulseLimits).trains[0].ticks.size();
  CHECK(double(corrected) == Approx(1.3 * double(nominal)).margin(1.0));
}

TEST_CASE("(5.6), (5.13): the flow that lays 1 + u layers at any speed") {
  constexpr double kWidth_mm = 1.5, kHeight_mm = 0.25;
  const auto flow_for = [&](double u, double speed_mm_s) {  // the product computes (5.13) by (6.2), (6.3)
    double flow_mm3_s = 0.0;
    nominal_flow(kWidth_mm, kHeight_mm, {&speed_mm_s, 1}, {&flow_mm3_s, 1});
    const double nominal_mm3_s = flow_mm3_s;
    corrected_flow({&nominal_mm3_s, 1}, {&u, 1}, {&flow_mm3_s, 1});
    return flow_mm3_s;
  };
  CHECK(flow_for(0.0, 25.0) == Approx(9.375));
  CHECK(flow_for(0.2, 25.0) == Approx(11.25));
  RandomStream random(513, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    const double speed_mm_s = random.uniform(0.1, 150.0), u = random.uniform(-0.99, 2.0);
    const double section_mm2 = flow_for(u, speed_mm_s) / speed_mm_s;  // (5.6): what lies along the path
    CHECK(section_mm2 / (kWidth_mm * kHeight_mm) == Approx(1.0 + u));
  }
}

TEST_CASE("At the limit of 500 Hz every tick has one pulse") {
  FlowDemand d{kStep, std::vector<double>(101, 125.0), std::vector<double>(101, 125.0), {}};
  const auto ticks = plan_pulses(d, proportional_valve(), kPulseLimits).trains[0].ticks;
  REQUIRE(ticks.size() == 800);
  for (std::size_t k = 1; k < ticks.size(); ++k) REQUIRE(ticks[k] == ticks[k - 1] + 1);
  d.flow_mm3_s[50] = 125.1;
  CHECK_THROWS_WITH(plan_pulses(d, proportional_valve(), kPulseLimits),
                    Catch::Contains("instant 50") && Catch::Contains("above the valve"));
  const Shortfall short_of = clip_flow(d, max_flow_mm3_s(proportional_valve(), kPulseLimits));
  CHECK(short_of.instants == 1);
  CHECK(short_of.first == 50);
  CHECK(short_of.volume_mm3 == Approx(0.1 * kStep));
  CHECK_NOTHROW(plan_pulses(d, proportional_valve(), kPulseLimits));
}

TEST_CASE("A demand that is not finite, too short or has a stop outside is refused by name") {
  const ValveSetting s = proportional_valve();
  const auto plan = [&](FlowDemand d) { return plan_pulses(d, s, kPulseLimits); };
  CHECK_THROWS_WITH(plan({kStep, {1.0}, {1.0}, {}}), Catch::Contains("two instants"));
  CHECK_THROWS_WITH(plan({kStep, {1.0, 2.0}, {1.0}, {}}), Catch::Contains("length"));
  CHECK_THROWS_WITH(plan({kStep, {1.0, -2.0}, {1.0, 1.0}, {}}), Catch::Contains("instant 1"));
  CHECK_THROWS_WITH(plan({0.0, {1.0, 2.0}, {1.0, 1.0}, {}}), Catch::Contains("step_s"));
  CHECK_THROWS_WITH(plan({kStep, {1.0, 2.0, 1.0}, {1.0, 1.0, 1.0}, {2}}), Catch::Contains("stop 0"));
  CHECK_THROWS_AS(plan({kStep, {1.0, std::nan("")}, {1.0, 1.0}, {}}), std::invalid_argument);
}
