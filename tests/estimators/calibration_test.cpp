// Planted cases: the true values must be found within the thesis's tolerances, inside the 95 % intervals 90
// to 98 times in 100.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/motion/planner.h"
#include "core/statistics/distributions.h"
#include "estimators/calibration/deposition.h"
#include "estimators/calibration/laser.h"
#include "estimators/calibration/table.h"

namespace firn::calibration {
namespace {

constexpr Point2 kOrigin{260.0, -100.0};
const Jig kJig{-10.0, -8.0, 10.0, 8.0};

struct Truth {
  double dx_mm = 0.0, dy_mm = 0.0, latency_s = 0.0, noise_mm = 0.02, dropouts = 0.02;
};

/// Passes over the block at one speed, run as planned with the believed laser, read with the true one.
std::vector<LaserPass> passes(const motion::Arm& arm, const motion::Tool& believed, const Truth& truth,
                              RandomStream& random, bool both_ways, bool across_y, double speed_mm_s = 60.0) {
  std::vector<LaserPass> out;
  const auto pass = [&](Point2 a, Point2 b) {
    const std::vector<Point2> line{a, b};
    motion::PathInput in;
    in.points = line;
    in.origin = kOrigin;
    in.tool = believed;
    in.speed_limit.path_mm_s =
        speed_mm_s * random.uniform(0.7, 1.0);  // readings fall differently on the sides
    motion::PlanResult r = motion::plan(in, arm, motion::cobra600_limits());
    REQUIRE(r.ok());
    LaserPass p{r.trajectory, 0.01, {}};
    const double end = r.trajectory.certificate.duration_s;
    for (double t = truth.latency_s; t < end + 0.05; t += 0.01) {
      const double k = std::clamp(t / 0.016, 0.0, double(r.tool.size() - 1));
      const std::size_t i = std::min(std::size_t(k), r.tool.size() - 2);
      const double x = r.tool[i].x_mm + (k - double(i)) * (r.tool[i + 1].x_mm - r.tool[i].x_mm) + truth.dx_mm;
      const double y = r.tool[i].y_mm + (k - double(i)) * (r.tool[i + 1].y_mm - r.tool[i].y_mm) + truth.dy_mm;
      const bool on = x > kJig.x0_mm && x < kJig.x1_mm && y > kJig.y0_mm && y < kJig.y1_mm;
      const double z = (on ? 3.0 : 0.0) + truth.noise_mm * random.normal();
      p.reading_mm.push_back(random.uniform() < truth.dropouts ? std::nanf("") : float(z));
    }
    out.push_back(std::move(p));
  };
  for (double y = -2.0; y <= 2.1; y += 1.0) {
    const double a = random.uniform(-2.0, 2.0),
                 b = random.uniform(-2.0,
                                    2.0);  // where it begins, so that readings fall differently on the sides
    pass({-30.0 + a, y}, {30.0, y});
    if (both_ways) pass({30.0 + b, y}, {-30.0, y});
    if (!across_y) continue;
    pass({y, -30.0 + a}, {y, 30.0});
    if (both_ways) pass({y, 30.0 + b}, {y, -30.0});
  }
  return out;
}

bool inside(const Estimate& e, double truth) { return std::abs(e.value - truth) <= e.ci95_half_width; }

}  // namespace

TEST_CASE(
    "Laser offset: within 0.2 mm and the latency within 2 ms over 100 planted cases, offsets wrong by up to "
    "3 mm at first") {
  const auto arm = motion::make_scara(motion::cobra600());
  const motion::Tool believed = motion::cobra600_tools()[3];
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const Truth truth{random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), random.uniform(-0.05, 0.05)};
    const LaserCalibration c = calibrate_laser(passes(*arm, believed, truth, random, true, true), kJig,
                                               {*arm, believed, kOrigin}, LaserUnknowns::kOffset);
    CHECK(std::abs(c.x_mm.value - believed.x_mm - truth.dx_mm) < 0.2);
    CHECK(std::abs(c.y_mm.value - believed.y_mm - truth.dy_mm) < 0.2);
    CHECK(std::abs(c.latency_s.value - truth.latency_s) < 0.002);
    CHECK(c.edges >= 30);
    covered += inside(c.x_mm, believed.x_mm + truth.dx_mm) + inside(c.y_mm, believed.y_mm + truth.dy_mm) +
               inside(c.latency_s, truth.latency_s);
  }
  CHECK(covered >= 270);
  CHECK(covered <= 297);
}

