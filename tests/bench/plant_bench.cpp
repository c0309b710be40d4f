// Measures the cost of the simulated nature: droplets, layers with curing, profiles.
#include <benchmark/benchmark.h>

#include <vector>

#include "plant/inkjet/model.h"
#include "plant/inkjet/sensor.h"

namespace {

using namespace firn;
using namespace firn::plant;

void droplets(benchmark::State& state, const char* name) {
  WorldConfig c;
  c.model = name;
  const auto model = make_model(c);
  std::int64_t fired = 0, t_us = 0;
  for (auto _ : state) {  // one layer of a disc of 37 cells
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i)
        if ((2 * i - 39) * (2 * i - 39) + (2 * j - 39) * (2 * j - 39) <= 37 * 37) {
          model->fire({t_us += 2000, c.grid.x_mm(i), c.grid.y_mm(j), 0.0, 0.0});
          ++fired;
        }
    model->end_pass();
    model->expose(t_us += 1'000'000);
  }
  state.SetItemsProcessed(fired);
}
BENCHMARK_CAPTURE(droplets, droplets, "droplets")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(droplets, lu2015, "lu2015")->Unit(benchmark::kMicrosecond);

void profile(benchmark::State& state) {
  const WorldConfig c;
  const auto model = make_model(c);
  std::vector<double> z(800);
  std::uint32_t n = 0;
  for (auto _ : state) {
    measure_profile(model->surface(), c.sensor, {1, 0, ++n}, c.grid.y_mm(int(n) % 40), -3.0, 0.02, z);
    benchmark::DoNotOptimize(z.data());
  }
}
BENCHMARK(profile)->Unit(benchmark::kMicrosecond);

}  // namespace
