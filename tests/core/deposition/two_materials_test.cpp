#include "core/deposition/two_materials.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "tests/core/deposition/random_layers.h"

using namespace firn;
using namespace firn::deposition;
using namespace firn::test;

namespace {

const TwoInks kInks{{4.4e-3, 0.6e-3, 0.2e-3}, {3.0e-3, 0.9e-3, 0.4e-3}};

MaterialMap some_inks(const GridSpec& g, RandomStream& random) {
  MaterialMap m(g);
  for (auto& v : m.cells) v = std::uint8_t(1 + random.below(2));
  return m;
}

// Eq. (7) with the errata, term by term as printed: a gather at cell (i, j), off-grid ground taken as the
// border says. Shares nothing with the code under test but sat().
struct Oracle {
  const HeightMap& h;
  const DropletPattern& u;
  const MaterialMap& m;
  TwoInks inks;
  Border border;
  int pass = 0;

  bool on(int i, int j) const { return h.spec.contains(i, j); }
  double drop(int i, int j) const { return on(i, j) && u.at(i, j) > pass ? 1.0 : 0.0; }
  double c(int i, int j, int which) const {  // h1|i,j,k .. h3|i,j,k
    const DropletModel& d = Material(m.at(i, j)) == Material::kB ? inks.b : inks.a;
    return which == 1 ? d.h1_mm : which == 2 ? d.h2_mm : d.h3_mm;
  }
  double to_neighbour(int i, int j, int ni, int nj, int which) const {
    const double a = c(i, j, 1) + c(i, j, which);
    if (!on(ni, nj)) return border == Border::kLose ? 1.0 : 0.0;
    return sat(a, h.at(i, j) - h.at(ni, nj));
  }
  double from_neighbour(int i, int j, int ni, int nj, int which) const {
    if (drop(ni, nj) == 0.0) return 0.0;
    return c(ni, nj, which) * sat(c(ni, nj, 1) + c(ni, nj, which), h.at(ni, nj) - h.at(i, j));
  }
  double c1(int i, int j) const {
    if (drop(i, j) == 0.0) return 0.0;
    double s = c(i, j, 1) + 4.0 * c(i, j, 2) + 4.0 * c(i, j, 3);
    s -= c(i, j, 2) * (to_neighbour(i, j, i + 1, j, 2) + to_neighbour(i, j, i - 1, j, 2) +
                       to_neighbour(i, j, i, j + 1, 2) + to_neighbour(i, j, i, j - 1, 2));
    s -= c(i, j, 3) * (to_neighbour(i, j, i + 1, j + 1, 3) + to_neighbour(i, j, i + 1, j - 1, 3) +
                       to_neighbour(i, j, i - 1, j + 1, 3) + to_neighbour(i, j, i - 1, j - 1, 3));
    return s;
  }
  double c2(int i, int j) const {
    return from_neighbour(i, j, i + 1, j, 2) + from_neighbour(i, j, i - 1, j, 2) +
           from_neighbour(i, j, i, j + 1, 2) + from_neighbour(i, j, i, j - 1, 2);
  }
  double c3(int i, int j) const {
    return from_neighbour(i, j, i + 1, j + 1, 3) + from_neighbour(i, j, i + 1, j - 1, 3) +
           from_neighbour(i, j, i - 1, j + 1, 3) + from_neighbour(i, j, i - 1, j - 1, 3);
  }
  HeightMap after() const {
    HeightMap out = h;
    for (int j = 0; j < h.spec.ny; ++j)
      for (int i = 0; i < h.spec.nx; ++i) out.at(i, j) += c1(i, j) + c2(i, j) + c3(i, j);
    return out;
  }
};

// One droplet of `ink` in the middle of 3 x 3 cells, all 10 um high but one; returns the rise of each cell.
struct Nine {
  HeightMap rise;
  Nine(Material ink, int i, int j, double other_mm, Material around = Material::kA) {
    const GridSpec g{3, 3};
    HeightMap h(g, 10e-3);
    h.at(i, j) = other_mm;
    DropletPattern u(g);
    u.at(1, 1) = 1;
    MaterialMap m(g, std::uint8_t(around));
    m.set(4, ink);
    HeightMap after = h;
    TwoMaterialChange(g, kInks, Border::kKeep).deposit(after, u, m);
    rise = after;
    for (std::size_t c = 0; c < 9; ++c) rise.cells[c] -= h.cells[c];
  }
};

}  // namespace

