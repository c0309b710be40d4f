#include "core/deposition/height_change.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/deposition/row_kernels.h"
#include "core/grid/random.h"
#include "tests/core/deposition/random_layers.h"

using namespace firn;
using namespace firn::deposition;
using namespace firn::test;

namespace {

constexpr double kH1 = 4.4e-3, kH2 = 0.6e-3, kH3 = 0.2e-3;
const DropletModel kLu{};

// Eqs. (3)-(5) as printed (with the errata): a gather over the nine terms of each cell, no shared code.
template <int R>
HeightMap as_printed(const HeightMap& h, const DropletPattern& u, int pass, const Stencil<R>& s,
                     Border border) {
  HeightMap out = h;
  const GridSpec& g = h.spec;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      double c1 = 0.0, c23 = 0.0;
      if (u.at(i, j) > pass) c1 = s.centre_mm;
      for (int dy = -R; dy <= R; ++dy)
        for (int dx = -R; dx <= R; ++dx) {
          if (dx == 0 && dy == 0) continue;
          const double w = s.at(dx, dy), a = s.centre_mm + w;
          const bool on = g.contains(i + dx, j + dy);
          const double hn = on ? h.at(i + dx, j + dy) : 0.0;
          if (u.at(i, j) > pass)
            c1 += w - w * (on ? sat(a, h.at(i, j) - hn) : border == Border::kLose ? 1.0 : 0.0);
          if (on && u.at(i + dx, j + dy) > pass) c23 += w * sat(a, hn - h.at(i, j));
        }
      out.at(i, j) += c1 + c23;
    }
  return out;
}

// One dimension: a single row whose model has no corners; flows up and down are lost, which a line does not
// have.
std::vector<double> line_after(int layers, int n, double h1, double h2) {
  const GridSpec g{n, 1};
  HeightMap h(g);
  HeightChange<1> model(g, stencil_of({h1, h2, 0.0}), Border::kLose);
  for (int k = 0; k < layers; ++k) model.deposit(h, DropletPattern(g, 1));
  return h.cells;
}

}  // namespace

TEST_CASE("Eq. (5): sat is 1 from 0 on, falls linearly to 0 at -a, and stays 0") {
  CHECK(sat(5.0, 0.0) == 1.0);
  CHECK(sat(5.0, 3.0) == 1.0);
  CHECK(sat(5.0, -1.0) == Approx(0.8).margin(1e-15));
  CHECK(sat(5.0, -5.0) == 0.0);
  CHECK(sat(5.0, -7.0) == 0.0);
}

TEST_CASE("Erratum (2)/(3): the first layer on a flat surface adds C1 + C2 + C3 of its own droplets") {
  const GridSpec g{9, 7};
  RandomStream random(11, Purpose::kTest);
  const DropletPattern u = some_drops(g, random, 1);
  HeightMap flat(g, 0.1), additive(g, 0.1);
  HeightChange<1> model(g, stencil_of(kLu), Border::kLose);
  model.deposit(flat, u);  // H_{k+1} from U_k and H_k, not U_{k+1}
  deposit_additive(additive, u, kLu);
  CHECK(worst(flat, additive) < 1e-15);
}

TEST_CASE(
    "Eq. (2): the additive baseline is h1, h2, h3 by class, multiplied by the count, whatever the heights") {
  const GridSpec g{5, 5};
  HeightMap h(g);
  h.at(3, 2) = 1.0;
  DropletPattern u(g);
  u.at(2, 2) = 3;
  const Ledger ledger = deposit_additive(h, u, kLu);
  CHECK(h.at(2, 2) == Approx(3 * kH1).epsilon(1e-14));
  CHECK(h.at(1, 2) == Approx(3 * kH2).epsilon(1e-14));
  CHECK(h.at(3, 2) - 1.0 == Approx(3 * kH2).epsilon(1e-12));
  CHECK(h.at(1, 1) == Approx(3 * kH3).epsilon(1e-14));
  CHECK(h.at(0, 0) == 0.0);
  CHECK(ledger.drops == 3);
  CHECK(ledger.lost_mm == 0.0);
  HeightMap corner(g);
  DropletPattern at_corner(g);
  at_corner.at(0, 0) = 1;
  CHECK(deposit_additive(corner, at_corner, kLu).lost_mm == Approx(2 * kH2 + 3 * kH3).epsilon(1e-14));
}

