// Measures the greeting of a tab by a run that nobody has opened yet: reading its files, and the JSON; wall
// and processor time.
//   ./firn bench page_bench RUN
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <string>

#include "page/watched_run.h"
#include "print/labs/full_product.h"
#include "tests/bench/bench.h"

namespace firn::bench::page_bench {

namespace {

double clock_s(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return double(t.tv_sec) + double(t.tv_nsec) * 1e-9;
}

}  // namespace

FIRN_BENCH(page_bench) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: page_bench RUN\n");
    return 2;
  }
  const double wall_s = clock_s(CLOCK_MONOTONIC), cpu_s = clock_s(CLOCK_PROCESS_CPUTIME_ID);
  const firn::page::WatchedRun run(firn::full_product(), argv[1], 0.0);
  const std::string hello = run.hello(0.0, "run", false, {});
  const double took_s = clock_s(CLOCK_MONOTONIC) - wall_s;
  double load[3] = {};
  ::getloadavg(load, 3);
  std::printf("greeting of %zu bytes with layer %d: %.2f s, %.2f s of processors; load %.1f\n", hello.size(),
              run.newest_layer().value_or(-1), took_s, clock_s(CLOCK_PROCESS_CPUTIME_ID) - cpu_s, load[0]);
  return took_s <= 2.0 ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "page_bench: %s\n", e.what());
  return 1;
}

}  // namespace firn::bench::page_bench