TEST_CASE("Eq. (7), Erratum (7): the step equals the corrected nine-term sum on random surfaces and inks") {
  RandomStream random(101, Purpose::kTest);
  for (const GridSpec g :
       {GridSpec{1, 1}, GridSpec{1, 6}, GridSpec{7, 1}, GridSpec{2, 2}, GridSpec{13, 9}, GridSpec{40, 33}})
    for (const Border border : {Border::kLose, Border::kKeep})
      for (const double range : {0.0, 2e-3, 10e-3, 0.05}) {
        const HeightMap h = rough(g, random, range);
        const DropletPattern u = some_drops(g, random, 2);
        const MaterialMap m = some_inks(g, random);
        HeightMap expected = h;
        for (int pass = 0; pass < u.passes(); ++pass)
          expected = Oracle{HeightMap(expected), u, m, kInks, border, pass}.after();
        HeightMap got = h;
        TwoMaterialChange(g, kInks, border).deposit(got, u, m);
        CHECK(worst(got, expected) < 1e-16 * 64);
      }
}

TEST_CASE("Erratum (6): on flat ground (6) is the new height, the old one plus both inks' shares") {
  RandomStream random(102, Purpose::kTest);
  const GridSpec g{12, 9};
  const DropletPattern u = some_drops(g, random, 1);
  const MaterialMap m = some_inks(g, random);
  HeightMap printed(g, 0.125), step(g, 0.125);
  deposit_additive(printed, u, m, kInks);
  TwoMaterialChange(g, kInks, Border::kLose).deposit(step, u, m);
  CHECK(worst(printed, step) < 1e-16 * 64);
  DropletPattern one(g);
  one.at(4, 4) = 1;
  MaterialMap b(g, std::uint8_t(Material::kB));
  HeightMap h(g, 0.125);
  deposit_additive(h, one, b, kInks);  // were (6) the change, the old height would count twice or not at all
  CHECK(h.at(4, 4) == Approx(0.125 + 3.0e-3).epsilon(1e-14));
  CHECK(h.at(5, 4) == Approx(0.125 + 0.9e-3).epsilon(1e-14));
  CHECK(h.at(5, 5) == Approx(0.125 + 0.4e-3).epsilon(1e-14));
  CHECK(h.at(7, 4) == 0.125);
}

TEST_CASE("Erratum (7), C1: the first corner's threshold is (h1 + h3) of the droplet's own ink") {
  // A support droplet beside a first corner 1.7 um higher: g3 sat_{g1+g3}(-1.7) = 0.4 (1 - 1.7 / 3.4); with
  // the object's h1 in the threshold, as printed, it would be 0.4 (1 - 1.7 / 4.8).
  const Nine n(Material::kB, 2, 2, 11.7e-3);
  CHECK(n.rise.at(2, 2) == Approx(0.2e-3).epsilon(1e-9));
  CHECK(n.rise.at(2, 2) != Approx(0.4e-3 * (1.0 - 1.7 / 4.8)).epsilon(1e-3));
  CHECK(n.rise.at(1, 1) == Approx(3.0e-3 + 0.2e-3).epsilon(1e-9));
}

TEST_CASE("Erratum (7), C1: the last corner compares the droplet's cell with cell (i - 1, j - 1)") {
  for (const Material ink : {Material::kA, Material::kB}) {
    const DropletModel& d = kInks.of(ink);
    const Nine high(ink, 0, 0, 60e-3), low(ink, 0, 0, 0.0), level(ink, 0, 0, 10e-3);
    CHECK(high.rise.at(0, 0) == 0.0);  // refuses its share, which stays in the middle
    CHECK(high.rise.at(1, 1) == Approx(d.h1_mm + d.h3_mm).epsilon(1e-12));
    CHECK(low.rise.at(0, 0) == Approx(d.h3_mm).epsilon(1e-12));
    CHECK(low.rise.at(1, 1) == Approx(level.rise.at(1, 1)).epsilon(1e-12));
  }
}

TEST_CASE(
    "Erratum (7), C2: a side's threshold is (h1 + h2) of the ink that flows in, not a factor outside sat") {
  for (const auto& [i, j] : {std::pair{2, 1}, {0, 1}, {1, 2}, {1, 0}}) {
    const Nine of_b(Material::kB, i, j, 12e-3, Material::kA), of_a(Material::kA, i, j, 12e-3, Material::kB);
    CHECK(of_b.rise.at(i, j) == Approx(0.9e-3 * (1.0 - 2.0 / 3.9)).epsilon(1e-9));
    CHECK(of_a.rise.at(i, j) == Approx(0.6e-3 * (1.0 - 2.0 / 5.0)).epsilon(1e-9));
  }
}

TEST_CASE("Erratum (7), C2: the third side compares H(i, j + 1) - H(i, j), a difference and no product") {
  // Seen from cell (1, 0) its droplet neighbour is (1, 1) = (i, j + 1), with a minus between the heights.
  const Nine higher(Material::kA, 1, 0, 12.5e-3), lower(Material::kA, 1, 0, 2.5e-3);
  CHECK(higher.rise.at(1, 0) == Approx(0.6e-3 * 0.5).epsilon(1e-9));
  CHECK(lower.rise.at(1, 0) == Approx(0.6e-3).epsilon(1e-12));
}