TEST_CASE(
    "Erratum (4): the fast step equals the printed nine-term sum on random surfaces, both borders, all grid "
    "shapes") {
  RandomStream random(21, Purpose::kTest);
  for (const GridSpec g : {GridSpec{1, 1}, GridSpec{1, 6}, GridSpec{7, 1}, GridSpec{2, 2}, GridSpec{3, 2},
                           GridSpec{13, 9}, GridSpec{40, 33}})
    for (const Border border : {Border::kLose, Border::kKeep})
      for (const double range : {0.0, 2e-3, 10e-3, 0.05}) {
        const HeightMap h = rough(g, random, range);
        const DropletPattern u = some_drops(g, random, 1);
        HeightChange<1> model(g, stencil_of(kLu), border);
        HeightMap got = h;
        model.deposit(got, u);
        CHECK(worst(got, as_printed(h, u, 0, stencil_of(kLu), border)) < 1e-16 * 64);
        const Stencil<2> wide{4.4e-3, {0.5e-3, 0.2e-3, 0.1e-3, 0.05e-3, 0.02e-3}};
        HeightChange<2> model2(g, wide, border);
        HeightMap got2 = h;
        model2.deposit(got2, u);
        CHECK(worst(got2, as_printed(h, u, 0, wide, border)) < 1e-16 * 64);
      }
}

TEST_CASE("Erratum III-C: heights of a printed line after 1, 2 and 4 layers") {
  const double h1 = 4.4, h2 = 0.6, r = h1 * h2 / (h1 + h2);
  const auto one = line_after(1, 12, h1, h2), two = line_after(2, 12, h1, h2),
             four = line_after(4, 12, h1, h2);
  CHECK(std::abs(one[0] - (h1 + h2)) < 1e-12);
  for (int i = 1; i < 11; ++i) CHECK(std::abs(one[std::size_t(i)] - (h1 + 2 * h2)) < 1e-12);
  CHECK(std::abs(two[0] - (2 * h1 + 3 * h2 - r)) < 1e-12);
  CHECK(std::abs(two[1] - (2 * h1 + 3 * h2 + r)) < 1e-12);
  for (int i = 2; i < 10; ++i) CHECK(std::abs(two[std::size_t(i)] - (2 * h1 + 4 * h2)) < 1e-12);
  CHECK(std::abs(two[0] - 10.072) < 1e-12);
  CHECK(std::abs(two[1] - 11.128) < 1e-12);
  const double printed[] = {20.368, 22.062, 22.371, 22.399, 22.4};
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(std::abs(four[i] - printed[i]) < 5.001e-4);
    CHECK(std::abs(four[i] - four[11 - i]) < 1e-12);
  }
  for (const auto& [layers, edge] :
       {std::pair{3, 3}, {5, 5}}) {  // after M layers M points shrink at each edge
    const auto h = line_after(layers, 16, h1, h2);
    CHECK(h[std::size_t(edge) - 1] < h[8] - 1e-12);
    CHECK(std::abs(h[std::size_t(edge)] - h[8]) < 1e-12);
  }
}

TEST_CASE(
    "Erratum border: under `lose` an edge droplet loses h2 + 2 h3, a corner droplet 2 h2 + 3 h3, an inner "
    "one nothing") {
  const GridSpec g{6, 5};
  const auto lost = [&](int i, int j, Border border) {
    HeightMap h(g, 0.2);
    DropletPattern u(g);
    u.at(i, j) = 1;
    HeightChange<1> model(g, stencil_of(kLu), border);
    return model.deposit(h, u).lost_mm;
  };
  CHECK(lost(2, 0, Border::kLose) == Approx(kH2 + 2 * kH3).epsilon(1e-14));
  CHECK(lost(5, 2, Border::kLose) == Approx(kH2 + 2 * kH3).epsilon(1e-14));
  CHECK(lost(0, 0, Border::kLose) == Approx(2 * kH2 + 3 * kH3).epsilon(1e-14));
  CHECK(lost(5, 4, Border::kLose) == Approx(2 * kH2 + 3 * kH3).epsilon(1e-14));
  CHECK(lost(2, 2, Border::kLose) == 0.0);
  CHECK(lost(0, 0, Border::kKeep) == 0.0);
}

