// Measures the coverage of a known mean by the 95 % bootstrap interval of core/statistics.
//   interval_coverage [STUDIES] [-o FOLDER and a study's options]
#include <fmt/core.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/bootstrap.h"
#include "tests/bench/bench.h"
#include "tests/bench/case_bench.h"

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
  int studies = 2000;
  CaseBench bench("interval_coverage", "coverage of a known mean by the 95 % bootstrap interval");
  bench.options()
      .option("STUDIES", studies, "samples of each size and distribution")
      .show_default()
      .within(1, 1000000);
  if (const auto code = bench.parse(argc, argv)) return *code;
  const Distribution all[] = {
      {"normal", 0.0, [](RandomStream& r) { return r.normal(); }},
      {"uniform", 0.5, [](RandomStream& r) { return r.uniform(); }},
      {"exponential", 1.0, [](RandomStream& r) { return -std::log(1.0 - r.uniform()); }},
      {"log-normal", std::exp(0.5), [](RandomStream& r) { return std::exp(r.normal()); }}};
  // A sample's size stands where a study has its seed.
  Cases cases{"interval_coverage", std::to_string(studies), {}, {10, 20, 30, 100}, {}};
  for (const Distribution& d : all) cases.kinds.push_back(d.name);
  cases.make = [&](std::size_t kind, std::uint64_t size, int) {
    return text_of({coverage(all[kind], size, studies)});
  };
  int code = 0;
  const auto results = bench.results(cases, {std::to_string(studies)}, code);
  if (!results) return code;
  fmt::print("| {} samples each | n = 10 | 20 | 30 | 100 |\n|---|---|---|---|---|\n", studies);
  for (std::size_t k = 0; k < cases.kinds.size(); ++k) {
    fmt::print("| {} |", cases.kinds[k]);
    for (std::size_t s = 0; s < cases.seeds.size(); ++s)
      fmt::print(" {:.1f} % |", 100.0 * numbers_of((*results)[k * cases.seeds.size() + s].text).front());
    fmt::print("\n");
  }
  return 0;
}

}  // namespace firn::bench::interval_coverage
