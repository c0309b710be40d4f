// Exact recovery [Lu 2015, IV-C]: a random layer is printed by the model; the solver is to find its droplets
// again.
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "core/control/mpc/layer/strip_dp.h"
#include "core/grid/random.h"
#include "tests/bench/mpc_tables.h"

namespace firn::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

struct Recovered {
  int of = 0, found = 0;
  std::vector<double> seconds;
};

Recovered recover(int n, double spread, int seeds) {
  Recovered r;
  const GridSpec g{n, n};
  for (std::uint64_t seed = 1; seed <= std::uint64_t(seeds); ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    control::Setup setup{g, HeightMap(g), Mask(g, 1), {}, deposition::Border::kLose, seed};
    setup.model.h2_mm = spread * setup.model.h1_mm;
    setup.model.h3_mm = setup.model.h2_mm / 3.0;
    HeightMap h(g);
    DropletPattern printed(g);
    for (std::size_t c = 0; c < g.size(); ++c) {
      h.cells[c] = random.uniform(0.0, 0.05);
      printed.cells[c] = std::uint8_t(random.below(2));
    }
    setup.target = h;
    deposition::HeightChange<1>(g, deposition::stencil_of(setup.model), setup.border)
        .deposit(setup.target, printed);
    const double start = thread_cpu_s();
    control::mpc::LayerProblem problem(setup, h, {});
    for (int rows = 2; rows <= 4; ++rows) {
      control::mpc::sweep_strips(problem, {rows, 100}, serially);
      if (problem.total_mm() < 1e-6 * double(g.size())) break;  // nothing is left but rounding
    }
    r.seconds.push_back(thread_cpu_s() - start);
    ++r.of;
    r.found += problem.drops(g) == printed;
  }
  std::sort(r.seconds.begin(), r.seconds.end());
  return r;
}

}  // namespace

double thread_cpu_s() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu_s() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }
double wall_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int print_recovery() {
  struct Size {
    int n, seeds;
  };
  for (const Size size : {Size{20, 50}, Size{200, 10}}) {
    std::printf("%d x %d, %d seeds\nh2 / h1  found   median ms  worst ms\n", size.n, size.n, size.seeds);
    for (const double spread : {0.136, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0}) {
      const Recovered r = recover(size.n, spread, size.seeds);
      std::printf("%-7g  %2d/%d  %9.2f  %8.2f\n", spread, r.found, r.of,
                  1e3 * r.seconds[r.seconds.size() / 2], 1e3 * r.seconds.back());
    }
  }
  return 0;
}

}  // namespace firn::bench
