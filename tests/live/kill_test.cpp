// kill -9 of each process of a live print at a random moment.
#include <catch2/catch.hpp>

#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

namespace {

void kill_of_inkjet(const std::string& victim, std::uint64_t seed, bool two_inks = false) {
  if (skipped()) return;
  kill_and_resume(two_inks ? tiny_part_of_two_inks(seed) : tiny_part(seed), victim, "stage", seed, 0,
                  1'800'000);
}

}  // namespace

TEST_CASE("scheduler killed: safe, named, resumed, replayed") { kill_of_inkjet("scheduler", 11); }
TEST_CASE("surface mapper killed: safe, named, resumed, replayed") { kill_of_inkjet("surface_mapper", 12); }
TEST_CASE("controller killed: safe, named, resumed, replayed") { kill_of_inkjet("controller", 13); }
TEST_CASE("stage driver killed: safe, named, resumed, replayed") { kill_of_inkjet("stage", 14); }
TEST_CASE("jet driver killed: safe, named, resumed, replayed") { kill_of_inkjet("jet", 15); }
TEST_CASE("laser profiler driver killed: safe, named, resumed, replayed") {
  kill_of_inkjet("laser_profiler", 16);
}
TEST_CASE("lamp driver killed: safe, named, resumed, replayed") { kill_of_inkjet("lamp", 17); }
TEST_CASE("recorder killed: safe, named, resumed, replayed") { kill_of_inkjet("recorder", 18); }
TEST_CASE("safety killed: safe, named, resumed, replayed") { kill_of_inkjet("safety", 19); }
TEST_CASE("driver of the second jet killed: safe, named, resumed, replayed") {
  kill_of_inkjet("jet_b", 21, true);
}
TEST_CASE("launcher killed: every process stops by itself, resumed, replayed") {
  kill_of_inkjet("launcher", 20);
}
