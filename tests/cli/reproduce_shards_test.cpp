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

int computed = 0;

void first(Reproduction& to) {
  ++computed;
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
void second(Reproduction& to) {
  ++computed;
  to.row(ReproduceRow("lu.second.bad", "gamma", "", std::numeric_limits<double>::quiet_NaN())
             .prints(0.6268, "p. 1066, Table I")
             .within(0.01));
}
void fails(Reproduction&) {
  ++computed;
  throw std::runtime_error("no file seed.json");
}

const std::vector<ReproducePart> kParts{{"lu", "first", "Fig. 1", 200, first},
                                        {"lu", "second", "Fig. 2", 60, second},
                                        {"thompson", "third", "Fig. 3", 1, fails}};

std::string told(const std::vector<PartResult>& results) {
  return reproduce_table(results) + reproduce_json(results) + reproduce_page(results);
}

}  // namespace

TEST_CASE("parts of the papers in shards give the tables and the page of one piece, each computed once") {
  const std::string whole = told(reproduce(ReproduceOptions{}, kParts));
  for (const int of : {1, 2, 3, 5}) {
    const test::TempFolder folder;
    ReproduceCall call;
    call.study.output = (folder.path() / "out").string();
    computed = 0;
    int code = -1;
    for (int k = 1; k <= of; ++k) {
      call.study.shard = std::to_string(k) + "/" + std::to_string(of);
      CHECK_FALSE(reproduce(call, kParts, code));
      CHECK(code == kOk);
    }
    CHECK(computed == 3);
    call.study.shard.clear();
    const auto merged = reproduce(call, kParts, code);
    REQUIRE(merged);
    CHECK(computed == 3);
    CHECK(told(*merged) == whole);
  }
}

TEST_CASE("a part that cannot be computed is on record with its cause, and is computed again alone") {
  const test::TempFolder folder;
  ReproduceCall call;
  call.study.output = (folder.path() / "out").string();
  int code = -1;
  const auto results = reproduce(call, kParts, code);
  REQUIRE(results);
  CHECK(results->at(2).error == "no file seed.json");
  CHECK_FALSE(all_pass(*results));
  computed = 0;
  call.study.again = true;
  CHECK(reproduce(call, kParts, code));
  CHECK(computed == 1);
}

TEST_CASE("quick parts and whole ones stand apart in one folder") {
  const test::TempFolder folder;
  ReproduceCall call;
  call.study.output = (folder.path() / "out").string();
  int code = -1;
  computed = 0;
  REQUIRE(reproduce(call, kParts, code));
  call.what.quick = true;
  REQUIRE(reproduce(call, kParts, code));
  CHECK(computed == 6);
}

TEST_CASE("shards of parts need a folder") {
  ReproduceCall call;
  call.study.shard = "1/2";
  int code = -1;
  CHECK_THROWS_WITH(reproduce(call, kParts, code), Contains("--shard") && Contains("folder"));
}

TEST_CASE("a record that is none of a part is refused with the part's name") {
  CHECK_THROWS_WITH(part_of("{\"notes\": []}", kParts[0]), Contains("lu.first"));
}
