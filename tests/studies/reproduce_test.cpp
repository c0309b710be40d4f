#include "studies/reproduce/reproduce.h"
#include "report/draw/style.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "files/usage_error.h"

using namespace firn;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

void gives_three_rows(Reproduction& to) {
  to.note("A <set-up> of the test.");
  to.progress(0.5, "half way");
  to.row(row_near("lu.first.near", "mean error", "um", 44.1, 44.5, 1.0, RowKind::kFit));
  to.row(row_at_most("lu.first.bound", "time", "s", std::string(), 1.25, 2.0));
  to.row(row_informative("lu.first.measured", "of the real printer", "um", 22.3, 21.3));
  to.picture({"first", "A caption with < and &", "<svg viewBox=\"0 0 1 1\"><path d=\"M0 0\"/></svg>"});
}
void gives_a_bad_row(Reproduction& to) { to.row(row_holds("lu.second.bad", "must", "yes", "no", false)); }
void throws(Reproduction&) { throw std::runtime_error("no file seed.json"); }
void gives_a_foreign_row(Reproduction& to) { to.row(row_holds("lu.first.stolen", "x", "", "", true)); }

const std::vector<ReproducePart> kParts{{"lu", "first", "Fig. 1", 1, gives_three_rows},
                                        {"lu", "second", "Fig. 2", 1, gives_a_bad_row},
                                        {"thompson", "third", "Fig. 3", 1, throws},
                                        {"thompson", "fourth", "Fig. 4", 1, gives_a_foreign_row}};

std::vector<PartResult> results(std::vector<std::string> only, std::string paper = "") {
  ReproduceOptions options;
  options.only = std::move(only);
  options.paper = std::move(paper);
  return reproduce(options, kParts);
}

}  // namespace

TEST_CASE("A reproduction passes when no row with a tolerance fails, and informative rows have no verdict",
          "[reproduce]") {
  CHECK(all_pass(results({"first"})));
  CHECK_FALSE(all_pass(results({}, "lu")));
  const Json rows = Json::parse(reproduce_json(results({"first"})));
  REQUIRE(rows.size() == 3);
  CHECK(rows[0]["paper"] == 44.1);
  CHECK(rows[0]["ours"] == 44.5);
  CHECK(rows[0]["tolerance"] == 1.0);
  CHECK(rows[0]["pass"] == true);
  CHECK(rows[0]["kind"] == "fit");
  CHECK(rows[1]["tolerance"] == "<= 2 s");
  CHECK(rows[1]["paper"].is_null());
  CHECK(rows[2]["pass"].is_null());
  CHECK(rows[2]["tolerance"].is_null());
}

TEST_CASE("A number that is none never passes", "[reproduce]") {
  const double none = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(*row_near("a", "", "", 1.0, none, 1.0).pass);
  CHECK_FALSE(*row_at_most("a", "", "", std::string(), none, 1.0).pass);
}

TEST_CASE("A part that throws becomes a failing row that says why, and the other parts still run",
          "[reproduce]") {
  const auto all = results({});
  REQUIRE(all.size() == 4);
  CHECK_THAT(std::get<std::string>(all[2].rows.at(0).ours), Contains("no file seed.json"));
  CHECK_FALSE(*all[2].rows[0].pass);
  CHECK_THAT(std::get<std::string>(all[3].rows.at(0).ours), Contains("lu.first.stolen"));
}

TEST_CASE("Papers' parts and rows are taken by --only, with or without the paper's name", "[reproduce]") {
  CHECK(results({"lu.first"}).at(0).rows.size() == 3);
  const auto one = results({"first.near"});
  REQUIRE(one.size() == 1);
  CHECK(one[0].rows.size() == 1);
  CHECK(results({"lu.first.near", "second"}).size() == 2);
  CHECK_THROWS_WITH(results({"fir"}), Contains("--only fir is no part or row; parts are lu.first"));
  CHECK_THROWS_WITH(results({"first.nothing"}), Contains("part lu.first has no row first.nothing"));
  CHECK_THROWS_AS(results({}, "cohen"), UsageError);
}

TEST_CASE("The page holds every row, note and picture, escaped, and loads nothing", "[reproduce]") {
  const auto first = results({"first"});
  const std::string page = reproduce_page(first);
  for (const char* piece :
       {"lu.first.near", "+- 1 um", "A &lt;set-up&gt;", "A caption with &lt; and &amp;", "<svg viewBox"})
    CHECK_THAT(page, Contains(piece));
  for (const char* piece : {"<script", "<link", "src=\"http"}) CHECK(page.find(piece) == page.npos);
  CHECK_THAT(replay::standalone_svg(first[0].pictures[0].svg),
             Catch::StartsWith("<svg viewBox=\"0 0 1 1\"><style>"));
}

TEST_CASE("The table of parts names each part once, by a paper of the seeds", "[reproduce]") {
  std::set<std::string> names;
  for (const ReproducePart& part : reproduce_parts()) {
    const std::string paper = part.paper;
    CHECK((paper == "lu" || paper == "barnett" || paper == "thompson"));
    CHECK(names.insert(paper + "." + part.name).second);
    CHECK(part.seconds > 0);
    CHECK(part.run != nullptr);
  }
}
