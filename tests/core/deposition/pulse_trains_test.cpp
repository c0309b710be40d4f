#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "core/deposition/delivery.h"
#include "core/deposition/pulse_width.h"
#include "core/deposition/pulses.h"
#include "tests/core/deposition/demands.h"

using namespace firn;
using namespace firn::deposition;
using namespace firn::deposition::test;

namespace {

const ValveLimits kLimits;
ValveSetting proportional(double pulse_s = 0.00125, double hz_per_mm3_s = kFeedForward) {
  return {pulse_s, FlowCurve::proportional(hz_per_mm3_s, 500.0)};
}

// Pieces from rest to rest, one behind the other, with a stop between them.
FlowDemand with_stops(RandomStream& random, int pieces, double length_mm, double width_mm,
                      double top_mm_s = 125.0) {
  std::vector<double> speeds{0.0};
  std::vector<std::size_t> stops;
  for (int n = 0; n < pieces; ++n) {
    const std::vector<double> piece = random_speeds(random, length_mm, top_mm_s);
    speeds.insert(speeds.end(), piece.begin() + 1, piece.end());
    if (n + 1 < pieces) stops.push_back(speeds.size() - 1);
  }
  FlowDemand d = demand_of(std::move(speeds), width_mm);
  d.stops = stops;
  return d;
}

std::vector<double> absolute_times(const PulsePlan& plan, const FlowDemand& d) {
  std::vector<double> times;
  for (const PulseTrain& t : plan.trains)
    for (std::uint16_t tick : t.ticks)
      times.push_back(d.step_s * double(t.first_instant) + kLimits.tick_s * tick);
  return times;
}

}  // namespace

TEST_CASE("A path of more than 131.072 s or 16,384 entries is cut at its stops and loses no drop") {
  RandomStream random(71, Purpose::kTest);
  for (const auto& [pieces, length, width, top] : {std::tuple{8, 1000.0, 1.5, 20.0},
                                                   {12, 2000.0, 3.0, 125.0},
                                                   {60, 100.0, 3.0, 90.0},
                                                   {400, 8.0, 1.5, 20.0}}) {
    const FlowDemand d = with_stops(random, pieces, length, width, top);
    const PulsePlan plan = plan_pulses(d, proportional(), kLimits);
    REQUIRE(plan.problem.empty());
    REQUIRE(plan.trains.size() > (length > 100.0 ? 1u : 0u));
    std::size_t entries = 0, behind = 0;
    for (const PulseTrain& t : plan.trains) {
      CHECK(t.first_instant == behind);
      CHECK((t.first_instant == 0 ||
             std::find(d.stops.begin(), d.stops.end(), t.first_instant) != d.stops.end()));
      CHECK(double(t.last_instant - t.first_instant) * d.step_s <= kLimits.max_duration_s + 1e-9);
      CHECK(t.ticks.size() <= std::size_t(kLimits.max_entries));
      CHECK(std::adjacent_find(t.ticks.begin(), t.ticks.end(), std::greater_equal<>()) == t.ticks.end());
      entries += t.ticks.size();
      behind = t.last_instant;
    }
    CHECK(behind == d.flow_mm3_s.size() - 1);
    const double wanted = DemandIntegral(d).total_volume_mm3();
    CHECK(double(entries) == double(pulse_count(kFeedForward * wanted)));
    const DeliveryError error = count_delivery(d, drops_of(plan, d, proportional().curve, kLimits.tick_s),
                                               granted_by(d, proportional().curve, kLimits.tick_s), 0.0);
    CHECK(error.worst_excess_mm3 <= 1e-9);
  }
}

TEST_CASE("Each list is as long as the limits let it be: one more piece would not fit") {
  RandomStream random(72, Purpose::kTest);
  const FlowDemand d = with_stops(random, 300, 60.0, 3.0);
  const PulsePlan plan = plan_pulses(d, proportional(), kLimits);
  const std::vector<double> times = absolute_times(plan, d);
  REQUIRE(plan.trains.size() > 2);
  for (std::size_t n = 0; n + 1 < plan.trains.size(); ++n) {
    const PulseTrain& t = plan.trains[n];
    const auto next = std::upper_bound(d.stops.begin(), d.stops.end(), t.last_instant);
    const std::size_t end = next == d.stops.end() ? d.flow_mm3_s.size() - 1 : *next;
    const double from = d.step_s * double(t.first_instant), to = d.step_s * double(end);
    const auto entries =
        std::count_if(times.begin(), times.end(), [&](double s) { return s >= from && s < to; });
    CHECK((to - from > kLimits.max_duration_s || entries > kLimits.max_entries));
  }
}

