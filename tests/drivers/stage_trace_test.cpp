#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/drivers/yes_ensemble.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::YesEnsemble;

namespace {

struct PathEnsemble : YesEnsemble {
  PathEnsemble() : YesEnsemble(StageOptions{}) {}
  bool sent(const std::string& line) const { return std::find(log.begin(), log.end(), line) != log.end(); }
  Result last() { return bench.all<Result>().back(); }
  void trace(const StageWay& way) {
    bench.command([&](std::int64_t t, Effects& fx) { stage.trace(way, 1.0, t, fx); });
  }
};

StageWay straight() { return {{{0, 1, 2, 0, 0}, {0.5, 1.5, 2, 2, 0}, {1.0, 2, 2, 0, 0}}, {0.25, 0.75}}; }

}  // namespace

TEST_CASE("a way is sent as knots and switches, followed, counted", "[stage]") {
  PathEnsemble e;
  e.trace(straight());
  e.run([&] { return e.stage.safe() && !e.bench.all<Result>().empty(); });
  CHECK(e.last().outcome == Outcome::kDone);
  CHECK(e.last().counted == 2);
  for (const char* line :
       {"IGLOBAL(40)=3", "DGLOBAL(5)=0.5", "DGLOBAL(6)=1.5", "DGLOBAL(8)=2", "DGLOBAL(10)=1",
        "PSOOUTPUT @0 TOGGLE", "PSOTRACK @0 INPUT 3,4", "IGLOBAL(50)=2500", "IGLOBAL(51)=5000",
        "PSOARRAY @0,50,2", "PSOCONTROL @0 ARM", "PROGRAM RUN 1, \"FirnPath.bcx\"", "PSOCONTROL @0 OFF"}) {
    INFO(line);
    CHECK(e.sent(line));
  }
}

TEST_CASE("a way that the stage cannot follow is refused before anything is sent, with knot and limit",
          "[stage][I8]") {
  PathEnsemble e;
  const std::size_t lines = e.log.size();
  const auto refused = [&](StageWay way, const std::string& text) {
    e.trace(way);
    CHECK(e.last().outcome == Outcome::kRefused);
    CHECK_THAT(e.last().text, Catch::Contains(text));
    CHECK(e.log.size() == lines);
  };
  StageWay way = straight();
  way.knots[1].x_mm = 1000.0;
  refused(way, "knot 1");
  way = straight();
  way.knots[2].t_s = 0.4;
  refused(way, "knot 2: times do not ascend");
  way = straight();
  way.knots[1].vx_mm_s = 1e4;
  refused(way, "knot 1: speed");
  way = straight();
  way.switch_mm = {0.5};
  refused(way, "1 switches");
  way.switch_mm = {0.5, 0.5};
  refused(way, "switch 1");
  refused({}, "0 knots");
}

TEST_CASE("a stop in the middle of a way closes the shutter before the axes brake", "[stage]") {
  PathEnsemble e;
  e.trace(straight());
  e.run([&] { return e.sent("PROGRAM RUN 1, \"FirnPath.bcx\""); });
  const std::size_t before = e.log.size();
  e.bench.command([&](std::int64_t t, Effects& fx) { e.stage.safe_stop(t, fx); });
  e.run([&] { return e.stage.safe(); });
  const auto off = std::find(e.log.begin() + std::ptrdiff_t(before), e.log.end(), "PSOCONTROL @0 OFF");
  const auto abort = std::find(e.log.begin() + std::ptrdiff_t(before), e.log.end(), "ABORT @0");
  REQUIRE(off != e.log.end());
  REQUIRE(abort != e.log.end());
  CHECK(off < abort);
  CHECK(e.last().outcome == Outcome::kUnknown);
}
