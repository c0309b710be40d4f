// Measures a decision of the level controller in Python beside the same in C++: 40 x 40 cells, 53 layers.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "tests/docs/level_controller.h"
#include "tests/python/level_prints.h"

namespace {

using namespace firn;

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

struct Measured {
  std::vector<control::Decision> decisions;
  std::vector<double> ms;
};

Measured measured(control::LayerController& controller, const control::Setup& setup, std::uint64_t seed) {
  Measured m;
  m.decisions = test::decisions(controller, setup, seed, [&](auto decide) {
    const double began = cpu_s();
    decide();
    m.ms.push_back(1e3 * (cpu_s() - began));
  });
  return m;
}

double mean(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
}

}  // namespace

int main() {
  const control::Setup setup = test::cylinder_setup();
  bool same = true;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    control::LevelController cpp(setup, {});
    const Measured a = measured(cpp, setup, seed), b = measured(*test::python_level(setup), setup, seed);
    bool equal = a.decisions.size() == b.decisions.size();
    for (std::size_t n = 0; equal && n < a.decisions.size(); ++n)
      equal = a.decisions[n].kind == b.decisions[n].kind && a.decisions[n].drops == b.decisions[n].drops;
    same = same && equal;
    std::printf(
        "seed %d: %zu decisions, droplets %s; C++ %.3f ms, Python %.3f ms, overhead %.3f ms, worst %.3f ms\n",
        int(seed), a.decisions.size(), equal ? "equal" : "DIFFERENT", mean(a.ms), mean(b.ms),
        mean(b.ms) - mean(a.ms), *std::max_element(b.ms.begin() + 1, b.ms.end()));
  }
  return same ? 0 : 1;
}
