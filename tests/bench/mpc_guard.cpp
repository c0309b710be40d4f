// Does MPC ever print a layer that is worse than none, or for ever? Random grids, masks, borders, surfaces,
// inks, alphas, horizons and methods: single decisions, each judged anew by the height-change model, and
// whole prints with droplets that vary and a sensor with noise, which must end (the paper's greedy search is
// only shown).
//   build/bench/mpc_guard [decisions 10000] [prints 1000]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "tests/bench/bench.h"
#include "tests/core/control/guard_cases.h"

namespace firn::bench::mpc_guard {

using namespace firn;
using namespace firn::control;

FIRN_BENCH(mpc_guard) {
  const int decisions = argc > 1 ? std::atoi(argv[1]) : 10'000,
            prints = argc > 2 ? std::atoi(argv[2]) : 1'000;
  int wrong = 0, printed = 0;
  for (int n = 1; n <= decisions; ++n) {
    const GuardCase c = random_case(std::uint64_t(n));
    const Decision d = make_controller(c.setup, c.options)->decide({c.height, n % 60, 0, 0.0});
    printed += d.kind == Decision::Kind::kPrint;
    if (right(c, d)) continue;
    ++wrong;
    std::printf("decision %d (%s, alpha %.3f, N = %d): %.6f um, none %.6f um\n", n, c.method.c_str(), c.alpha,
                c.options.mpc.horizon, 1e3 * d.objective_mm, 1e3 * d.objective_none_mm);
  }
  std::printf("%d decisions, %d print; %d worse than none or not what they say\n", decisions, printed, wrong);
  std::map<std::string, std::pair<int, int>> endless;
  int longest = 0;
  for (int n = 1; n <= prints; ++n) {
    GuardCase c = random_case(std::uint64_t(n));
    RandomStream random(std::uint64_t(n), Purpose::kInstance);
    if (n % 2) c.alpha = random.uniform(0.02, 0.35), c.options.mpc.alpha = {{1, c.alpha}};
    if (n % 5 == 0) c.options.noise_gate = 0.0;
    const double variation = random.uniform(0.0, 0.4), noise_mm = n % 3 ? 0.0 : random.uniform(0.0, 0.002);
    const int full = int(0.06 / c.setup.model.h1_mm) + 1,
              layers = print_until_end(c, variation, noise_mm, 20 * full);
    auto& e = endless[c.method];
    ++e.second;
    longest = std::max(longest, layers);
    if (layers >= 0) continue;
    ++e.first;
    std::printf("print %d (%s, alpha %.3f, N = %d, variation %.2f, sensor %.2f um) does not end\n", n,
                c.method.c_str(), c.alpha, c.options.mpc.horizon, variation, 1e3 * noise_mm);
  }
  for (const auto& [method, e] : endless)
    std::printf("%-9s %d of %d prints do not end\n", method.c_str(), e.first, e.second);
  std::printf("the longest print that ends has %d layers\n", longest);
  return wrong != 0;
}

}  // namespace firn::bench::mpc_guard
