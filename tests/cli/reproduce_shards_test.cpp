// Parts of the papers as a study: whatever computes them, in how many pieces, the tables and the page are the
// same.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <limits>

#include "cli/reproduce_command.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "studies/reproduce/part_record.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Matchers::Contains;

namespace {

int parts_computed = 0;

void first_part(Reproduction& to) {
  ++parts_computed;
  to.note("A <note> with \"quotes\" and a line\nbreak.");
  to.row(ReproduceRow("lu.first.near", "mean error", "um", 1.0 / 3.0)
             .prints(0.334, "p. 1064, Fig. 11", "0.334")
             .within(1.0)
             .fitted("grid"));
  to.row(ReproduceRow("lu.first.words", "order", "", std::string("greedy, strips"))
             .derives(std::string("greedy, strips"), "errata", "by hand")
             .holds(true, "the order"));
  to.beside({"lu.first.own", "of ours alone", "um", -std::numeric_limits<double>::infinity()});
  to.picture({"first", "A caption", "<svg viewBox=\"0 0 1 1\"></svg>"});
}
void second_part(Reproduction& to) {
  ++parts_computed;
  to.row(ReproduceRow("lu.second.bad", "gamma", "", std::numeric_limits<double>::quiet_NaN())
             .prints(0.6268, "p. 1066, Table I")
             .within(0.01));
}
void failing_part(Reproduction&) {
  ++parts_computed;
  throw std::runtime_error("no file seed.json");
}

const std::vector<ReproducePart> kShardParts{{"lu", "first", "Fig. 1", 200, first_part},
                                             {"lu", "second", "Fig. 2", 60, second_part},
                                             {"thompson", "third", "Fig. 3", 1, failing_part}};

std::string papers_told(const std::vector<PartResult>& results) {
  return reproduce_table(results) + reproduce_json(results) + reproduce_page(results);
}

}  // namespace

TEST_CASE("parts of the papers in shards give the tables and the page of one piece, each computed once") {
  const std::string whole = papers_told(reproduce(ReproduceOptions{}, kShardParts));
  for (const int of : {1, 2, 3, 5}) {
    const test::TempFolder folder;
    ReproduceCall call;
    call.study.output = (folder.path() / "out").string();
    parts_computed = 0;
    int code = -1;
    for (int k = 1; k <= of; ++k) {
      call.study.shard = std::to_string(k) + "/" + std::to_string(of);
      CHECK_FALSE(reproduce(call, kShardParts, code));
      CHECK(code == kOk);
    }
    CHECK(parts_computed == 3);
    call.study.shard.clear();
    const auto merged = reproduce(call, kShardParts, code);
    REQUIRE(merged);
    CHECK(parts_computed == 3);
    CHECK(papers_told(*merged) == whole);
  }
}

TEST_CASE("a part that cannot be computed is on record with its cause, and is computed again alone") {
  const test::TempFolder folder;
  ReproduceCall call;
  call.study.output = (folder.path() / "out").string();
  int code = -1;
  const auto results = reproduce(call, kShardParts, code);
  REQUIRE(results);
  CHECK(results->at(2).error == "no file seed.json");
  CHECK_FALSE(all_pass(*results));
  parts_computed = 0;
  call.study.again = true;
  CHECK(reproduce(call, kShardParts, code));
  CHECK(parts_computed == 1);
}

TEST_CASE("quick parts and whole ones stand apart in one folder") {
  const test::TempFolder folder;
  ReproduceCall call;
  call.study.output = (folder.path() / "out").string();
  int code = -1;
  parts_computed = 0;
  REQUIRE(reproduce(call, kShardParts, code));
  call.what.quick = true;
  REQUIRE(reproduce(call, kShardParts, code));
  CHECK(parts_computed == 6);
}

TEST_CASE("shards of parts need a folder") {
  ReproduceCall call;
  call.study.shard = "1/2";
  int code = -1;
  CHECK_THROWS_WITH(reproduce(call, kShardParts, code), Contains("--shard") && Contains("folder"));
}

TEST_CASE("a record that is none of a part is refused with the part's name") {
  CHECK_THROWS_WITH(part_of("{\"notes\": []}", kShardParts[0]), Contains("lu.first"));
}
