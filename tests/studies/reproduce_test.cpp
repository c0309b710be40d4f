#include "studies/reproduce/reproduce.h"
#include "report/draw/style.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "files/json.h"
#include "files/usage_error.h"

using namespace firn;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

void gives_three_rows(Reproduction& to) {
  to.note("A <set-up> of the test.");
  to.progress(0.5, "half way");
  to.row(ReproduceRow("lu.first.near", "mean error", "um", 44.5)
             .prints(44.1, "p. 1064, Fig. 11", "surfaces are 44.1 and <0.7>")
             .within(1.0)
             .fitted("grid and mask"));
  to.row(ReproduceRow("lu.first.bound", "time", "s", 1.25).derives(2.0, "errata", "by hand").at_most(2.0));
  to.row(ReproduceRow("lu.first.measured", "of the real printer", "um", 21.3)
             .prints(22.3, "p. 1067, Table II", "22.8 18.5 22.3")
             .not_identifiable("the ink is not described"));
  to.beside({"lu.first.own", "of ours alone", "um", 7.6});
  to.picture({"first", "A caption with < and &", "<svg viewBox=\"0 0 1 1\"><path d=\"M0 0\"/></svg>"});
}
ReproduceRow a_miss() {
  return ReproduceRow("lu.second.bad", "gamma", "", 0.6)
      .prints(0.6268, "p. 1066, Table I", "0.6268")
      .within(0.01);
}
void gives_a_bad_row(Reproduction& to) { to.row(a_miss()); }
void throws(Reproduction&) { throw std::runtime_error("no file seed.json"); }
void gives_a_foreign_row(Reproduction& to) {
  ReproduceRow row = a_miss();
  row.id = "lu.first.stolen";
  to.row(row);
}

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

TEST_CASE("A reproduction fails by a disagreement without a known reason, and by nothing else",
          "[reproduce]") {
  CHECK(all_pass(results({"first"})));
  CHECK_FALSE(all_pass(results({}, "lu")));
  CHECK_FALSE(all_pass(results({}, "thompson")));  // a part that throws
  CHECK(a_miss().fails());
  ReproduceRow known = a_miss();
  CHECK_FALSE(known.not_reproduced("the ink spreads further").fails());
  CHECK(known.verdict() == Verdict::kNotReproduced);
  CHECK(known.reason() == "the ink spreads further");
}

TEST_CASE("A row's verdict follows from its comparison alone", "[reproduce]") {
  const auto row = [](double ours) { return ReproduceRow("a.b.c", "", "um", ours); };
  CHECK(row(44.5).prints(44.1, "p. 1", "44.1").within(1.0).verdict() == Verdict::kReproduced);
  CHECK(row(46.0).prints(44.1, "p. 1", "44.1").within(1.0).verdict() == Verdict::kNotReproduced);
  CHECK(row(1.0).derives(1.0, "errata", "by hand").within_derived(0.1).verdict() == Verdict::kDerived);
  CHECK(row(0.0610)
            .prints(0.061, "p. 1", "0.061")
            .within(5e-4)
            .derives(0.06099, "errata", "")
            .within_derived(1e-6)
            .verdict() == Verdict::kNotReproduced);  // the derived value is missed
  CHECK(row(1.0).prints(2.0, "p. 1", "2").not_identifiable("no data").verdict() == Verdict::kNotIdentifiable);
  CHECK(row(9.0).prints(2.0, "p. 1", "2").within(1.0).not_identifiable("no data").fails());  // the bound
                                                                                             // still counts
  CHECK(row(9.0).prints(2.0, "p. 1", "2").within(1.0).not_judged("cut short").verdict() ==
        Verdict::kNotIdentifiable);
  CHECK(row(0.1).not_reproduced("stale").prints(0.1, "p. 1", "0.1").within(0.01).verdict() ==
        Verdict::kReproduced);
}

TEST_CASE("A row's kind is that of the printed value, or of the derived one where none is printed",
          "[reproduce]") {
  const auto row = [] { return ReproduceRow("a.b.c", "", "", 1.0); };
  CHECK(row().prints(44.1, "p. 1", "44.1").kind() == RowKind::kNumber);
  CHECK(row().prints(44.1, "p. 1", "44.1").fitted("grid").kind() == RowKind::kFittedNumber);
  CHECK(row().prints("6.2 6.2 6.6 6.3", "p. 1", "").kind() == RowKind::kNumber);
  CHECK(row().prints("4.5×10^{-9} 4.9×10^{-9}", "p. 1", "").kind() == RowKind::kNumber);
  CHECK(row().prints("about half", "p. 1", "about half").fitted("grid").kind() == RowKind::kWording);
  CHECK(row().prints("more than 1 mm", "p. 1", "more than 1 mm").kind() == RowKind::kWording);
  CHECK(row().derives(21.3, "errata", "by hand").kind() == RowKind::kNumber);
  CHECK(row().derives("prints for ever", "errata", "by hand").kind() == RowKind::kWording);
  CHECK(row().prints(1.05, "p. 1", "1.05").arithmetic().kind() == RowKind::kArithmetic);
}