TEST_CASE("A path that may stop nowhere within the limits is refused with the limit and the place") {
  RandomStream random(73, Purpose::kTest);
  const FlowDemand slow = demand_of(random_speeds(random, 3000.0, 20.0), kBoundary_mm);
  PulsePlan plan = plan_pulses(slow, proportional(), kLimits);
  CHECK(plan.trains.empty());
  CHECK_THAT(plan.problem, Catch::Contains("131.07") && Catch::Contains("stop before"));
  const DemandIntegral path(slow);
  CHECK(plan.stop_before_mm == Approx(path.length_mm(131.072)).margin(20.0 * kStep));
  const FlowDemand dense = demand_of(random_speeds(random, 6000.0, 125.0), kFill_mm);
  plan = plan_pulses(dense, proportional(), kLimits);
  CHECK_THAT(plan.problem, Catch::Contains("16384 entries"));
  CHECK(plan.stop_before_mm == Approx(16384.0 / 3.0).margin(4.0));
}

TEST_CASE("A later piece that is too dense is refused by its entries, however long the path is until there") {
  RandomStream random(74, Purpose::kTest);
  std::vector<double> speeds = random_speeds(random, 3000.0, 125.0);
  const std::size_t stop = speeds.size() - 1;
  const std::vector<double> dense = random_speeds(random, 6000.0, 125.0);
  speeds.insert(speeds.end(), dense.begin() + 1, dense.end());
  FlowDemand d = demand_of(std::move(speeds), kFill_mm);
  d.stops = {stop};
  REQUIRE(kStep * double(d.flow_mm3_s.size() + stop) > kLimits.max_duration_s);
  REQUIRE(kStep * double(dense.size()) < kLimits.max_duration_s);
  const PulsePlan plan = plan_pulses(d, proportional(), kLimits);
  CHECK(plan.problem_from == stop);
  CHECK_THAT(plan.problem, Catch::Contains("16384 entries"));
}

TEST_CASE("Without material the list is empty") {
  FlowDemand d{kStep, std::vector<double>(50, 0.0), std::vector<double>(50, 25.0), {}};
  const PulsePlan plan = plan_pulses(d, proportional(), kLimits);
  REQUIRE(plan.trains.size() == 1);
  CHECK(plan.trains[0].ticks.empty());
  CHECK(plan.min_drops_per_mm == 0.0);
}

TEST_CASE("A delivery that runs backwards has the same worst window") {
  RandomStream random(77, Purpose::kTest);
  for (int trial = 0; trial < 40; ++trial) {
    CAPTURE(trial);
    FlowDemand d = demand_of(random_speeds(random, 60.0, 60.0), 1.2);
    corrected_flow(std::vector<double>(d.flow_mm3_s), random_action(random, d.flow_mm3_s.size(), 0.9),
                   d.flow_mm3_s);
    const DemandIntegral path(d);
    std::vector<Drop> drops, backwards;
    for (double s = random.uniform(0, 3); s < path.total_length_mm(); s += random.uniform(2.0, 6.0))
      drops.push_back({path.time_at_length_s(s), random.uniform(0.1, 1.0)});
    for (std::size_t n = drops.size(); n-- > 0;)
      backwards.push_back({d.duration_s() - drops[n].time_s, drops[n].volume_mm3});
    FlowDemand other = d;
    std::reverse(other.flow_mm3_s.begin(), other.flow_mm3_s.end());
    std::reverse(other.speed_mm_s.begin(), other.speed_mm_s.end());
    const double worst = count_delivery(d, drops, {}, 10.0).window_worst;
    CHECK(count_delivery(other, backwards, {}, 10.0).window_worst == Approx(worst).epsilon(1e-6));
  }
}