TEST_CASE(
    "What is deposited is on the grid or in the ledger, to 1e-12, per step and summed, radius 1 and 2") {
  RandomStream random(31, Purpose::kTest);
  const Stencil<2> wide{4.4e-3, {0.5e-3, 0.2e-3, 0.1e-3, 0.05e-3, 0.02e-3}};
  const auto conserves = [&](auto& model, int trial) {
    HeightMap h = rough(model.grid(), random, 0.05);
    double deposited = 0.0;
    const double start = sum(h), before_lost = model.total().lost_mm;
    for (int layer = 0; layer < 4; ++layer) {
      const double before = sum(h);
      const DropletPattern u = some_drops(model.grid(), random, std::uint32_t(1 + trial % 3));
      const Ledger step = model.deposit(h, u);
      CHECK(step.drops == u.total());
      const double asked = double(u.total()) * model.stencil().drop_height_mm();
      CHECK(step.deposited_mm == Approx(asked).epsilon(1e-12));
      CHECK(std::abs(sum(h) - before + step.lost_mm - asked) <= 1e-12 * (asked + sum(h)));
      if (model.border() == Border::kKeep) CHECK(step.lost_mm == 0.0);
      deposited += asked;
    }
    CHECK(std::abs(sum(h) - start + model.total().lost_mm - before_lost - deposited) <=
          1e-12 * (deposited + sum(h)));
  };
  for (int trial = 0; trial < 30; ++trial) {
    const GridSpec g{std::int32_t(1 + random.below(25)), std::int32_t(1 + random.below(25))};
    const Border border = trial % 2 ? Border::kLose : Border::kKeep;
    HeightChange<1> narrow_model(g, stencil_of(kLu), border);
    HeightChange<2> wide_model(g, wide, border);
    conserves(narrow_model, trial);
    conserves(wide_model, trial);
  }
}

TEST_CASE("The height change is linear in the droplets for a given surface") {
  RandomStream random(41, Purpose::kTest);
  const GridSpec g{17, 12};
  HeightChange<1> model(g, stencil_of(kLu), Border::kLose);
  for (int trial = 0; trial < 20; ++trial) {
    const HeightMap h = rough(g, random, 0.02);
    DropletPattern a(g), b(g), both(g);
    for (std::size_t c = 0; c < g.size(); ++c) {
      const auto which = random.below(3);
      a.cells[c] = which == 1;
      b.cells[c] = which == 2;
      both.cells[c] = which != 0;
    }
    HeightMap ha = h, hb = h, hab = h;
    model.deposit(ha, a);
    model.deposit(hb, b);
    model.deposit(hab, both);
    for (std::size_t c = 0; c < g.size(); ++c)
      CHECK(std::abs((ha.cells[c] - h.cells[c]) + (hb.cells[c] - h.cells[c]) - (hab.cells[c] - h.cells[c])) <
            1e-16);
  }
}

TEST_CASE("A cell with n droplets gets them in n passes, each on the height that the last one left") {
  RandomStream random(51, Purpose::kTest);
  const GridSpec g{11, 8};
  const HeightMap h = rough(g, random, 0.01);
  const DropletPattern u = some_drops(g, random, 3);
  HeightMap got = h, by_hand = h;
  HeightChange<1> model(g, stencil_of(kLu), Border::kLose);
  model.deposit(got, u);
  for (int pass = 0; pass < 3; ++pass) by_hand = as_printed(by_hand, u, pass, stencil_of(kLu), Border::kLose);
  CHECK(worst(got, by_hand) < 1e-15);
}

TEST_CASE("The model commutes with mirrors and quarter turns") {
  RandomStream random(61, Purpose::kTest);
  const GridSpec g{9, 9};
  const HeightMap h = rough(g, random, 0.01);
  const DropletPattern u = some_drops(g, random, 2);
  const auto turned = [](const auto& from) {
    auto to = from;
    for (int j = 0; j < 9; ++j)
      for (int i = 0; i < 9; ++i) to.at(8 - j, i) = from.at(i, j);
    return to;
  };
  HeightChange<1> model(g, stencil_of(kLu), Border::kLose);
  HeightMap a = h, b = turned(h);
  model.deposit(a, u);
  model.deposit(b, turned(u));
  CHECK(worst(turned(a), b) < 1e-15);
}