TEST_CASE("Laser latency: passes both ways in one direction suffice, wherever the block stands") {
  const auto arm = motion::make_scara(motion::cobra600());
  const motion::Tool believed = motion::cobra600_tools()[3];
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    RandomStream random(seed, Purpose::kTest, 1);
    const Truth truth{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-0.05, 0.05)};
    const LaserCalibration c = calibrate_laser(passes(*arm, believed, truth, random, true, false, 120.0),
                                               kJig, {*arm, believed, kOrigin}, LaserUnknowns::kLatency);
    CHECK(std::abs(c.latency_s.value - truth.latency_s) < 0.002);
    covered += inside(c.latency_s, truth.latency_s);
  }
  CHECK(covered >= 90);
  CHECK(covered <= 99);
}

TEST_CASE(
    "Passes one way only, over sides of one direction only, or over no block at all are refused by name") {
  const auto arm = motion::make_scara(motion::cobra600());
  const motion::Tool believed = motion::cobra600_tools()[3];
  const LaserBelief belief{*arm, believed, kOrigin};
  RandomStream random(1, Purpose::kTest);
  CHECK_THROWS_WITH(
      calibrate_laser(passes(*arm, believed, {}, random, false, true), kJig, belief, LaserUnknowns::kOffset),
      Catch::Contains("both ways"));
  CHECK_THROWS_WITH(
      calibrate_laser(passes(*arm, believed, {}, random, true, false), kJig, belief, LaserUnknowns::kOffset),
      Catch::Contains("no side across y"));
  CHECK_THROWS_AS(calibrate_laser({}, kJig, belief, LaserUnknowns::kLatency), Unidentifiable);
  std::vector<LaserPass> flat = passes(*arm, believed, {}, random, true, true);
  for (LaserPass& p : flat) std::fill(p.reading_mm.begin(), p.reading_mm.end(), 0.0F);
  CHECK_THROWS_AS(calibrate_laser(flat, kJig, belief, LaserUnknowns::kOffset), Unidentifiable);
  std::vector<LaserPass> few = passes(*arm, believed, {}, random, true, true);
  few.resize(2);
  CHECK_THROWS_AS(calibrate_laser(few, kJig, belief, LaserUnknowns::kOffset), Unidentifiable);
}

TEST_CASE(
    "Valve latency: within 2 ms over 100 planted cases, a mark in ten badly found, and one speed alone is "
    "refused") {
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    RandomStream random(seed, Purpose::kTest, 2);
    const double latency = random.uniform(-0.05, 0.05), offset = random.uniform(-1.0, 1.0);
    std::vector<LaidMark> marks;
    for (int k = 0; k < 24; ++k) {
      const double v = (k % 2 ? -1.0 : 1.0) * (k % 3 == 0 ? 40.0 : 100.0), at = 3.0 * k;
      const double bad = k % 10 == 7 ? random.uniform(-3.0, 3.0) : 0.0;
      marks.push_back({at, at + v * latency + offset + 0.08 * random.normal() + bad, v});
    }
    const ValveLatency c = calibrate_valve_latency(marks);
    CHECK(std::abs(c.latency_s.value - latency) < 0.002);
    CHECK(std::abs(c.offset_mm.value - offset) < 0.15);
    covered += inside(c.latency_s, latency);
    for (LaidMark& m : marks) m.speed_mm_s = 40.0;
    if (seed == 1) CHECK_THROWS_WITH(calibrate_valve_latency(marks), Catch::Contains("cannot tell"));
    marks.resize(3);
    if (seed == 1) CHECK_THROWS_WITH(calibrate_valve_latency(marks), Catch::Contains("too few"));
  }
  CHECK(covered >= 90);
  CHECK(covered <= 99);
}