TEST_CASE("The counter itself: windows and running error against brute force over a fine grid") {
  RandomStream random(75, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    const FlowDemand d = demand_of(random_speeds(random, 60.0, 60.0), 1.2);
    const DemandIntegral path(d);
    std::vector<Drop> drops;
    for (double s = random.uniform(0, 1); s < path.total_length_mm(); s += random.uniform(0.2, 3.0))
      drops.push_back({path.time_at_length_s(s), random.uniform(0.1, 1.0)});
    const double window = 20.0;
    const DeliveryError error = count_delivery(d, drops, {0.5, kLimits.tick_s}, window);
    const auto delivered = [&](double until_s) {
      double sum = 0.0;
      for (const Drop& drop : drops) sum += drop.time_s <= until_s ? drop.volume_mm3 : 0.0;
      return sum;
    };
    // Windows a little longer (or shorter) than asked hold every drop that an exact one can (or must) hold.
    double worst = 0.0, at_least = 0.0, at_most = 0.0;
    const double fine = 0.01;
    for (double s = 0.0; s <= path.total_length_mm(); s += fine) {
      const double t = path.time_at_length_s(s);
      worst = std::max(worst, std::abs(delivered(t) - path.volume_mm3(t)));
      if (s + window > path.total_length_mm()) continue;
      const double t1 = path.time_at_length_s(s + window), volume = path.volume_mm3(t1) - path.volume_mm3(t);
      at_least = std::max(at_least, std::abs((delivered(t1) - delivered(t)) / volume - 1.0));
      const double more = delivered(path.time_at_length_s(s + window + fine)) -
                          delivered(path.time_at_length_s(s - fine) - 1e-9);
      const double fewer =
          delivered(path.time_at_length_s(s + window - fine)) - delivered(path.time_at_length_s(s + fine));
      at_most = std::max({at_most, more / volume - 1.0, 1.0 - fewer / volume});
    }
    CHECK(error.worst_mm3 >= worst - 1e-12);
    CHECK(error.worst_mm3 <= worst + fine * 0.3 + 1e-9);
    CHECK(error.window_worst >= at_least - 1e-9);
    CHECK(error.window_worst <= at_most + 0.01);
  }
}

TEST_CASE(
    "Width modulation delivers each period's dose between its narrowest and widest pulse and misses what is "
    "below") {
  const WidthModulation pwm = ideal_width_modulation(200.0, 0.008, kLimits);
  FlowDemand d{kStep, std::vector<double>(101, 40.0), std::vector<double>(101, 50.0), {}};
  std::vector<WidthPulse> pulses = plan_widths(d, pwm, kLimits);
  REQUIRE(pulses.size() == 200);
  for (const WidthPulse& p : pulses) CHECK(p.width_s == Approx(0.0016));
  std::fill(d.flow_mm3_s.begin(), d.flow_mm3_s.end(), 6.0);  // 0.048 mm^3 a period: below half of 0.1
  CHECK(plan_widths(d, pwm, kLimits).empty());
  WidthModulation carry = pwm;
  carry.carry = true;
  const DeliveryError error =
      count_delivery(d, drops_of(plan_widths(d, carry, kLimits)), {0.1, pwm.period_s}, 0.0);
  CHECK(std::abs(error.delivered_mm3 - error.wanted_mm3) <= 0.06);
  CHECK_THROWS_WITH(plan_widths(d, {0.001, pwm.dose, false}, kLimits), Catch::Contains("period_s"));
  CHECK_THROWS_WITH(plan_widths(d, {0.004, pwm.dose, false}, kLimits), Catch::Contains("dose table"));
}

TEST_CASE("Pulses may follow each other at every tick of the controller, and no faster") {
  const auto checked = [](double period_s) {
    check(ideal_width_modulation(200.0, period_s, kLimits), kLimits);
  };
  CHECK_NOTHROW(checked(kLimits.tick_s));
  CHECK_THROWS_WITH(checked(kLimits.tick_s * (1.0 - 1e-9)), Catch::Contains("at least one tick"));
}

TEST_CASE("6.1: from rest, frequency modulation follows the flow where width modulation cannot") {
  RandomStream random(76, Purpose::kTest);
  double fm = 0.0, pwm = 0.0;
  for (int trial = 0; trial < 30; ++trial) {
    const FlowDemand d = demand_of(random_speeds(random, 100.0, 125.0), kBoundary_mm);
    const ValveSetting setting = proportional();
    fm = std::max(
        fm, count_delivery(d, drops_of(plan_pulses(d, setting, kLimits), d, setting.curve, kLimits.tick_s),
                           {}, 0.0)
                .worst_mm3);
    pwm = std::max(
        pwm, count_delivery(
                 d, drops_of(plan_widths(d, ideal_width_modulation(200.0, 0.008, kLimits), kLimits)), {}, 0.0)
                 .worst_mm3);
  }
  CHECK(fm < 0.25);
  CHECK(pwm > 2.0 * fm);
}
