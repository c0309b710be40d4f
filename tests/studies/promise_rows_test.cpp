// Rows of the bench of promises: kept, read back and added up.
#include "tests/bench/promise_rows.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::tune;
using Catch::Contains;

TEST_CASE("Rows of promises are read back as they were kept, and a torn one is left out") {
  const test::TempFolder folder;
  const auto file = folder.path() / "rows.csv";
  CHECK(read_rows(file).empty());
  append_row(file, {"droplets", 4, "control.smf.kp = 1, control.smf.ki_star = 0", "advised", "a, b", 2.0, 0.5,
                    0.25, 0.75, 0.5, 0.625, 0, 3.5});
  append_row(file, {"tilted", 5, "k", "refused", "tilt"});
  std::ofstream(file, std::ios::app) << "droplets,6,k,adv";
  const auto rows = read_rows(file);
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].keys == "control.smf.kp = 1; control.smf.ki_star = 0");
  CHECK(rows[0].lab == 4);
  CHECK(rows[0].covered());
  CHECK(rows[0].oracle == 0.625);
  CHECK(rows[1].feature == "tilt");
  CHECK_FALSE(rows[1].answered());
}

TEST_CASE("The mean gain of promises is of shares, which a rough laboratory does not outweigh") {
  const std::vector<PromiseRow> rows{
      {"droplets", 0, "", "advised", "", 1.0, 0.5, 0.25, 0.75, 0.5, 0.5, 0, 1.0},
      {"ice", 0, "", "kept", "", 100.0, 0.0, -1.0, 1.0, 0.0, 12.0, 0, 1.0},
  };
  CHECK_THAT(promise_table(rows), Contains("81 %     4 %"));  // 0.5 of 0.62, 0.5 um of 12.5 um
}

TEST_CASE("The table of promises counts what covers, what harms and what was gained of the oracle's gain") {
  const std::vector<PromiseRow> rows{
      {"droplets", 0, "", "advised", "", 2.0, 0.5, 0.25, 0.75, 0.5, 0.5, 0, 1.0},
      {"droplets", 1, "", "advised", "", 2.0, 0.5, 0.25, 0.75, -0.1, 0.1, 0, 1.0},
      {"droplets", 2, "", "kept", "", 2.0, 0.0, -0.1, 0.1, 0.0, 0.2, 0, 1.0},
      {"droplets", 3, "", "unfinished", "", 0.0},
      {"tilted", 0, "", "refused", "", 0.0},
  };
  const std::string table = promise_table(rows);
  CHECK_THAT(table, Contains("2/3 67 %"));  // cover
  CHECK_THAT(table, Contains("1/2 50 %"));  // worse by 5 %
  CHECK_THAT(table, Contains("50 %"));      // 0.4 of 0.8
  CHECK_THAT(table, Contains("1/1 100 %"));
  CHECK(known_class("optimal"));
  CHECK_FALSE(known_class("tilted"));
}