TEST_CASE(
    "Flow curve: within 2 % over 100 planted curves that bend as Fig. 6-1's, and too few or useless "
    "weighings are refused") {
  int covered = 0, rows = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    RandomStream random(seed, Purpose::kTest, 3);
    const double drop = random.uniform(0.2, 0.3), sag = random.uniform(0.0, 0.25),
                 share = random.uniform(0.0, 0.15);
    const auto volume = [&](double hz) {
      return drop * (1.0 - sag * hz / 500.0) * (1.0 - share * (hz / 500.0) * (hz / 500.0));
    };
    std::vector<FlowWeighing> w;
    for (int k = 1; k <= 20; ++k)
      w.push_back({25.0 * k, 25.0 * k * 10.0 * volume(25.0 * k) * (1.0 + 0.01 * random.normal()), 10.0});
    const FlowCurveFit c = calibrate_flow_curve(w);
    REQUIRE(c.rows.size() == 20);
    for (const FlowCurveRow& r : c.rows) {
      CHECK(r.flow_mm3_s.value == Approx(r.frequency_hz * volume(r.frequency_hz)).epsilon(0.02));
      ++rows;
      covered += inside(r.flow_mm3_s, r.frequency_hz * volume(r.frequency_hz));
    }
  }
  CHECK(covered >= 0.90 * rows);
  CHECK(covered <= 0.98 * rows);
  std::vector<FlowWeighing> w{{100, 250, 10}, {110, 275, 10}, {120, 300, 10}, {130, 325, 10}};
  CHECK_THROWS_WITH(calibrate_flow_curve(w), Catch::Contains("five frequencies"));
  w = {{100, 250, 10}, {200, 500, 10}, {300, 100, 10}, {400, 100, 10},
       {500, 900, 10}, {450, 100, 10}, {350, 700, 10}};
  CHECK_THROWS_AS(calibrate_flow_curve(w), Unidentifiable);
  w[0].duration_s = 0.0;
  CHECK_THROWS_WITH(calibrate_flow_curve(w), Catch::Contains("not above 0"));
}

TEST_CASE("Level table: the plane within 0.05 mm over 100 planted tables, and the feet's turns take it out") {
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    RandomStream random(seed, Purpose::kTest, 4);
    const double bx = random.uniform(-0.004, 0.004), by = random.uniform(-0.008, 0.008),
                 h = random.uniform(-2.0, 2.0);
    std::vector<TablePoint> points;
    for (const double x : {-300.0, 0.0, 300.0})
      for (const double y : {-120.0, 0.0, 120.0})
        points.push_back({x, y, h + bx * x + by * y + 0.03 * random.normal()});
    const std::vector<Lifter> feet{{"foot 1", -430, -180, 1.5},
                                   {"foot 2", 430, -180, 1.5},
                                   {"foot 3", -430, 180, 1.5},
                                   {"foot 4", 430, 180, 1.5}};
    const TableLevel t = level_by_feet(points, feet);
    for (const TablePoint& p : points)
      CHECK(std::abs(t.plane_mm(p.x_mm, p.y_mm) - (h + bx * p.x_mm + by * p.y_mm)) < 0.08);
    CHECK(std::abs(t.height_mm.value - h) < 0.05);
    covered += inside(t.height_mm, h) + inside(t.slope_x, bx) + inside(t.slope_y, by);
    if (t.level) continue;
    std::vector<double> lift(4, 0.0);
    for (const Turn& turn : t.turns)
      for (std::size_t f = 0; f < 4; ++f)
        if (feet[f].name == turn.name) {
          lift[f] = turn.lift_mm;
          CHECK(turn.turns == Approx(turn.lift_mm / 1.5));
        }
    double low = 1e9, high = -1e9;
    for (const TablePoint& p : points) {  // feet at the corners, bilinear between
      const double u = (p.x_mm + 430) / 860, v = (p.y_mm + 180) / 360;
      const double z = p.z_mm + (1 - u) * (1 - v) * lift[0] + u * (1 - v) * lift[1] + (1 - u) * v * lift[2] +
                       u * v * lift[3];
      low = std::min(low, z);
      high = std::max(high, z);
    }
    CHECK(high - low < 0.5);
    CHECK(t.left_mm == Approx(high - low).margin(0.06));
  }
  CHECK(covered >= 270);
  CHECK(covered <= 297);
}

