// Measures the speed of the forward model, of a layer's decision and of exact recovery (Lu 2015, IV-C).
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/control/controller.h"
#include "core/control/mpc/greedy.h"
#include "core/control/mpc/objective.h"
#include "core/deposition/height_change.h"
#include "core/grid/random.h"

namespace {

using namespace firn;

// Returns the CPU seconds of this thread: the time of a decision where nothing else runs.
double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

void forward_model(benchmark::State& state) {
  const GridSpec g{1000, 1000};
  RandomStream random(1, Purpose::kTest);
  HeightMap h(g);
  DropletPattern u(g);
  for (std::size_t c = 0; c < g.size(); ++c) {
    h.cells[c] = random.uniform(0.0, 0.01);
    u.cells[c] = std::uint8_t(random.below(2));
  }
  deposition::HeightChange<1> model(g, deposition::stencil_of({}), deposition::Border::kLose);
  for (auto _ : state) model.step(h.data(), u.data(), 0);
  state.counters["ns_per_cell"] =
      benchmark::Counter(double(state.iterations()) * double(g.size()) * 1e-9,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(forward_model)->Unit(benchmark::kMillisecond);

void exact_recovery(benchmark::State& state) {
  const GridSpec g{20, 20};
  double worst_s = 0.0, found = 0.0, tried = 0.0;
  for (auto _ : state)
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      RandomStream random(seed, Purpose::kInstance);
      HeightMap h(g), made(g);
      DropletPattern u(g);
      for (std::size_t c = 0; c < g.size(); ++c) {
        h.cells[c] = random.uniform(0.0, 0.05);
        u.cells[c] = std::uint8_t(random.below(2));
      }
      made = h;
      deposition::HeightChange<1>(g, deposition::stencil_of({}), deposition::Border::kLose).deposit(made, u);
      control::Setup setup{g, made, Mask(g, 1), {}, deposition::Border::kLose, seed};
      const double start = cpu_s();
      control::mpc::HorizonObjective objective(setup, 1, 1);
      RandomStream search(seed, Purpose::kGreedySearch);
      objective.set_surface(h, 1.0);
      objective.set_plan(std::vector<DropletPattern>(1, DropletPattern(g, 1)));
      control::mpc::greedy_search(objective, {16, 1'000'000}, search);
      worst_s = std::max(worst_s, cpu_s() - start);
      found += objective.layer(0) == u;
      tried += 1.0;
    }
  state.counters["recovered_of_50"] = 50.0 * found / tried;
  state.counters["worst_cpu_ms"] = 1e3 * worst_s;
}
BENCHMARK(exact_recovery)->Unit(benchmark::kMillisecond);

enum Kind { kFlatShort, kRamp, kRough, kUniformOneLayer, kNearTarget };

HeightMap state_of(Kind kind, const GridSpec& g, const HeightMap& target, std::uint64_t seed) {
  RandomStream random(seed, Purpose::kInstance);
  HeightMap h(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      double below = 0.0;
      if (kind == kFlatShort) below = 0.0038;
      if (kind == kRamp) below = 0.0152 * i / (g.nx - 1);
      if (kind == kRough) below = random.uniform(-0.01, 0.03);
      if (kind == kUniformOneLayer) below = random.uniform(0.0, 0.0076);
      if (kind == kNearTarget) below = random.uniform(-0.004, 0.004);
      h.at(i, j) = target.at(i, j) - below;
    }
  return h;
}

// Two inks, every other 5 x 5 cells of each; the support's droplets nine tenths of the object's.
void with_two_inks(control::Setup& setup) {
  std::vector<std::vector<Span>> spans(setup.grid.size());
  for (std::size_t c = 0; c < spans.size(); ++c)
    if ((c % 100 / 5 + c / 500) % 2) spans[c] = {{0.0, 0.4}};
  setup.geometry = std::make_shared<const Geometry>(setup.grid, 0.4, spans);
  setup.model_b = {0.9 * setup.model.h1_mm, 0.9 * setup.model.h2_mm, 0.9 * setup.model.h3_mm};
}

// Arguments: kind of state, alpha in percent, horizon, inks.
void decision_100x100(benchmark::State& state) {
  const GridSpec g{100, 100};
  control::Setup setup{g, HeightMap(g, 0.4), Mask(g, 1), {}, deposition::Border::kLose, 1};
  control::ControlOptions options;
  options.mpc.alpha = {{1, double(state.range(1)) / 100.0}};
  options.mpc.horizon = int(state.range(2));
  if (state.range(3) == 2) with_two_inks(setup);
  std::vector<double> seconds;
  double evaluations = 0.0;
  for (auto _ : state)
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      setup.seed = seed;
      const auto controller = control::make_controller(setup, options);
      const HeightMap h = state_of(Kind(state.range(0)), g, setup.target, seed);
      const double start = cpu_s();
      const control::Decision d = controller->decide({h, 3, 0, 0.0});
      seconds.push_back(cpu_s() - start);
      evaluations = std::max(evaluations, double(d.iterations));
    }
  std::sort(seconds.begin(), seconds.end());
  state.counters["median_cpu_ms"] = 1e3 * seconds[seconds.size() / 2];
  state.counters["worst_cpu_ms"] = 1e3 * seconds.back();
  state.counters["evaluations"] = evaluations;
}
BENCHMARK(decision_100x100)
    ->ArgsProduct({{kFlatShort, kRamp, kRough, kUniformOneLayer, kNearTarget}, {100, 80, 50}, {1}, {1, 2}})
    ->Args({kUniformOneLayer, 100, 2, 1})
    ->Args({kUniformOneLayer, 50, 2, 1})
    ->Args({kUniformOneLayer, 50, 2, 2})
    ->ArgNames({"kind", "alpha_percent", "horizon", "inks"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
