// The assumptions of a lab file about its instruments, each with the mark of its evidence.
#include <catch2/catch.hpp>

#include "config/assumptions.h"
#include "config/error.h"
#include "config/fields.h"

using namespace firn;
using Catch::Contains;

TEST_CASE("the mark of a key is the last one in its meaning") {
  CHECK(mark_of("asks for the hours [S]") == 'S');
  CHECK(mark_of("question [U]; none: rows are in doubt") == 'U');
  CHECK(mark_of("the table [Lu 2015, Table I]") == 0);
  CHECK(mark_of("") == 0);
  CHECK(mark_of("[P]") == 'P');
  CHECK(mark_of("[C] of one, [P] of the other") == 'P');
  CHECK(mark_of("[X]") == 0);
  CHECK((unproven('P') && unproven('U') && unproven('M')));
  CHECK_FALSE((unproven('C') || unproven('S') || unproven(0)));
}

TEST_CASE("every key of a dialect has the mark of its evidence") {
  Experiment e;
  int keys = 0;
  for (const Field& f : fields(e))
    if (f.key.find(".dialect.") != std::string::npos) {
      INFO(f.key);
      CHECK(mark_of(f.meaning) != 0);
      ++keys;
    }
  CHECK(keys > 70);
}

TEST_CASE("what no source proves is named with its value, the rest is counted") {
  Experiment e;
  e.jet.dialect.max_abs_v = 60;
  const std::string jet = assumptions_text(e, "jet");
  CHECK_THAT(jet, Contains("[S]") && Contains("devices.jet.dialect.max_abs_v = 60 [P]") &&
                      !Contains("strobe_divider"));
  CHECK_THAT(assumptions_text(e, "stage"), Contains("stage.pulse_count = \"PSOCOUNT\" [U]"));
  CHECK_THAT(assumptions_text(e, "laser_point"), Contains("[C]") && Contains("storage = \"SW,CI,1,\" [P]"));
  CHECK(assumptions_text(e, "scheduler").empty());
  for (const Assumption& a : assumptions(e, "jet_b")) CHECK_THAT(a.key, Contains("jet_b."));
}

TEST_CASE("a dialect's text is refused when it is empty or longer than a request") {
  for (const std::string& text : {std::string(), std::string(61, 'A')}) {
    CHECK_THROWS_WITH(parse_experiment({{"t.toml", "devices.lamp.dialect.open = \"" + text + "\"\n"}}, {}),
                      Contains("devices.lamp.dialect.open") && Contains("1 to 60 characters"));
  }
  const Experiment e = parse_experiment({{"t.toml", "[devices.lamp.dialect]\nopen = \"OPEN\"\n"}},
                                        {"devices.jet.dialect.size=5"});
  CHECK(e.lamp.dialect.open == "OPEN");
  CHECK(e.jet.dialect.size == 5);
  CHECK(dump(parse_experiment(dump(e), "d.toml")) == dump(e));
  CHECK_THROWS_WITH(parse_experiment({{"t.toml", "devices.lamp.dialect.opn = \"OPN\"\n"}}, {}),
                    Contains("nearest known one is devices.lamp.dialect.open"));
}
