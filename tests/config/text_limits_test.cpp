// A configuration is a page of text: its bytes, lines and dots are bounded before a parser sees them.
#include "config/text_limits.h"

#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/experiment.h"

using namespace firn;
using Catch::Contains;

namespace {

std::string text_refusal(const std::string& text) {
  try {
    check_text(text, "x.toml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("65,536 bytes are read, one more is refused with both numbers") {
  std::string text;
  while (text.size() + 64 <= 65536) text += std::string(63, '#') + '\n';
  REQUIRE(text.size() == 65536);
  CHECK(text_refusal(text) == "");
  CHECK_THAT(text_refusal(text + "\n"), Contains("65537 bytes") && Contains("65536"));
}

TEST_CASE("A line of 2,000 bytes is read, a longer one is refused by its number") {
  CHECK(text_refusal("\n" + std::string(2000, 'x') + "\n") == "");
  CHECK_THAT(text_refusal("\n\n" + std::string(2001, 'x')), Contains("x.toml:3") && Contains("2000"));
}

TEST_CASE("The heights of as many places as a table may have are written in lines that are read") {
  Experiment e;
  e.actuation.offsets = OffsetKind::kGrid;
  e.actuation.positions_x = 7;
  e.actuation.positions_y = 8;
  for (int n = 0; n < (OffsetTable(e.actuation).size() - 1) * 25; ++n)
    e.actuation.heights_mm.push_back(1e-3 + 1.23e-7 * n);
  const std::string text = dump(e);
  CHECK(text_refusal(text) == "");
  CHECK(parse_experiment(text, "x.toml").actuation.heights_mm == e.actuation.heights_mm);
}

TEST_CASE("4,000 dots are read, more are called nesting") {
  std::string text;
  for (int n = 0; n < 400; ++n) text += "..........\n";
  CHECK(text_refusal(text) == "");
  CHECK_THAT(text_refusal(text + "."), Contains("4000 dots"));
}

TEST_CASE("An experiment meets these limits before its parser") {
  CHECK_THROWS_WITH(parse_experiment("a = " + std::string(3000, '['), "x.toml"), Contains("2000"));
}
