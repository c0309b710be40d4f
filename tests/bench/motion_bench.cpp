// Arm kinematics in batches, and the thesis's MTTS, as points per second of one core. Argument: points in a
// batch.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/motion/constant_speed.h"
#include "core/motion/thesis/test_path.h"
#include "core/motion/thesis/thesis.h"
#include "core/motion/vplus_default.h"

namespace {

using namespace firn;
using namespace firn::motion;

Jets circle(std::size_t n) {
  Jets task(kTaskAxes, n);
  for (std::size_t i = 0; i < n; ++i)
    for (int order = 0; order < 4; ++order) {
      const double phase = 0.01 * double(i) + order * 1.5707963267948966, scale = std::pow(0.02, order);
      task.of(kX, order)[i] = (order ? 0 : 400) + 50 * scale * std::cos(phase);
      task.of(kY, order)[i] = 50 * scale * std::sin(phase);
    }
  return task;
}

void inverse_with_derivatives(benchmark::State& state) {
  const std::size_t n = std::size_t(state.range(0));
  const Jets task = circle(n);
  Jets joints(2, n);
  const auto arm = make_scara(cobra600());
  for (auto _ : state) benchmark::DoNotOptimize(arm->inverse(task, {1, 0}, joints));
  state.counters["points/s"] = benchmark::Counter(double(n), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(inverse_with_derivatives)->Arg(64)->Arg(1024)->Arg(16384);

void forward_with_derivatives(benchmark::State& state) {
  const std::size_t n = std::size_t(state.range(0));
  const auto arm = make_scara(cobra600());
  Jets joints(4, n), back(kTaskAxes, n);
  if (arm->inverse(circle(n), {1, 0}, joints)) return state.SkipWithError("out of reach");
  for (auto _ : state) arm->forward(joints, back);
  state.counters["points/s"] = benchmark::Counter(double(n), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(forward_with_derivatives)->Arg(1024);

template <typename Plan>
void plan_fig_4_2(benchmark::State& state, Plan plan) {
  const auto points = thesis::fig_4_2();
  PathInput in{.points = points};
  in.origin = thesis::kWellPlaced;
  const auto arm = make_scara(cobra600());
  for (auto _ : state) benchmark::DoNotOptimize(plan(in, *arm));
  state.counters["points/s"] =
      benchmark::Counter(double(points.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_CAPTURE(plan_fig_4_2, thesis, [](const PathInput& in, const Arm& arm) {
  return plan_thesis(in, arm, cobra600_limits());
});
BENCHMARK_CAPTURE(plan_fig_4_2, constant, [](const PathInput& in, const Arm& arm) {
  return plan_constant(in, arm, cobra600_limits());
});
BENCHMARK_CAPTURE(plan_fig_4_2, vplus_default, [](const PathInput& in, const Arm& arm) {
  return plan_default(in, arm, cobra600_limits());
});

}  // namespace