TEST_CASE(
    "Level table: nine screws take out what no foot can, and a level table is left alone, and points on a "
    "line are refused") {
  RandomStream random(9, Purpose::kTest);
  std::vector<TablePoint> points;
  std::vector<Lifter> screws;
  for (const double y : {-150.0, 0.0, 150.0})
    for (const double x : {-350.0, 0.0, 350.0}) {
      points.push_back({x + random.uniform(-30, 30), y + random.uniform(-15, 15), random.uniform(-0.3, 0.3)});
      screws.push_back({"screw " + std::to_string(screws.size() + 1), x, y, 0.8});
    }
  const TableLevel t = level_by_screws(points, screws);
  CHECK_FALSE(t.level);
  CHECK(t.spread_mm > 0.3);
  CHECK(t.left_mm < 0.05);
  CHECK(t.turns.size() >= 6);
  for (const Turn& turn : t.turns) CHECK(std::abs(turn.lift_mm) < 1.0);
  for (TablePoint& p : points) p.z_mm *= 0.1;
  CHECK(level_by_screws(points, screws).level);
  CHECK(level_by_screws(points, screws).turns.empty());
  std::vector<TablePoint> line;
  for (int k = 0; k < 9; ++k) line.push_back({50.0 * k, 20.0 * k, 0.1 * k});
  CHECK_THROWS_AS(level_by_feet(line, screws), Unidentifiable);
  points.resize(8);
  CHECK_THROWS_WITH(level_by_screws(points, screws), Catch::Contains("8 points"));
}

TEST_CASE("Student's factor for 95 %") {
  CHECK(statistics::student_t_95(1) == Approx(12.7062));
  CHECK(statistics::student_t_95(10) == Approx(2.22814));
  CHECK(statistics::student_t_95(20) == Approx(2.08596));
  CHECK(statistics::student_t_95(1e6) == Approx(1.95997));
}

TEST_CASE(
    "A table is told about any place: plane and twist whatever the points' middle, and its bend where that "
    "is asked for") {
  for (const bool bent : {false, true}) {
    std::vector<TablePoint> points;
    const auto z = [&](double x, double y) {
      const double dx = x - 90.0, dy = y - 100.0;
      return 1.5 + 2e-3 * dx - 1e-3 * dy + 4e-6 * dx * dy + (bent ? 5e-6 * dx * dx - 2e-6 * dy * dy : 0.0);
    };
    for (const double y : {-230.0, -65.0, 100.0, 265.0, 430.0})
      for (const double x : {-35.0, 90.0, 215.0}) points.push_back({x, y, z(x, y)});
    for (const auto& [x, y] : {std::pair{300.0, 20.0}, {300.0, 180.0}, {30.0, 530.0}})
      points.push_back({x, y, z(x, y)});  // to one side
    const TableLevel t = table_about(points, 90.0, 100.0, bent);
    CHECK(t.height_mm.value == Approx(1.5).margin(1e-6));
    CHECK(t.slope_x.value == Approx(2e-3).margin(1e-8));
    CHECK(t.slope_y.value == Approx(-1e-3).margin(1e-8));
    CHECK(t.twist.value == Approx(4e-6).margin(1e-10));
    CHECK(t.bend_x.value == Approx(bent ? 5e-6 : 0.0).margin(1e-10));
    CHECK(t.bend_y.value == Approx(bent ? -2e-6 : 0.0).margin(1e-10));
    CHECK(t.twisted_mm(300.0, 20.0) == Approx(z(300.0, 20.0)).margin(1e-6));
    CHECK(t.turns.empty());
    for (const double off : t.off_mm) CHECK(std::abs(off) < 1e-6);
  }
}

