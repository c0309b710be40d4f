// Figs. 13-15 with a few seeds; `firn reproduce lu` prints all twenty.
#include <catch2/catch.hpp>

#include "studies/reproduce/reproduce.h"

using namespace firn;

namespace {

std::vector<PartResult> few_seeds(int threads) {
  ReproduceOptions options;
  options.only = {"lu.figs-13-15"};
  options.quick = true;
  options.threads = threads;
  return reproduce(options, reproduce_parts());
}

}  // namespace

TEST_CASE(
    "Figs. 13-15: closed loop has at most half of open loop's wrong voxels, inside, outside and at the "
    "boundary") {
  const std::vector<PartResult> one = few_seeds(1);
  REQUIRE(one.size() == 1);
  for (const ReproduceRow& row : one[0].rows) {
    INFO(row.id << ": " << row.what);
    CHECK(row.verdict() == Verdict::kReproduced);
  }
  CHECK(one[0].rows.size() == 4);
  REQUIRE(one[0].pictures.size() == 4);
  for (const ReproducePicture& p : one[0].pictures) CHECK(p.svg.find("<image") != std::string::npos);
  CHECK(reproduce_json(few_seeds(2)) == reproduce_json(one));
}
