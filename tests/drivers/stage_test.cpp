#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/stage/stage.h"
#include "tests/drivers/bench.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::Bench;

namespace {

const std::string kTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void stage_command(Stage& stage, const std::string& text, std::int64_t now_us, Effects& fx) {
  if (text == "pass") {
    DropletPattern pattern(GridSpec{4, 2, 0.25, 0.5, 0.0, 0.0});
    pattern.at(0, 1) = pattern.at(2, 1) = pattern.at(3, 1) = 1;
    stage.run_pass(pattern, 0, kNaN, 0.0, now_us, fx);
  } else if (text == "bad verb") {
    stage.move_to(1.0, kNaN, kNaN, 0.0, now_us, fx);
  } else {
    FAIL("no command " << text);
  }
}

}  // namespace

TEST_CASE("the stage speaks as the Ensemble cards say, whatever the split of the replies", "[stage]") {
  for (const std::size_t split : {0, 1, 2, 3}) {
    Stage stage(StageConfig{});
    test::play(stage, kTranscripts + "ens_pso_row.txt", [&](const std::string& c, std::int64_t t, Effects& fx) { stage_command(stage, c, t, fx); }, split);
  }
}