TEST_CASE("Two materials with the same constants are Eq. (4), to the last bit of each height but rounding") {
  RandomStream random(103, Purpose::kTest);
  const GridSpec g{23, 17};
  for (const Border border : {Border::kLose, Border::kKeep}) {
    const HeightMap h = rough(g, random, 0.01);
    const DropletPattern u = some_drops(g, random, 2);
    HeightMap two = h, one = h;
    const Ledger a = TwoMaterialChange(g, {{}, {}}, border).deposit(two, u, some_inks(g, random));
    HeightChange<1> model(g, stencil_of(DropletModel{}), border);
    const Ledger b = model.deposit(one, u);
    CHECK(worst(two, one) < 1e-17 * 8);
    CHECK(a.drops == b.drops);
    CHECK(a.deposited_mm == Approx(b.deposited_mm).epsilon(1e-13));
    CHECK(a.lost_mm == Approx(b.lost_mm).epsilon(1e-13));
  }
}

TEST_CASE(
    "Two materials: every droplet's height is on the grid or in the ledger, and nothing is lost inside") {
  RandomStream random(104, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    const GridSpec g{std::int32_t(3 + random.below(20)), std::int32_t(3 + random.below(20))};
    const HeightMap h = rough(g, random, 0.03);
    DropletPattern u = some_drops(g, random, 3);
    const MaterialMap m = some_inks(g, random);
    double asked = 0.0;
    for (std::size_t c = 0; c < g.size(); ++c) asked += u.cells[c] * kInks.of(m.of(c)).layer_height_mm();
    HeightMap after = h;
    const Ledger l = TwoMaterialChange(g, kInks, Border::kLose).deposit(after, u, m);
    CHECK(std::abs(sum(after) - sum(h) + l.lost_mm - asked) < 1e-12 * (1.0 + asked));
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i)
        if (i == 0 || j == 0 || i == g.nx - 1 || j == g.ny - 1) u.at(i, j) = 0;
    after = h;
    CHECK(TwoMaterialChange(g, kInks, Border::kLose).deposit(after, u, m).lost_mm == 0.0);
  }
}

TEST_CASE("The columns hold all of the rise, each ink what its own droplets brought") {
  RandomStream random(105, Purpose::kTest);
  const GridSpec g{15, 11};
  HeightMap h(g);
  MaterialColumns columns(g);
  TwoMaterialChange model(g, kInks, Border::kKeep);
  double asked[2] = {0.0, 0.0};
  for (int layer = 0; layer < 12; ++layer) {
    const DropletPattern u = some_drops(g, random, 2);
    const MaterialMap m = some_inks(g, random);
    for (std::size_t c = 0; c < g.size(); ++c)
      asked[m.of(c) == Material::kB] += u.cells[c] * kInks.of(m.of(c)).layer_height_mm();
    model.deposit(h, u, m, columns);
  }
  double found[2] = {0.0, 0.0};
  for (std::size_t c = 0; c < g.size(); ++c) {
    CHECK(std::abs(columns.top_mm(c) - h.cells[c]) < 1e-10);
    double below = 0.0;
    for (const MaterialSegment& s : columns.column(c)) {
      CHECK(s.top_mm > below);
      found[s.material == Material::kB] += s.top_mm - below;
      CHECK(columns.at(c, 0.5 * (below + s.top_mm)) == s.material);
      below = s.top_mm;
    }
  }
  CHECK(found[0] == Approx(asked[0]).epsilon(1e-9));
  CHECK(found[1] == Approx(asked[1]).epsilon(1e-9));
}

TEST_CASE("Two materials refuse sizes, inks and heights that cannot be, before anything is changed") {
  const GridSpec g{4, 3};
  TwoMaterialChange model(g, kInks, Border::kLose);
  HeightMap h(g);
  const DropletPattern u(g, 1);
  MaterialMap m(g, 1);
  CHECK_THROWS_WITH(model.deposit(h, u, MaterialMap(GridSpec{3, 3}, 1)), Catch::Contains("differ in size"));
  m.set(7, Material::kNone);
  CHECK_THROWS_WITH(model.deposit(h, u, m), Catch::Contains("cell (3, 1)"));
  m.cells[7] = 3;
  CHECK_THROWS_WITH(model.deposit(h, u, m), Catch::Contains("neither A (1) nor B (2)"));
  m.cells[7] = 2;
  h.cells[5] = kNotMeasured;
  CHECK_THROWS_WITH(model.deposit(h, u, m), Catch::Contains("cell (1, 1)"));
  CHECK_THROWS_WITH(TwoMaterialChange(g, {{}, {0.0, 0.0, 0.0}}, Border::kLose), Catch::Contains("h1"));
}
