#include "runtime/thread_pool.h"

#include <catch2/catch.hpp>
#include <stdexcept>
#include <vector>

using namespace firn;

TEST_CASE("Every body runs once, on one thread or on many, nested too") {
  for (const int threads : {1, 2, 8}) {
    const ParallelFor parallel = parallel_on(threads);
    std::vector<int> runs(1000, 0);
    parallel(10, [&](int ten) { parallel(100, [&](int one) { ++runs[std::size_t(100 * ten + one)]; }); });
    CHECK(runs == std::vector<int>(1000, 1));
  }
}

TEST_CASE("What a body throws reaches the caller") {
  for (const int threads : {1, 2, 8})
    CHECK_THROWS_AS(parallel_on(threads)(50,
                                         [](int i) {
                                           if (i == 17) throw std::out_of_range("17");
                                         }),
                    std::out_of_range);
}

TEST_CASE("No threads wanted means all cores") {
  CHECK(thread_count(3) == 3);
  CHECK(thread_count(0) >= 1);
}
