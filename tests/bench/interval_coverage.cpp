// Measures the coverage of a known mean by the 95 % bootstrap interval of core/statistics.
//   interval_coverage [STUDIES]
#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/bootstrap.h"
#include "tests/bench/bench.h"

namespace firn::bench::interval_coverage {

namespace {

using namespace firn;

struct Distribution {
  const char* name;
  double mean;
  double (*draw)(RandomStream&);
};

double coverage(const Distribution& d, std::size_t size, int studies) {
  RandomStream random(size, Purpose::kTest);
  std::vector<double> x(size);
  statistics::BootstrapOptions options;
  options.resamples = 1999;
  int covered = 0;
  for (int n = 0; n < studies; ++n) {
    for (double& v : x) v = d.draw(random);
    options.seed = std::uint64_t(n);
    const statistics::Interval i = statistics::bootstrap_interval(x, options);
    covered += i.low <= d.mean && d.mean <= i.high;
  }
  return double(covered) / studies;
}

}  // namespace

FIRN_BENCH(interval_coverage) {
  const int studies = argc > 1 ? std::atoi(argv[1]) : 2000;
  const Distribution all[] = {
      {"normal", 0.0, [](RandomStream& r) { return r.normal(); }},
      {"uniform", 0.5, [](RandomStream& r) { return r.uniform(); }},
      {"exponential", 1.0, [](RandomStream& r) { return -std::log(1.0 - r.uniform()); }},
      {"log-normal", std::exp(0.5), [](RandomStream& r) { return std::exp(r.normal()); }}};
  fmt::print("| {} samples each | n = 10 | 20 | 30 | 100 |\n|---|---|---|---|---|\n", studies);
  for (const Distribution& d : all) {
    fmt::print("| {} |", d.name);
    for (const std::size_t size : {10, 20, 30, 100})
      fmt::print(" {:.1f} % |", 100.0 * coverage(d, size, studies));
    fmt::print("\n");
  }
  return 0;
}

}  // namespace firn::bench::interval_coverage
