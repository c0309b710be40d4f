// Conditions on runs: their meaning, and errors that point at the column.
#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "runs/find/query.h"
#include "runs/find/query_sql.h"

namespace firn::test {
namespace {

using Catch::Contains;
using runs::parse_query;
using runs::Query;
using runs::QueryError;

// A tree in brackets, as an oracle reads it.
std::string shape(const Query& q) {
  const auto parts = [&] {
    std::string text;
    for (const Query& p : q.parts) text += " " + shape(p);
    return text;
  };
  switch (q.kind) {
    case Query::Kind::kAll:
      return "all";
    case Query::Kind::kAnd:
      return "(and" + parts() + ")";
    case Query::Kind::kOr:
      return "(or" + parts() + ")";
    case Query::Kind::kNot:
      return "(not" + parts() + ")";
    case Query::Kind::kHas:
      return "has:" + q.key;
    case Query::Kind::kMentions:
      return "'" + q.text + "'";
    case Query::Kind::kCompare:
      break;
  }
  return q.key + ":" + std::to_string(int(q.op)) + ":" + (q.number ? "#" : "") + q.text;
}

TEST_CASE("a condition binds not before and, and and before or") {
  CHECK(shape(parse_query("")) == "all");
  CHECK(shape(parse_query("  mpc ")) == "'mpc'");
  CHECK(shape(parse_query("a=1 or b=2 and not c=3")) == "(or a:0:#1 (and b:0:#2 (not c:0:#3)))");
  CHECK(shape(parse_query("(a=1 or b=2) and c=3 and d=4")) == "(and (or a:0:#1 b:0:#2) c:0:#3 d:0:#4)");
  CHECK(shape(parse_query("not not has meta.ink")) == "(not (not has:meta.ink))");
  CHECK(shape(parse_query("meta.ink ~ \"TPGDA (a) \\\"b\\\"\"")) == "meta.ink:6:TPGDA (a) \"b\"");
}

TEST_CASE("a word is a number where it reads as one, and a text in quotes never is") {
  CHECK(parse_query("a=1e-3").number == 1e-3);
  CHECK(parse_query("a=-5").number == -5.0);
  CHECK_FALSE(parse_query("a=\"5\"").number);
  CHECK_FALSE(parse_query("started >= 2026-11-01").number);
  CHECK(parse_query("sample = 007").text == "007");
}

TEST_CASE("a mistake is named with its column") {
  struct Case {
    std::string text;
    std::size_t column;
    std::string problem;
  };
  for (const Case& c : std::vector<Case>{{"rms_um <", 9, "a value is wanted behind '<'"},
                                         {"rms_um < < 2", 10, "'<' is none"},
                                         {"rms_um < 2 and", 15, "the end, and a condition is wanted"},
                                         {"and a=1", 1, "a condition is wanted before 'and'"},
                                         {"a=1 b=2", 5, "'and' or 'or' is wanted before 'b'"},
                                         {"(a=1", 5, "a ')' is wanted"},
                                         {"a=1)", 4, "without its '('"},
                                         {"a = \"x", 5, "has no end"},
                                         {"a & b", 3, "'&' is no part of a condition"},
                                         {"\"a\" = 1", 1, "a key is wanted before '='"},
                                         {"has 5", 5, "a key is wanted behind 'has'"},
                                         {"= 1", 1, "begins none"},
                                         {std::string(5000, 'a'), 1, "at most 4096"}}) {
    INFO(c.text.substr(0, 40));
    try {
      parse_query(c.text);
      FAIL("was read");
    } catch (const QueryError& e) {
      CHECK(e.column == c.column);
      CHECK_THAT(e.problem, Contains(c.problem));
      CHECK_THAT(e.what(), Contains("column " + std::to_string(c.column)));
      CHECK(e.shown.ends_with("\n    " + std::string(c.column - 1, ' ') + "^\n"));
    }
  }
  CHECK_THROWS_WITH(parse_query(std::string(200, '(')), Contains("more than 50 levels"));
}

TEST_CASE("a key that no run has is refused with the nearest one, at its column") {
  const auto of = [](const std::string& text) -> std::string {
    try {
      runs::sql_of(parse_query(text), text);
      return "";
    } catch (const QueryError& e) {
      return std::to_string(e.column) + ": " + e.problem;
    }
  };
  CHECK(of("rms_um < 2 and meta.own = 1 and control.mpc.alpha > 0.5 and tag = x").empty());
  CHECK(of("a or rmsum < 2") == "6: rmsum: no run has such a key; the nearest one is rms_um");
  CHECK_THAT(of("control.mpc.alpa = 1"), Contains("the nearest one is control.mpc.alpha"));
  CHECK_THAT(of("ink = TPGDA"), Contains("meta.ink is one"));
  CHECK_THAT(of("not has metta"), Contains("9: metta"));
  CHECK_THAT(of("meta.Ink = a"), Contains("no run has such a key"));
}

TEST_CASE("whatever the text, a condition is read or refused at a column inside it or at its end") {
  RandomStream random(57, Purpose::kTest);
  const std::vector<std::string> words{"rms_um", "<",        ">=", "2",   "and",      "or",
                                       "not",    "(",        ")",  "\"x", "\"",       "~",
                                       "has",    "meta.ink", " ",  "\\",  "\xc3\xa9", "!="};
  int read = 0;
  for (int n = 0; n < 20'000; ++n) {
    std::string text;
    for (std::uint32_t k = random.below(8); k > 0; --k)
      text += words[random.below(std::uint32_t(words.size()))] + (random.below(2) ? " " : "");
    try {
      const Query q = parse_query(text);
      runs::sql_of(q, text);
      ++read;
    } catch (const QueryError& e) {
      CHECK(e.column >= 1);
      CHECK(e.column <= text.size() + 1);
    }
  }
  CHECK(read > 1000);
}

}  // namespace
}  // namespace firn::test