TEST_CASE("Droplets with their own weights: equal ones give the uniform result, different ones conserve") {
  RandomStream random(71, Purpose::kTest);
  const GridSpec g{14, 10};
  for (const Border border : {Border::kLose, Border::kKeep}) {
    const HeightMap h = rough(g, random, 0.01);
    const DropletPattern u = some_drops(g, random, 1);
    HeightChange<1> model(g, stencil_of(kLu), border);
    std::vector<Stencil<1>> same(g.size(), stencil_of(kLu)), varied = same;
    double asked = 0.0;
    for (std::size_t c = 0; c < g.size(); ++c) {
      const double f = 1.0 + 0.4 * random.uniform();
      varied[c] = stencil_of({f * kH1, f * kH2, f * kH3});
      if (u.cells[c]) asked += varied[c].drop_height_mm();
    }
    HeightMap uniform = h, by_cell = h, scattered = h;
    model.step(uniform.data(), u.data(), 0);
    model.step(by_cell.data(), u.data(), 0, same);
    CHECK(worst(uniform, by_cell) < 1e-16);
    const Ledger ledger = model.step(scattered.data(), u.data(), 0, varied);
    CHECK(ledger.deposited_mm == Approx(asked).epsilon(1e-12));
    CHECK(sum(scattered) - sum(h) + ledger.lost_mm == Approx(asked).epsilon(1e-11));
  }
}

TEST_CASE("The vectorised rows give the same bytes as the portable ones") {
  RandomStream random(81, Purpose::kTest);
  for (std::size_t n : {1u, 2u, 3u, 5u, 8u, 31u, 100u}) {
    std::vector<double> h(n + 1), u(n + 1), v(n + 1), flow(n), a(n + 1), b(n + 1), flow2(n);
    for (std::size_t i = 0; i <= n; ++i) {
      h[i] = random.uniform(0.0, 0.01);
      a[i] = b[i] = random.uniform();
    }
    const double slope = kH2 / (kH1 + kH2);
    std::vector<std::uint8_t> drops(n + 1);
    for (auto& d : drops) d = std::uint8_t(random.below(4));
    const RowKernels &wide = row_kernels(), &plain = portable_row_kernels();
    CHECK(wide.load(drops.data(), 1, u.data(), n + 1) == plain.load(drops.data(), 1, v.data(), n + 1));
    CHECK(u == v);
    wide.flow(h.data(), h.data() + 1, u.data(), u.data() + 1, kH2, slope, flow.data(), a.data(), a.data() + 1,
              n);
    plain.flow(h.data(), h.data() + 1, u.data(), u.data() + 1, kH2, slope, flow2.data(), b.data(),
               b.data() + 1, n);
    CHECK(flow == flow2);
    CHECK(a == b);
    std::vector<double> far_a(n, 0.5), far_b(n, 0.5);  // rows that do not overlap
    wide.flow(h.data(), h.data() + 1, u.data(), u.data() + 1, kH2, slope, flow.data(), a.data(), far_a.data(),
              n);
    plain.flow(h.data(), h.data() + 1, u.data(), u.data() + 1, kH2, slope, flow.data(), b.data(),
               far_b.data(), n);
    CHECK(a == b);
    CHECK(far_a == far_b);
    std::vector<double> g = h;
    wide.settle(g.data(), u.data(), 7.6e-3, a.data(), n + 1);
    plain.settle(h.data(), u.data(), 7.6e-3, b.data(), n + 1);
    CHECK(g == h);
    CHECK(a == b);
  }
}

TEST_CASE(
    "A height that is not finite, a wrong size and impossible constants are refused before anything "
    "changes") {
  const GridSpec g{4, 3};
  HeightChange<1> model(g, stencil_of(kLu), Border::kLose);
  HeightMap h(g, 0.5);
  h.at(2, 1) = kNotMeasured;
  const HeightMap before = h;
  CHECK_THROWS_WITH(model.deposit(h, DropletPattern(g, 1)), Catch::Contains("cell (2, 1)"));
  CHECK(h.at(0, 0) == before.at(0, 0));
  HeightMap small(GridSpec{3, 3});
  CHECK_THROWS_WITH(model.deposit(small, DropletPattern(g, 1)), Catch::Contains("9 cells"));
  CHECK_THROWS_WITH(check(DropletModel{0.0, 0.1, 0.1}), Catch::Contains("h1"));
  CHECK_THROWS_WITH(check(DropletModel{1.0, -0.1, 0.1}), Catch::Contains("h2"));
  CHECK_THROWS_WITH(check(DropletModel{1.0, 0.1, std::nan("")}), Catch::Contains("h3"));
  CHECK_THROWS_AS(HeightChange<1>(GridSpec{0, 3}, stencil_of(kLu), Border::kLose), std::invalid_argument);
}