namespace {

/// Requirement on intervals that are to be 95 %.
bool covers(int inside, int all) { return inside >= 0.92 * all && inside <= 0.97 * all; }

}  // namespace

TEST_CASE(
    "Valve latency: marks that scatter more the faster they were laid do not make its interval too narrow") {
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    RandomStream random(seed, Purpose::kTest, 5);
    std::vector<LaidMark> marks;
    for (int k = 0; k < 16; ++k) {
      const double v = (k % 2 ? -1.0 : 1.0) * (k % 4 < 2 ? 40.0 : 110.0);
      marks.push_back({0.0, 0.03 * v + 0.05 * random.normal() + 0.001 * v * random.normal(), v});
    }
    covered += inside(calibrate_valve_latency(marks).latency_s, 0.03);
  }
  CHECK(covers(covered, 1000));
}

TEST_CASE(
    "Flow curve: a flow that takes of its own pressure and a coil slower than thought leave the rows where "
    "they are") {
  int covered = 0, rows = 0;
  double bias = 0.0;
  constexpr int kCurves = 200;
  for (std::uint64_t seed = 1; seed <= kCurves; ++seed) {
    RandomStream random(seed, Purpose::kTest, 6);
    const double full = random.uniform(0.3, 0.45), recovery = random.uniform(0.0, 0.5), sag = 0.04;
    struct Frequency {
      double hz, drop;
      std::vector<double> share;
    };
    std::vector<Frequency> all;
    for (int k = 1; k <= 20; ++k) {
      Frequency f{25.0 * k, 0.0, std::vector<double>(6, 0.0)};
      const double gap = 500.0 / f.hz, longer = gap - std::floor(gap);
      double sum = 0.0;
      for (const auto& [ticks, share] :
           {std::pair{std::floor(gap), 1.0 - longer}, {std::floor(gap) + 1.0, longer}}) {
        f.share[std::size_t(std::min(ticks, 6.0)) - 1] += share;
        sum += share * full * (1.0 - recovery * std::exp(-(2.0 * ticks - 1.0) / 1.6));
      }
      f.drop = sum;
      for (int n = 0; n < 50; ++n) f.drop = sum * (1.0 - sag * f.hz * f.drop / 200.0);
      all.push_back(std::move(f));
    }
    double warmth[3] = {};  // of coils of 200 and 300 s, as the lab reckons, and of the true one
    const double tau_s[3] = {200.0, 300.0, 240.0};
    std::vector<FlowWeighing> w;
    for (int turn = 0; turn < 4; ++turn)
      for (std::size_t k = 0; k < all.size(); ++k) {
        std::swap(all[k], all[k + random.below(std::uint32_t(all.size() - k))]);
        const double seconds = std::clamp(1000.0 / all[k].hz, 12.0, 40.0);
        double mean[3];
        for (int c = 0; c < 3; ++c) {
          const double keep = std::exp(-seconds / tau_s[c]), above = warmth[c] - all[k].hz;
          mean[c] = 1e-3 * (all[k].hz + above * tau_s[c] / seconds * (1.0 - keep));
          warmth[c] = (all[k].hz + above * keep) * std::exp(-10.0 / tau_s[c]);
        }
        const double volume = all[k].hz * seconds * all[k].drop * (1.0 + 0.4 * mean[2]) *
                              (1.0 + 0.0424 / std::sqrt(seconds) * random.normal());
        w.push_back({all[k].hz, volume, seconds, all[k].share, mean[0], mean[1] - mean[0], 0.0});
      }
    const FlowCurveFit c = calibrate_flow_curve(w);
    for (const FlowCurveRow& r : c.rows) {
      const auto f =
          std::find_if(all.begin(), all.end(), [&](const Frequency& x) { return x.hz == r.frequency_hz; });
      const double truth = f->hz * f->drop * (1.0 + 0.4 * c.warmth);
      CHECK(r.flow_mm3_s.value == Approx(truth).epsilon(0.03));
      ++rows;
      covered += inside(r.flow_mm3_s, truth);
      bias += r.flow_mm3_s.value / truth - 1.0;
    }
  }
  CHECK(covers(covered, rows));
  CHECK(std::abs(bias / rows) < 0.0006);
}