TEST_CASE("JSON carries printed, derived and ours with their sources, the verdict and its reason",
          "[reproduce]") {
  const Json all = Json::parse(reproduce_json(results({}, "lu")));
  const Json& rows = all["rows"];
  REQUIRE(rows.size() == 4);
  CHECK(rows[0]["printed"] == 44.1);
  CHECK(rows[0]["printed_place"] == "p. 1064, Fig. 11");
  CHECK(rows[0]["printed_quote"] == "surfaces are 44.1 and <0.7>");
  CHECK(rows[0]["derived"].is_null());
  CHECK(rows[0]["ours"] == 44.5);
  CHECK(rows[0]["tolerance"] == "+- 1 um");
  CHECK(rows[0]["verdict"] == "reproduced");
  CHECK(rows[0]["fit"] == "grid and mask");
  CHECK(rows[0]["kind"] == "number with fit");
  CHECK(rows[0]["unexpected"] == false);
  CHECK(rows[1]["tolerance"] == "<= 2 s");
  CHECK(rows[1]["printed"].is_null());
  CHECK(rows[1]["derived_by"] == "errata");
  CHECK(rows[1]["derived_how"] == "by hand");
  CHECK(rows[1]["verdict"] == "derived");
  CHECK(rows[2]["verdict"] == "not identifiable");
  CHECK(rows[2]["reason"] == "the ink is not described");
  CHECK(rows[2]["tolerance"].is_null());
  CHECK(rows[3]["verdict"] == "not reproduced");
  CHECK(rows[3]["unexpected"] == true);
  REQUIRE(all["beside"].size() == 1);
  CHECK(all["beside"][0]["ours"] == 7.6);
  CHECK(all["counts"]["lu"]["rows"] == 4);
  CHECK(all["counts"]["lu"]["reproduced"] == 1);
  CHECK(all["counts"]["lu"]["fit"] == 1);
  CHECK(all["counts"]["all"]["unexpected"] == 1);
  CHECK(all["counts"]["all"]["reproduced kinds"]["number with fit"] == 1);
  CHECK(all["counts"]["all"]["reproduced kinds"]["number"] == 0);
}

TEST_CASE("A number that is none never agrees", "[reproduce]") {
  const double none = std::numeric_limits<double>::quiet_NaN();
  CHECK(ReproduceRow("a", "", "", none).prints(1.0, "p. 1", "1").within(1.0).fails());
  CHECK(ReproduceRow("a", "", "", none).derives(1.0, "errata", "by hand").at_most(1.0).fails());
}

TEST_CASE("A self-check, a printed value without its place and a row without a judgement are refused",
          "[reproduce]") {
  const auto refused = [](ReproduceRow row, const std::string& why) {
    static ReproduceRow given;
    given = std::move(row);
    ReproduceOptions options;
    const auto all = reproduce(options, {{"lu", "x", "", 1, [](Reproduction& to) { to.row(given); }}});
    CHECK_THAT(all.at(0).error, Contains(why));
    CHECK(all.at(0).rows.empty());
  };
  const auto row = [] { return ReproduceRow("lu.x.y", "", "", 1.0); };
  refused(row().at_most(2.0), "a self-check is no row");
  refused(row().prints(1.0, "", "1").within(0.1), "names no place");
  refused(row().derives(1.0, "errata", "").within_derived(0.1), "who derived its value and how");
  refused(row().prints(1.0, "p. 1", "1"), "neither compared nor said to be not identifiable");
}

TEST_CASE("A part that throws fails, says why and has no rows, and the other parts still run",
          "[reproduce]") {
  const auto all = results({});
  REQUIRE(all.size() == 4);
  CHECK_THAT(all[2].error, Contains("no file seed.json"));
  CHECK(all[2].rows.empty());
  CHECK_THAT(all[3].error, Contains("lu.first.stolen"));
  CHECK_THAT(reproduce_table(all), Contains("thompson.third could not be computed: no file seed.json"));
  CHECK_THAT(reproduce_page(all), Contains("could not be computed: no file seed.json"));
  CHECK(Json::parse(reproduce_json(all))["errors"].size() == 2);
}

TEST_CASE("The table shows places, FIT, reasons and counts", "[reproduce]") {
  const std::string table = reproduce_table(results({}, "lu"));
  for (const char* piece :
       {"44.10 um (p. 1064, Fig. 11)", "reproduced, FIT", "2.00 s (errata)", "not reproduced, UNEXPECTED",
        "the ink is not described: lu.first.measured", "lu.first.own",
        "4 rows: 1 reproduced, 1 derived, 1 not identifiable, 1 not reproduced; 1 are FIT, 1 unexpected",
        "of the reproduced: 0 number, 1 number with fit, 0 wording, 0 arithmetic"})
    CHECK_THAT(table, Contains(piece));
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
       {"lu.first.near", "+- 1 um", "A &lt;set-up&gt;", "A caption with &lt; and &amp;", "<svg viewBox",
        "p. 1064, Fig. 11: &quot;surfaces are 44.1 and &lt;0.7&gt;&quot;", "<b>FIT</b>: grid and mask",
        "errata: by hand", "the ink is not described", "lu.first.own"})
    CHECK_THAT(page, Contains(piece));
  for (const char* piece : {"<script", "<link", "src=\"http"}) CHECK(page.find(piece) == page.npos);
  CHECK_THAT(report::standalone_svg(first[0].pictures[0].svg),
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
