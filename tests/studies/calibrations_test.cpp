// The calibrations of the ice lab through their whole path: nodes, drivers, byte-level twins, readings, fit.
// Planted cases must come out within the thesis's tolerances [Barnett 2012, 2.2, 5.2.1]; runs that cannot
// tell are refused by name.
#include <catch2/catch.hpp>

#include "core/path/path.h"
#include "studies/calibrate/lab_calibrations.h"
#include "tests/support/long_cases.h"
#include "tests/support/planted_ice.h"

namespace firn {
namespace {

using calibration::Unidentifiable;
using planted::Judged;

const planted::IceLab& shipped() {
  static const planted::IceLab lab = planted::shipped_ice_lab(FIRN_SOURCE_DIR);
  return lab;
}

/// Numbers of the cases, 1 to 100, that this run tries.
std::vector<int> cases(std::size_t few) {
  std::vector<int> numbers;
  for (const std::size_t n : test::long_cases(100, few)) numbers.push_back(int(n) + 1);
  return numbers;
}

/// The table level, the laser as calibrated: as the calibrations follow each other.
Experiment ready_case(std::uint64_t n, bool laser_known) {
  Experiment e = planted::plant_case(shipped(), n);
  for (double& foot : e.plant.ice.foot_mm) foot *= 0.05;
  if (!laser_known) return e;
  e.laser_point.offset_x_mm = e.plant.ice.laser_dx_mm;
  e.laser_point.offset_y_mm = e.plant.ice.laser_dy_mm;
  e.laser_point.latency_s = planted::laser_latency_s(e);
  return e;
}

LabCalibrationOptions options(std::uint64_t seed, int repeats = 0) {
  LabCalibrationOptions o;
  o.seed = seed;
  o.repeats = repeats;
  return o;
}

struct Tally {
  int inside = 0, all = 0;
  void add(const std::vector<Judged>& judged, double tolerance) {
    for (const Judged& j : judged) {
      CHECK(std::abs(j.error) <= tolerance);
      ++all;
      inside += j.inside();
    }
  }
  /// A binomial 95 % within four standard deviations; over 100 cases and more: at least 90 %, as asked for.
  bool covered() const {
    return inside >= 0.95 * all - 4.0 * std::sqrt(0.0475 * all) && (all < 100 || inside >= 0.9 * all);
  }
};

}  // namespace

TEST_CASE("laser-offset finds an offset wrong by up to 3 mm within 0.2 mm, wherever the block truly lies") {
  Tally t;
  for (const int n : cases(4)) {
    Experiment e = ready_case(std::uint64_t(n), false);
    const CalibrationConfig& c = e.calibration;
    const double shift = n % 2 ? 0.8 : 0.0;  // the block lies elsewhere than the lab believes
    e.plant.ice.jig_mm = {c.jig_x_mm + shift, c.jig_y_mm - shift, c.jig_x_mm + shift + c.jig_width_mm,
                          c.jig_y_mm - shift + c.jig_depth_mm, c.jig_height_mm};
    const LabCalibration found = calibrate_laser_offset(e, shipped().machine_toml, options(std::uint64_t(n)));
    t.add(planted::judge_offset(e, found), 0.2);
    CHECK(found.also.at(1).second.value == Approx(shift).margin(0.1));
  }
  CHECK(t.covered());
}

TEST_CASE("laser-latency is found within 2 ms, the block's place and the laser's offset unknown") {
  Tally t;
  for (const int n : cases(6)) {
    const Experiment e = ready_case(std::uint64_t(n), false);
    t.add(planted::judge_laser_latency(
              e, calibrate_laser_latency(e, shipped().machine_toml, options(std::uint64_t(n)))),
          0.002);
  }
  CHECK(t.covered());
}

TEST_CASE("level-table finds the table's height within 0.05 mm and its slopes within their intervals") {
  Tally t, slopes;
  for (const int n : cases(20)) {
    Experiment e = planted::plant_case(shipped(), std::uint64_t(n));
    e.plant.ice.laser_dx_mm = e.plant.ice.laser_dy_mm = 0.0;
    const std::vector<Judged> judged =
        planted::judge_table(e, calibrate_table(e, shipped().machine_toml, options(std::uint64_t(n))));
    t.add({judged[0]}, 0.05);
    slopes.add({judged[1], judged[2]}, 0.1);
  }
  CHECK(t.covered());
  CHECK(slopes.covered());
}

TEST_CASE(
    "Turned as level-table says, feet and then screws, any table comes within 0.2 mm, its height within its "
    "interval though screws bend it") {
  int feet = 0;
  Tally t;
  for (const int n : cases(4)) {
    Experiment e = planted::plant_case(shipped(), std::uint64_t(n));
    e.plant.ice.laser_dx_mm = e.plant.ice.laser_dy_mm = 0.0;
    planted::plant_screws(e, std::uint64_t(n));
    LabCalibrationOptions o = options(1);
    o.rounds = 10;
    const LabCalibration c = calibrate_table(e, shipped().machine_toml, o);
    INFO(c.lines.front() << " ... " << c.lines.back());
    CHECK(c.level);
    REQUIRE(c.keys.size() == 1);
    CHECK(c.keys[0].key == "origin_z_mm");
    // If all nine lie within 0.5 mm at the start (one table in a hundred of these), the feet have nothing to
    // do.
    const bool coarse = c.lines[0].find("; 0.5 mm is wanted") != std::string::npos;
    CHECK(coarse == (c.lines[0].find("turn the feet") != std::string::npos));
    CHECK(coarse == (c.lines[1].find("turn foot") != std::string::npos));
    feet += coarse;
    t.add(planted::judge_table(e, c), 0.1);
  }
  CHECK(feet >= int(cases(4).size()) * 9 / 10);
  CHECK(t.covered());
}

TEST_CASE("level-table goes on with the screws where the feet can do no more") {
  // A plate of which four feet leave 0.53 mm: the message would be to turn nothing, and the table would never
  // become level.
  Experiment e = planted::plant_case(shipped(), 25);
  e.plant.ice.laser_dx_mm = e.plant.ice.laser_dy_mm = 0.0;
  planted::plant_screws(e, 25);
  LabCalibrationOptions o = options(1);
  o.rounds = 10;
  const LabCalibration c = calibrate_table(e, shipped().machine_toml, o);
  CHECK(c.level);
  CHECK(c.keys.size() == 1);
}

TEST_CASE(
    "level-table reads what the arm reaches of the table, no places nearer to each other than the nine "
    "points nearly are") {
  Experiment e = planted::plant_case(shipped(), 7);
  e.plant.ice.laser_dx_mm = e.plant.ice.laser_dy_mm = 0.0;
  const LabCalibration c = calibrate_table(e, shipped().machine_toml, options(7));
  CHECK(c.data > 20);
  std::vector<Point2> places;
  for (const auto& g : c.plot.groups)
    for (const double x : g.x) places.push_back({x, std::stod(g.label.substr(4))});
  const CalibrationConfig& k = e.calibration;
  double beyond_mm = 0.0;
  for (const Point2& p : places) {
    CHECK(std::abs(p.x_mm - k.table_x_mm) < 0.5 * k.table_width_mm);
    CHECK(std::abs(p.y_mm - k.table_y_mm) < 0.5 * k.table_depth_mm);
    beyond_mm = std::max({beyond_mm, k.level_x_mm.front() - p.x_mm, p.x_mm - k.level_x_mm.back(),
                          k.level_y_mm.front() - p.y_mm, p.y_mm - k.level_y_mm.back()});
    for (const Point2& q : places)
      if (&p != &q) CHECK(std::hypot(p.x_mm - q.x_mm, p.y_mm - q.y_mm) > 80.0);
  }
  CHECK(beyond_mm > 80.0);
}

TEST_CASE("valve-latency is found within 2 ms from drops that the laser finds again") {
  Tally t;
  for (const int n : cases(3)) {
    const Experiment e = ready_case(std::uint64_t(n), true);
    LabCalibrationOptions o = options(std::uint64_t(n));
    o.material = n % 2;
    t.add(planted::judge_valve_latency(e, calibrate_valve_latency(e, shipped().machine_toml, o), o.material,
                                       2.0),
          0.002);
  }
  CHECK(t.covered());
}

TEST_CASE(
    "flow-curve is found within 2 % from weighed drops, a coil that warms and liquid that does "
    "notwithstanding") {
  int inside = 0;  // the rows of a case share their weighings: twenty are not twenty cases
  for (const int n : cases(2)) {
    const Experiment e = ready_case(std::uint64_t(n), true);
    LabCalibrationOptions o = options(std::uint64_t(n));
    o.material = n % 2;
    const LabCalibration c = calibrate_flow_curve(e, shipped().machine_toml, o);
    REQUIRE(c.keys.size() == 2);
    CHECK(c.keys[0].value.size() == 20);
    for (const Judged& j : planted::judge_flow(e, c, o.material)) {
      CHECK(std::abs(j.error) <= 0.02);
      inside += j.inside();
    }
  }
  const std::size_t all = cases(2).size();
  CHECK(inside >= (all < 100 ? 0.8 : 0.92) * 20 * double(all));
}

TEST_CASE("Runs that cannot tell are refused by name") {
  const std::string& machine = shipped().machine_toml;
  const Experiment e = ready_case(1, true);
  Experiment no_block = e;
  no_block.plant.ice.jig_mm = {-100, -100, -90, -90, 2.0};
  CHECK_THROWS_WITH(calibrate_laser_offset(no_block, machine, options(1, 1)),
                    Catch::Contains("no reading steps"));
  CHECK_THROWS_AS(calibrate_laser_latency(no_block, machine, options(1, 1)), Unidentifiable);
  CHECK_THROWS_WITH(calibrate_laser_latency(e, machine, options(1, 1)),
                    Catch::Contains("latency"));  // four steps

  Experiment along_edge = e;  // passes run beside the block, or along its sides
  const CalibrationConfig& c = e.calibration;
  along_edge.plant.ice.jig_mm = {c.jig_x_mm - 200, c.jig_y_mm + 0.5 * c.jig_depth_mm, c.jig_x_mm + 200,
                                 c.jig_y_mm + 2.0 * c.jig_depth_mm, 2.0};
  CHECK_THROWS_AS(calibrate_laser_latency(along_edge, machine, options(1, 3)), Unidentifiable);

  Experiment on_a_line = e;
  on_a_line.calibration.level_x_mm = {90.0};
  on_a_line.calibration.level_y_mm = {-200, -100, 0, 100, 200, 300, 400};
  CHECK_THROWS_WITH(calibrate_table(on_a_line, machine, {}), Catch::Contains("slope along x"));
  Experiment no_points = e;
  no_points.calibration.level_x_mm.clear();
  CHECK_THROWS_AS(calibrate_table(no_points, machine, {}), Unidentifiable);

  LabCalibrationOptions one_frequency;
  one_frequency.frequencies_hz = {100.0};
  CHECK_THROWS_WITH(calibrate_flow_curve(e, machine, one_frequency), Catch::Contains("five frequencies"));
  one_frequency.frequencies_hz = {100.0, 700.0};
  CHECK_THROWS_WITH(calibrate_flow_curve(e, machine, one_frequency), Catch::Contains("a pulse a tick"));
  Experiment empty_tank = e;
  empty_tank.plant.ice.tank_water_mm3 = 0.0;
  CHECK_THROWS_WITH(calibrate_flow_curve(empty_tank, machine, {}), Catch::Contains("nothing in the cup"));
  CHECK_THROWS_WITH(calibrate_valve_latency(empty_tank, machine, options(1, 1)),
                    Catch::Contains("only 0 were found"));
  Experiment inkjet;
  CHECK_THROWS_WITH(calibrate_table(inkjet, machine, {}), Catch::Contains("only an ice lab"));
}

}  // namespace firn
