#include "estimators/registration/nozzle_offset.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/statistics/distributions.h"

namespace firn::registration {
namespace {

// Paraboloid marks on noisy ground; B's are off by (dx, dy), both by a common shift.
struct Scene {
  GridSpec grid{112, 112, 0.1, 0.1, 3.0, -2.0};
  std::vector<MarkSite> marks;
  HeightMap before{grid, 0.0}, after{grid, 0.0};

  Scene(std::uint64_t seed, double dx_mm, double dy_mm, double common_mm, double noise_mm,
        double scatter_mm) {
    RandomStream random(seed, Purpose::kTest);
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column)
        marks.push_back({grid.x_mm(8 + 16 * column), grid.y_mm(8 + 16 * row),
                         (row + column) % 2 ? Material::kB : Material::kA});
    for (std::size_t c = 0; c < grid.size(); ++c) {
      before.cells[c] = 0.02 + noise_mm * random.normal();
      after.cells[c] = 0.02 + noise_mm * random.normal();
    }
    for (const MarkSite& m : marks) {
      const bool b = m.material == Material::kB;
      const double x = m.x_mm + common_mm + (b ? dx_mm : 0.0) + scatter_mm * random.normal();
      const double y = m.y_mm + common_mm + (b ? dy_mm : 0.0) + scatter_mm * random.normal();
      const double size = 0.02 * (1.0 + 0.1 * random.normal());
      for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
          const double u = (grid.x_mm(i) - x) / 0.4, v = (grid.y_mm(j) - y) / 0.4;
          after.at(i, j) += size * std::max(0.0, 1.0 - u * u - v * v);
        }
    }
  }
};

TEST_CASE("Student's t for 95 % intervals agrees with the table") {
  const std::pair<double, double> table[] = {{3, 3.182},  {4, 2.776},  {5, 2.571},
                                             {10, 2.228}, {30, 2.042}, {1000, 1.962}};
  for (const auto& [freedom, t] : table)
    CHECK(firn::statistics::student_t_95(freedom) == Approx(t).epsilon(0.001));
}

TEST_CASE(
    "the offset of noise-free marks is found to three micrometres, wherever they lie between the cells") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const double dx = 0.8 * (random.uniform() - 0.5), dy = 0.8 * (random.uniform() - 0.5),
                 common = 0.2 * (random.uniform() - 0.5);
    CAPTURE(seed, dx, dy, common);
    const Scene s(seed, dx, dy, common, 0.0, 0.0);
    const NozzleOffset o = measure_offset(s.before, s.after, s.marks);
    CHECK(std::abs(o.x.value_mm - dx) < 0.003);
    CHECK(std::abs(o.y.value_mm - dy) < 0.003);
    CHECK(o.marks_a == 18);
    CHECK(o.marks_b == 18);
    CHECK(o.skipped == 0);
  }
}

TEST_CASE("the 95 % interval of the offset covers 90 to 98 % of 300 noisy prints") {
  int covered = 0, n = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const Scene s(seed, 0.083, -0.041, 0.02, 0.0005, 0.005);
    const NozzleOffset o = measure_offset(s.before, s.after, s.marks);
    covered += std::abs(o.x.value_mm - 0.083) <= o.x.ci95_half_width_mm;
    covered += std::abs(o.y.value_mm + 0.041) <= o.y.ci95_half_width_mm;
    n += 2;
    CHECK(o.x.sigma_mm < 0.006);
  }
  CHECK(covered >= int(0.90 * n));
  CHECK(covered <= int(0.98 * n));
}

TEST_CASE("a mark that was not printed is skipped, not averaged in") {
  Scene s(4, 0.05, 0.02, 0.0, 0.0, 0.0);
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 16; ++i) s.after.at(i, j) = s.before.at(i, j);
  const NozzleOffset o = measure_offset(s.before, s.after, s.marks);
  CHECK(o.skipped == 1);
  CHECK(o.marks_a == 17);
  CHECK(std::abs(o.x.value_mm - 0.05) < 0.002);
}

TEST_CASE("a common tilt of the map moves both nozzles' marks alike") {
  Scene s(5, 0.05, 0.02, 0.0, 0.0, 0.0);
  for (int j = 0; j < s.grid.ny; ++j)
    for (int i = 0; i < s.grid.nx; ++i) s.after.at(i, j) += 0.0001 * s.grid.x_mm(i);
  const NozzleOffset o = measure_offset(s.before, s.after, s.marks);
  CHECK(std::abs(o.x.value_mm - 0.05) < 0.003);
}

TEST_CASE("a registration that cannot be read is refused by name") {
  const Scene none(6, 0.0, 0.0, 0.0, 0.0, 0.0);
  CHECK_THROWS_WITH(measure_offset(none.before, none.before, none.marks), Catch::Contains("not within"));
  const Scene far(7, 0.75, 0.0, 0.0, 0.0, 0.0);
  CHECK_THROWS_WITH(measure_offset(far.before, far.after, far.marks), Catch::Contains("nozzle B"));
  CHECK_THROWS_WITH(measure_offset(far.before, HeightMap(GridSpec{3, 3}, 0.0), far.marks),
                    Catch::Contains("different grids"));
  auto few = far.marks;
  few.resize(5);
  CHECK_THROWS_WITH(measure_offset(far.before, far.after, few), Catch::Contains("four marks"));
}

}  // namespace
}  // namespace firn::registration
