// Adds a key in a copy of core/control/options.h (new_key.cmake): a member of ThresholdOptions and a row of
// its table.
#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/experiment.h"
#include "config/markdown.h"

using namespace firn;

TEST_CASE("A key is a member of an options struct and a row of its table: all else knows it") {
  const std::string key = "control.threshold.toy_share";
  CHECK(Experiment{}.control.threshold.toy_share == 0.25);
  const Experiment e = parse_experiment(key + " = 0.5", "x.toml");
  CHECK(e.control.threshold.toy_share == 0.5);
  CHECK(dump(e).find("toy_share = 0.5\n") != std::string::npos);
  CHECK(parse_experiment(dump(e), "x.toml").control.threshold.toy_share == 0.5);
  CHECK(configuration_markdown().find("|toy_share|0.25 mm|(0, 0.5]|of a toy|") != std::string::npos);
  CHECK_THROWS_WITH(parse_experiment(key + " = 0.75", "x.toml"),
                    "x.toml:1: control.threshold.toy_share = 0.75: must lie in (0, 0.5] mm");
  CHECK_THROWS_WITH(parse_experiment("control.threshold.toy_shrae = 0.5", "x.toml"),
                    Catch::EndsWith("the nearest known one is control.threshold.toy_share"));
  control::ThresholdOptions options;
  options.toy_share = 0.75;
  CHECK_THROWS_WITH(check_options("threshold", control::kThresholdOptions, options),
                    "threshold: toy_share = 0.75 is outside (0, 0.5]");
}
