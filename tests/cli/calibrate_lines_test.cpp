// Calibrations of the ice lab whose instruments stand behind serial lines and TCP ports, by the clock: each
// must find the same as in simulated time. The flow curve takes half an hour: ./firn bench calibrate_lines.
#include <catch2/catch.hpp>

#include "files/json.h"
#include "tests/cli/lined_lab.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

struct Found {
  std::string real, simulated;
};

Found both(LinedLab& lab, const std::string& what, const std::vector<std::string>& more) {
  const Said real = lab.calibrate(what, true, more), simulated = lab.calibrate(what, false, more);
  INFO(real.out << real.err << simulated.err);
  REQUIRE(real.code == 0);
  REQUIRE(simulated.code == 0);
  CHECK_THAT(real.err, Contains("REAL: robot (tcp:127.0.0.1:") && Contains("laser_point (serial:/dev/pts/"));
  return {real.out, simulated.out};
}

void check_same(const Found& f, const std::vector<std::string>& names) {
  CHECK(Json::parse(f.real)["data"] == Json::parse(f.simulated)["data"]);
  const std::vector<FoundTwice> found = found_twice(f.real, f.simulated);
  REQUIRE(found.size() == names.size());
  for (std::size_t n = 0; n < names.size(); ++n) {
    INFO(found[n].real << " " << found[n].simulated << " +- " << found[n].half_95);
    CHECK(found[n].key == names[n]);
    CHECK(found[n].alike());
  }
}

}  // namespace

TEST_CASE("the laser's offset is found on real ports as in the simulated lab") {
  LinedLab lab({}, -60.0, -60.0, 10.0, 10.0);
  check_same(both(lab, "laser-offset", {"--repeats", "1"}),
             {"laser_point.offset_x_mm", "laser_point.offset_y_mm"});
}

TEST_CASE("the table is levelled on real ports as in the simulated lab") {
  // A small table, so that few points are read.
  LinedLab lab({"calibration.level_x_mm=[0, 90, 180]", "calibration.level_y_mm=[-100, 100, 300]",
                "calibration.table_width_mm=230", "calibration.table_depth_mm=430"},
               -60.0, -60.0, 10.0, 10.0);
  const Found f = both(lab, "level-table", {});
  CHECK(Json::parse(f.real)["level"] == Json::parse(f.simulated)["level"]);
  check_same(f, {"ice.origin_z_mm"});
}

TEST_CASE("a valve's latency is found on real ports as in the simulated lab") {
  LinedLab lab({}, 20.0, -20.0, 120.0, 40.0);
  check_same(both(lab, "valve-latency", {"--repeats", "1"}), {"valve_a.latency_s"});
}

TEST_CASE("a flow curve of too few weighings is refused on real ports as in the simulated lab") {
  LinedLab lab({}, -60.0, -60.0, 10.0, 10.0);
  const std::vector<std::string> few{"--frequencies", "500,450,400,300,250", "--repeats", "1"};
  const Said real = lab.calibrate("flow-curve", true, few),
             simulated = lab.calibrate("flow-curve", false, few);
  INFO(real.out << real.err << simulated.err);
  CHECK(real.code == 1);
  CHECK_THAT(real.err, Contains("weighing 25, cup of water: reading of the balance [mg]?"));
  CHECK_THAT(real.out, Contains("5 data are too few"));
  CHECK(real.out == simulated.out);
}
