// Time of turning one scan into a map, and of robust smoothing with automatic parameter.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "estimators/surface/robust_smoothing.h"
#include "estimators/surface/surface_map.h"

namespace {

using namespace firn;

// A part of roughness 2 um on the disc (or on all of the grid), 1 um noise, missing beyond the disc.
HeightMap measured(const GridSpec& g, bool disc) {
  RandomStream random(1, Purpose::kTest);
  HeightMap h(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double x = i - 0.5 * (g.nx - 1), y = j - 0.5 * (g.ny - 1);
      const bool inside = !disc || x * x + y * y <= 0.2116 * g.nx * g.nx;
      h.at(i, j) =
          inside ? 0.2 + 1e-5 * x + 0.002 * random.uniform() + 0.001 * random.normal() : kNotMeasured;
    }
  return h;
}

// Arguments: side, 1 = only a disc is known.
void robust_smoothing(benchmark::State& state) {
  const GridSpec g{int(state.range(0)), int(state.range(0))};
  const HeightMap h = measured(g, state.range(1) == 1);
  surface::RobustSmoother smoother(g);
  double iterations = 0.0;
  for (auto _ : state) iterations = smoother.smooth(h, nullptr, {}).iterations;
  state.counters["iterations"] = iterations;
}
BENCHMARK(robust_smoothing)
    ->Args({40, 0})
    ->Args({40, 1})
    ->Args({41, 0})
    ->Args({100, 0})
    ->ArgNames({"side", "disc"})
    ->Unit(benchmark::kMillisecond);

void map_of_scan(benchmark::State& state) {
  const GridSpec g{40, 40, 0.263256, 0.263256};
  RandomStream random(1, Purpose::kTest);
  std::vector<std::vector<float>> rows(40, std::vector<float>(800));
  for (auto& r : rows)
    for (float& z : r) z = float(0.2 + 0.001 * random.normal());
  surface::SurfaceMap map(g);
  for (auto _ : state) {
    map.clear();
    for (int j = 0; j < 40; ++j) map.add_row(g.y_mm(j), -0.13, 0.01316, rows[std::size_t(j)]);
    benchmark::DoNotOptimize(map.estimate({}));
  }
}
BENCHMARK(map_of_scan)->Unit(benchmark::kMillisecond);

}  // namespace
