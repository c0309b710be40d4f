#include "estimators/droplet/identification.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/deposition/height_change.h"
#include "core/grid/random.h"
#include "core/statistics/distributions.h"
#include "estimators/droplet/excitation.h"
#include "estimators/droplet/spacing.h"

using namespace firn;
using namespace firn::droplet;

namespace {

// One layer of the model (4) on bare ground.
PrintedLayer printed(const DropletPattern& drops, const deposition::DropletModel& model) {
  PrintedLayer l{drops, HeightMap(drops.spec, 0.0), HeightMap(drops.spec, 0.0),
                 std::vector<Use>(drops.size(), Use::kLearn)};
  deposition::HeightChange<1>(drops.spec, deposition::stencil_of(model), deposition::Border::kLose)
      .deposit(l.after, drops);
  return l;
}

void cross(DropletPattern& u, int i, int j) {
  u.at(i, j) = u.at(i + 1, j) = u.at(i - 1, j) = u.at(i, j + 1) = u.at(i, j - 1) = 1;
}

}  // namespace

TEST_CASE(
    "V-C: h1, h2, h3 come out of single droplets, crosses and corner pairs on bare ground, exactly, by (4)") {
  const deposition::DropletModel m{4.7e-3, 0.55e-3, 0.18e-3};
  DropletPattern u(GridSpec{60, 24, 0.25, 0.25, 0.0, 0.0});
  for (int n = 0; n < 2; ++n) {
    const int j = 5 + 12 * n;
    u.at(5, j) = 1;
    cross(u, 16, j);
    u.at(28, j) = u.at(29, j + 1) = 1;
    u.at(40, j) = u.at(39, j + 1) = 1;
    u.at(50, j) = u.at(51, j) = 1;  // no print of V-C
  }
  const IdentificationPrints p = find_identification_prints({printed(u, m)});
  CHECK(p.single.size() == 2);
  CHECK(p.cross.size() == 2);
  CHECK(p.pair.size() == 4);
  CHECK(p.complete());
  CHECK(p.h1.mean_mm == Approx(m.h1_mm));
  CHECK(p.h2.mean_mm == Approx(m.h2_mm));
  CHECK(p.h3.mean_mm == Approx(m.h3_mm));
  CHECK(p.side.mean_mm == Approx(m.h2_mm));
  CHECK(p.corner.mean_mm == Approx(m.h3_mm));
  CHECK(p.pair_rise.mean_mm[2][2] == Approx(m.h1_mm + m.h3_mm));
  CHECK(p.pair_rise.mean_mm[3][3] == Approx(m.h1_mm + m.h3_mm));  // turned: the second droplet at +x, +y
}

TEST_CASE("V-C by the model: neighbours that are cured after the centre add only sat(h2 - h1) of h2") {
  const deposition::DropletModel m;
  DropletPattern centre(GridSpec{9, 9, 0.25, 0.25, 0.0, 0.0}), sides(centre.spec), corners(centre.spec);
  centre.at(4, 4) = 1;
  cross(sides, 4, 4);
  sides.at(4, 4) = 0;
  HeightMap h(centre.spec, 0.0);
  deposition::HeightChange<1> change(centre.spec, deposition::stencil_of(m), deposition::Border::kLose);
  change.deposit(h, centre);
  change.deposit(h, sides);
  CHECK(h.at(4, 4) - m.h1_mm ==
        Approx(4.0 * m.h2_mm * deposition::sat(m.h1_mm + m.h2_mm, m.h2_mm - m.h1_mm)));
  CHECK(h.at(4, 4) - m.h1_mm < 0.25 * 4.0 * m.h2_mm);
}

TEST_CASE(
    "Sites on printed ground, near others, at unmeasured cells or at the edge are no identification prints") {
  const deposition::DropletModel m;
  const GridSpec g{40, 12, 0.25, 0.25, 0.0, 0.0};
  DropletPattern first(g), second(g);
  first.at(6, 6) = 1;
  first.at(1, 6) = 1;
  first.at(20, 6) = first.at(23, 6) = 1;  // three apart
  second.at(6, 6) = 1;                    // on the first layer's
  second.at(32, 6) = 1;
  PrintedLayer b = printed(second, m);
  CHECK(find_identification_prints({printed(first, m)}).single.size() == 1);
  CHECK(find_identification_prints({printed(first, m), b}).single.size() == 2);
  b.use[g.index(33, 7)] = Use::kNothing;
  CHECK(find_identification_prints({printed(first, m), b}).single.size() == 1);
  CHECK(find_identification_prints({}).single.empty());
}

