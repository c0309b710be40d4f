// Large grids, and the price of a step of the model and of trying a droplet.
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "core/control/mpc/anneal.h"
#include "core/control/mpc/horizon_state.h"
#include "core/control/mpc/layer/layer_problem.h"
#include "core/control/mpc/layer/strip_dp.h"
#include "core/grid/random.h"
#include "runtime/thread_pool.h"
#include "tests/bench/mpc_tables.h"

namespace firn::bench {
namespace {

double peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * double(usage.ru_maxrss);
}

template <class Body>
double median_s(int times, const Body& body) {
  std::vector<double> seconds;
  for (int n = 0; n < times; ++n) {
    const double start = thread_cpu_s();
    body();
    seconds.push_back(thread_cpu_s() - start);
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[seconds.size() / 2];
}

void uniform_layer(int n, const ParallelFor& parallel) {
  const GridSpec g{n, n};
  const double before = peak_bytes();
  control::Setup setup{g, HeightMap(g, 0.05), Mask(g, 1), {}, deposition::Border::kLose, 1};
  HeightMap h(g);
  RandomStream random(1, Purpose::kInstance);
  for (double& x : h.cells) x = 0.05 - float(random.uniform(0.0, 0.0076));
  const double wall = wall_s(), cpu = process_cpu_s();
  control::mpc::LayerProblem problem(setup, h, {});
  problem.set_drops(DropletPattern(g, 1));
  const auto r = control::mpc::sweep_strips(problem, {2, 100}, parallel);
  const DropletPattern u = problem.drops(g);
  const double wall_end = wall_s(), cpu_end = process_cpu_s();
  const double um = 1e3 * problem.total_mm() / double(problem.counted());
  std::printf(
      "%d x %d: %.5f um, %lld droplets, %d sweeps, %.2f s, %.2f s of processor time, %.1f bytes per cell at "
      "most\n",
      n, n, um, static_cast<long long>(u.total()), r.sweeps, wall_end - wall, cpu_end - cpu,
      (peak_bytes() - before) / double(g.size()));
}

// Seconds for one change of one droplet in a plan of several layers, half of them full.
double change_s(int layers) {
  const GridSpec g{100, 100};
  RandomStream random(1, Purpose::kTest);
  const control::Setup setup{g, HeightMap(g, 0.05), Mask(g, 1), {}, deposition::Border::kLose, 1};
  HeightMap h(g);
  for (double& x : h.cells) x = 0.05 - random.uniform(0.0, 0.0076 * layers);
  const DropletPattern empty(g);
  std::vector<DropletPattern> plan(std::size_t(layers), empty);
  for (DropletPattern& u : plan)
    for (auto& n : u.cells) n = std::uint8_t(random.below(2));
  std::vector<std::uint32_t> cells(g.size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) cells[c] = c;
  control::mpc::HorizonState field(setup, h, {}, layers);
  field.set_plan(plan);
  control::mpc::AnnealOptions o;
  o.layers = layers;
  o.sweeps = 10;
  o.max_evaluations = 1'000'000'000;
  std::int64_t changes = 0;
  const double seconds = median_s(3, [&] { changes = anneal(field, {}, cells, o, random).evaluations; });
  return seconds / double(changes);
}

}  // namespace

int print_large(int threads) {
  const ParallelFor parallel = parallel_on(threads);
  for (const int n : {1000, 4000}) uniform_layer(n, parallel);
  return 0;
}

int print_forward() {
  const GridSpec g{1000, 1000};
  RandomStream random(1, Purpose::kTest);
  HeightMap h(g);
  DropletPattern u(g);
  for (std::size_t c = 0; c < g.size(); ++c) {
    h.cells[c] = random.uniform(0.0, 0.01);
    u.cells[c] = std::uint8_t(random.below(2));
  }
  control::Setup setup{g, HeightMap(g, 0.005), Mask(g, 1), {}, deposition::Border::kLose, 1};
  control::mpc::LayerProblem problem(setup, h, {});
  problem.set_drops(u);
  const double errors = median_s(9, [&] { problem.refresh(); });
  deposition::HeightChange<1> model(g, deposition::stencil_of({}), deposition::Border::kLose);
  const double step = median_s(9, [&] { model.step(h.data(), u.data(), 0); });
  std::printf(
      "forward model %.2f ns per cell as MPC's layer problem (single precision), %.2f ns as HeightChange "
      "(double; 1000 x 1000 cells)\n",
      1e9 * errors / double(g.size()), 1e9 * step / double(g.size()));
  std::printf(
      "a droplet more or less in a plan of two layers %.0f ns, of three %.0f ns (100 x 100 cells, "
      "annealing)\n",
      1e9 * change_s(2), 1e9 * change_s(3));
  return 0;
}

}  // namespace firn::bench