TEST_CASE("A table's interval holds where near places share their unevenness, flat or bent by screws") {
  for (const bool bent : {false, true}) {
    int covered = 0;
    constexpr int kTables = 300;
    for (std::uint64_t seed = 1; seed <= kTables; ++seed) {
      RandomStream random(seed, Purpose::kTest, bent ? 8 : 7);
      struct Wave {
        double x, y, phase;
      };
      std::vector<Wave> waves;  // a normal field whose correlation is exp(-(d / 90 mm)^2)
      for (int n = 0; n < 60; ++n)
        waves.push_back({random.normal() * std::sqrt(2.0) / 90.0, random.normal() * std::sqrt(2.0) / 90.0,
                         random.uniform(0.0, 6.283185307)});
      double screw[9];
      for (double& s : screw) s = bent ? random.uniform(-0.4, 0.4) : 0.0;
      const auto plate = [&](double x, double y) {
        const double u = (x - 120.0) / 200.0, v = (y - 100.0) / 450.0;
        const double a[] = {0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)},
                     b[] = {0.5 * v * (v - 1.0), 1.0 - v * v, 0.5 * v * (v + 1.0)};
        double z = 0.2 + 1e-3 * x - 5e-4 * y;
        for (int s = 0; s < 9; ++s) z += screw[s] * a[s % 3] * b[s / 3];
        return z;
      };
      std::vector<TablePoint> points;
      const auto read = [&](double x, double y) {
        double rough = 0.0;
        for (const Wave& w : waves)
          rough += 0.05 * std::sqrt(2.0 / 60.0) * std::cos(w.x * x + w.y * y + w.phase);
        points.push_back({x, y, plate(x, y) + rough});
      };
      for (const double y : {-230.0, -65.0, 100.0, 265.0, 430.0})
        for (const double x : {-35.0, 90.0, 215.0}) read(x, y);
      for (const auto& [x, y] : {std::pair{30.0, -340.0},
                                 {160.0, -340.0},
                                 {310.0, -150.0},
                                 {310.0, 20.0},
                                 {310.0, 180.0},
                                 {310.0, 340.0},
                                 {30.0, 540.0},
                                 {150.0, 540.0}})
        read(x, y);
      const TableLevel t = table_about(points, 90.0, 100.0, bent);
      CHECK(std::abs(t.height_mm.value - plate(90.0, 100.0)) < (bent ? 0.1 : 0.07));
      covered += inside(t.height_mm, plate(90.0, 100.0)) +
                 inside(t.slope_x, (plate(91.0, 100.0) - plate(89.0, 100.0)) / 2.0) +
                 inside(t.slope_y, (plate(90.0, 101.0) - plate(90.0, 99.0)) / 2.0);
    }
    CHECK(covers(covered, 3 * kTables));
  }
}

}  // namespace firn::calibration