TEST_CASE("Student's t and its interval: table values, and repeats that cover their mean 95 times of 100") {
  CHECK(statistics::student_t_95(3) == Approx(3.182).epsilon(0.01));
  CHECK(statistics::student_t_95(5) == Approx(2.571).epsilon(0.002));
  CHECK(statistics::student_t_95(10) == Approx(2.228).epsilon(0.001));
  CHECK(statistics::student_t_95(100) == Approx(1.984).epsilon(0.001));
  int covered = 0;
  for (std::uint32_t trial = 0; trial < 2000; ++trial) {
    std::vector<double> v;
    for (std::uint32_t n = 0; n < 8; ++n) v.push_back(1.0 + random_normal({7, Purpose::kTest, trial, 0, n}));
    const Repeats r = repeats_of(v);
    covered += std::abs(r.mean_mm - 1.0) <= r.half_width_mm;
  }
  CHECK(covered > 1870);
  CHECK(covered < 1930);
}

TEST_CASE(
    "Squares that rise alike are consistent, and domes and ribs are not, and the choice is the vertex "
    "between") {
  const GridSpec g{60, 60, 0.1, 0.1, 0.0, 0.0};
  const std::vector<Use> use(g.size(), Use::kLearn);
  const HeightMap bare(g, 0.0);
  std::vector<Square> squares;
  for (int row = 0; row < 3; ++row)
    for (int n = 2, i = 4; n <= 4; ++n, i += 18) squares.push_back({i, 4 + 18 * row, n, 2});
  const auto result = [&](double gamma, double dome, double rib) {
    HeightMap h(g, 0.0);
    for (const Square& s : squares)
      for (int y = 0; y <= 2 * (s.n - 1); ++y)
        for (int x = 0; x <= 2 * (s.n - 1); ++x)
          h.at(s.i + x, s.j + y) = 0.005 * (1.0 + dome * (s.n - 3) - rib * ((x + y) % 2)) + 1e-5 * s.j / 60.0;
    return evaluate_spacing(gamma, square_rises(bare, h, use, squares), 0.0);
  };
  const SpacingResult flat = result(0.6, 0.0, 0.0), dome = result(0.5, 0.1, 0.0), rib = result(0.7, 0.0, 0.2);
  CHECK(flat.inconsistency < 1e-2);
  CHECK(dome.between_sizes == Approx(0.1).epsilon(0.02));
  CHECK(dome.within < 1e-2);
  CHECK(rib.within == Approx(0.11).epsilon(0.1));
  CHECK(rib.between_sizes < 0.03);
  CHECK(rib.std_error > 0.0);
  const SpacingChoice c = choose_spacing({dome, flat, rib});
  CHECK(c.inside);
  CHECK(c.best == 1);
  CHECK(c.gamma > 0.55);
  CHECK(c.gamma < 0.65);
  CHECK_FALSE(choose_spacing({flat, result(0.7, 0.1, 0.0), result(0.8, 0.2, 0.0)}).inside);
  CHECK_THROWS_WITH(choose_spacing({flat, rib}), Catch::Contains("three"));
  CHECK_THROWS_WITH(evaluate_spacing(0.5, {}, 0.0), Catch::Contains("two sizes"));
}

TEST_CASE("Droplets alone tell what no map can make up for: full layers, and a row without corners") {
  const deposition::DropletModel m{1.2, 0.2, 0.05};  // mm: of any scale
  RandomStream random(5, Purpose::kInstance, 0, 0);
  DropletPattern half(GridSpec{20, 16, 1.0, 1.0, 0.0, 0.0}), full(half.spec, 1);
  for (auto& u : half.cells) u = random.uniform() < 0.5;
  DropletPattern row(GridSpec{20, 1, 1.0, 1.0, 0.0, 0.0});
  for (int i = 0; i < 20; i += 2) row.at(i, 0) = 1;
  CHECK(design_excitation({printed(half, m)}).excitation > 0.05);
  CHECK(unseen_constants(design_excitation({printed(half, m)})).empty());
  CHECK(design_excitation({printed(full, m)}).excitation < 1e-3);
  CHECK(unseen_constants(design_excitation({printed(row, m)})) == "h3");
  const Repeats even = layer_height_of_even_cells({printed(full, m), printed(row, m), printed(full, m)});
  CHECK(even.n == 2);
  CHECK(even.mean_mm == Approx(m.layer_height_mm()));
}
