// Time of updating the valve's pulses after a measurement: action surface -> corrected flow -> pulse lists.
#include <benchmark/benchmark.h>

#include <vector>

#include "core/deposition/pulses.h"
#include "tests/core/deposition/demands.h"

namespace {

using namespace firn;
using namespace firn::deposition;

// Arguments: paths, 1 = a bent frequency-flow table of 20 rows. Each path is 300 mm of boundary at up to 125
// mm/s.
void update_of_an_interval(benchmark::State& state) {
  RandomStream random(1, Purpose::kTest);
  std::vector<FlowDemand> nominal;
  std::vector<std::vector<Point2>> places;
  for (std::int64_t n = 0; n < state.range(0); ++n) {
    nominal.push_back(test::demand_of(test::random_speeds(random, 300.0, 125.0), test::kBoundary_mm));
    std::vector<Point2> line;
    const DemandIntegral path(nominal.back());
    for (std::size_t i = 0; i < nominal.back().flow_mm3_s.size(); ++i)
      line.push_back({0.3 * path.length_mm(nominal.back().step_s * double(i)), 0.2 * double(n)});
    places.push_back(line);
  }
  HeightMap action(GridSpec{101, 101, 1.0, 1.0, 0.0, 0.0});
  for (double& u : action.cells) u = random.uniform(-0.3, 0.3);
  const ValveSetting setting{0.00125, state.range(1) ? test::bent_curve(random)
                                                     : FlowCurve::proportional(test::kFeedForward, 500.0)};
  const ValveLimits limits;
  std::size_t pulses = 0;
  for (auto _ : state) {
    pulses = 0;
    for (std::size_t n = 0; n < nominal.size(); ++n) {
      std::vector<double> u;
      for (const Point2& p : places[n]) u.push_back(action_at(action, p));
      FlowDemand demand = nominal[n];
      corrected_flow(nominal[n].flow_mm3_s, u, demand.flow_mm3_s);
      clip_flow(demand, max_flow_mm3_s(setting, limits));
      for (const PulseTrain& train : plan_pulses(demand, setting, limits).trains)
        pulses += train.ticks.size();
    }
  }
  state.counters["pulses"] = double(pulses);
}
BENCHMARK(update_of_an_interval)
    ->Args({300, 0})
    ->Args({300, 1})
    ->Args({1000, 1})
    ->ArgNames({"paths", "bent"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
