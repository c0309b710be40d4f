#include "estimators/surface/path_readings.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/motion/planner.h"
#include "estimators/surface/surface_map.h"

namespace firn::surface {
namespace {

constexpr Point2 kOrigin{354.0, -46.0};

struct Bench {
  std::unique_ptr<motion::Arm> arm = motion::make_scara(motion::cobra600());
  motion::Tool laser = motion::cobra600_tools()[3];

  LaserFrame frame(double latency_s) const { return {*arm, laser, kOrigin, 100.0, latency_s}; }

  motion::PlanResult run(std::vector<Point2> points, double speed_mm_s, double z_mm) const {
    motion::PathInput in;
    in.points = points;
    in.origin = kOrigin;
    in.z_mm = 100.0 + z_mm;
    in.tool = laser;
    in.speed_limit.path_mm_s = speed_mm_s;
    motion::PlanResult r = motion::plan(in, *arm, motion::cobra600_limits());
    REQUIRE(r.ok());
    return r;
  }
};

/// Computes the position of the laser at time t of a planned path, in the part's frame: linear between the
/// emitted tool points.
Point2 place(const motion::PlanResult& r, double t_s) {
  const double ticks = std::clamp(t_s / r.trajectory.tick_s, 0.0, double(r.tool.size() - 1));
  const std::size_t i = std::min(std::size_t(ticks), r.tool.size() - 2);
  const double f = ticks - double(i);
  return {r.tool[i].x_mm + f * (r.tool[i + 1].x_mm - r.tool[i].x_mm),
          r.tool[i].y_mm + f * (r.tool[i + 1].y_mm - r.tool[i].y_mm)};
}

double bumpy(const Point2& p) { return 1.2 + 0.1 * std::sin(0.2 * p.x_mm) * std::cos(0.15 * p.y_mm); }

}  // namespace

TEST_CASE(
    "Readings land where the laser was, whatever the latency: a surface is found again from both "
    "directions") {
  const Bench b;
  for (const double latency : {0.0, 0.013, 0.05}) {
    std::vector<SurfacePoint> points;
    for (const bool back : {false, true}) {
      std::vector<Point2> line{{0, 0}, {40, 5}};
      if (back) std::swap(line[0], line[1]);
      const motion::PlanResult r = b.run(line, 125.0, 1.2);
      std::vector<float> z;
      for (int k = 0; k < int(r.trajectory.certificate.duration_s / 0.01) + 20; ++k)
        z.push_back(float(bumpy(place(r, latency + 0.01 * k)) - 1.2));
      const ReadingCounts n = add_readings(r.trajectory, b.frame(latency), 0.01, z, points);
      CHECK(n.taken > 20);
      CHECK(n.taken <= std::int64_t(r.trajectory.certificate.duration_s / 0.01) + 1);
      CHECK(n.invalid == 0);
      CHECK(n.spikes == 0);
    }
    for (const SurfacePoint& p : points) {
      CHECK(p.z_mm == Approx(bumpy({p.x_mm, p.y_mm})).margin(2e-4));
      CHECK(p.y_mm == Approx(p.x_mm / 8.0).margin(0.02));
    }
  }
}

TEST_CASE("A latency that is wrong by 2 ms moves readings by 0.25 mm at 125 mm/s, as 5.2.1 says") {
  const Bench b;
  const motion::PlanResult r = b.run({{0, 0}, {60, 0}}, 125.0, 0.0);
  std::vector<float> z(100, 0.0F);
  std::vector<SurfacePoint> right, late;
  add_readings(r.trajectory, b.frame(0.010), 0.01, z, right);
  add_readings(r.trajectory, b.frame(0.012), 0.01, z, late);
  double most = 0.0;
  for (std::size_t k = 0; k < std::min(right.size(), late.size()); ++k)
    most = std::max(most, std::abs(late[k].x_mm - right[k].x_mm));
  CHECK(most == Approx(0.25).margin(0.01));
}

TEST_CASE("Values that are missing and values off their neighbours are left out and counted") {
  const Bench b;
  const motion::PlanResult r = b.run({{0, 0}, {50, 0}}, 50.0, 0.0);
  std::vector<float> z(100);
  for (std::size_t k = 0; k < z.size(); ++k) z[k] = float(0.01 * std::sin(0.1 * double(k)));
  z[10] = z[11] = z[40] = float(kNotMeasured);
  z[25] = 0.8F;
  z[60] = -0.5F;
  std::vector<SurfacePoint> points;
  const ReadingCounts n = add_readings(r.trajectory, b.frame(0.0), 0.01, z, points);
  CHECK(n.invalid == 3);
  CHECK(n.spikes == 2);
  CHECK(std::int64_t(points.size()) == n.taken - 5);
  for (const SurfacePoint& p : points) CHECK(std::abs(p.z_mm) < 0.02);
  CHECK_THROWS_WITH(add_readings(r.trajectory, b.frame(0.0), 0.0, z, points), Catch::Contains("period"));
}

TEST_CASE("The noise of one reading comes from its neighbours, on slopes and bends too") {
  RandomStream random(5, Purpose::kTest);
  std::vector<SurfacePoint> p;
  for (int k = 0; k < 4000; ++k)
    p.push_back({0.5 * k, 0.0, 0.01 * k + 0.2 * std::sin(0.02 * k) + 0.02 * random.normal()});
  CHECK(noise_of_readings(p) == Approx(0.02).epsilon(0.06));
  CHECK(noise_of_readings(std::span(p).first(10)) == 0.0);
}

TEST_CASE(
    "The map of a noisy surface with drop-outs and outliers is within the noise, and cells without readings "
    "near are marked") {
  RandomStream random(6, Purpose::kTest);
  std::vector<SurfacePoint> p;
  for (int j = 0; j < 34; ++j)
    for (int i = 0; i < 130; ++i) {
      const double x = 0.5 * (j % 2 ? 129 - i : i), y = 1.5 * j;
      const double roll = random.uniform(), bad = random.uniform(-0.6, 0.6);
      p.push_back(
          {x, y,
           roll < 0.1 ? kNotMeasured : bumpy({x, y}) + 0.02 * random.normal() + (roll > 0.98 ? bad : 0.0)});
    }
  const GridSpec g{80, 51, 1.0, 1.0, 0.0, 0.0};
  Mask part(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < 75; ++i) part.at(i, j) = 1;
  const ScatterEstimate e = estimate_surface(g, part, p, {});
  double squares = 0.0, cells = 0.0;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      REQUIRE(std::isfinite(e.height.at(i, j)));
      const bool measured = e.quality.at(i, j) == std::uint8_t(CellQuality::kMeasured);
      CHECK(measured == (i <= 64 && j <= 49));  // x <= 64.5, y <= 49.5 were read
      const double off = e.height.at(i, j) - bumpy({g.x_mm(i), g.y_mm(j)});
      if (measured) {
        squares += off * off;
        cells += 1.0;
      }
    }
  CHECK(std::sqrt(squares / cells) < 0.012);
  CHECK(e.covered_fraction == Approx(cells / (75.0 * 51.0)));
  const ScatterEstimate raw = estimate_surface(g, part, p, {3.0, false});
  CHECK(raw.height != e.height);
  const ScatterEstimate none = estimate_surface(g, part, {}, {});
  CHECK(none.covered_fraction == 0.0);
  CHECK(std::isnan(none.height.at(0, 0)));
}

}  // namespace firn::surface
