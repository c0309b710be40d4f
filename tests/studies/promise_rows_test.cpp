// Rows of the bench of promises: kept, read back and added up.
#include "tests/bench/promise_rows.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace firn;
using namespace firn::tune;
using Catch::Contains;

TEST_CASE("Rows of promises are read back as they were kept, also where a number is none") {
  const PromiseRow kept{"droplets",
                        4,
                        "control.smf.kp = 1, control.smf.ki_star = 0",
                        "advised",
                        "a, b",
                        1.0 / 3.0,
                        0.5,
                        0.25,
                        0.75,
                        0.5,
                        std::nan(""),
                        0,
                        3.5};
  const PromiseRow row = row_of(row_text(kept));
  CHECK(row.keys == kept.keys);
  CHECK(row.lab == 4);
  CHECK(row.before == kept.before);
  CHECK(row.covered());
  CHECK(std::isnan(row.oracle));
  CHECK(row_of(row_text({"tilted", 5, "k", "refused", "tilt"})).feature == "tilt");
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
