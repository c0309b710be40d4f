// The least overspill under Lu's model: closed forms, published figures, and every pattern of tiny parts.
#include "studies/edge/edge_bound.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/outline.h"
#include "tests/support/skip.h"

using namespace firn;

namespace {

constexpr deposition::DropletModel kTable1{};
constexpr double kPitch_mm = 0.263256;

struct Part {
  HeightMap target;
  Mask mask;
  Part(int side, double height_mm, const std::function<bool(int, int)>& in)
      : target({side, side, kPitch_mm, kPitch_mm}, 0.0), mask(target.spec) {
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i)
        if (in(i, j)) {
          mask.at(i, j) = 1;
          target.at(i, j) = height_mm;
        }
  }
  double bound(double mean_abs_mm) const {
    return edge_bound(target, mask, kTable1, deposition::Border::kLose, mean_abs_mm);
  }
};

bool no_solver() {
  if (has_edge_solver()) return false;
  test::skip("cbc", "cbc is not installed (Debian: coinor-cbc)");
  return true;
}

Part cylinder() {
  return {40, 0.4, [](int i, int j) { return std::hypot(i - 19.5, j - 19.5) * kPitch_mm <= 5.0; }};
}

Part square(int cells) {
  return {cells + 4, 0.4, [=](int i, int j) { return std::min(i, j) >= 2 && std::max(i, j) < cells + 2; }};
}

}  // namespace

TEST_CASE("One cell gives its eight neighbours 4 (h2 + h3) of every h1") {
  if (no_solver()) return;
  CHECK(square(1).bound(0.0) == Approx(4 * (kTable1.h2_mm + kTable1.h3_mm) / kTable1.h1_mm).epsilon(1e-9));
}

TEST_CASE("With an error of e allowed, one cell is printed lower by e") {
  if (no_solver()) return;
  const double whole = square(1).bound(0.0);
  CHECK(square(1).bound(0.1) == Approx(whole * 0.75).epsilon(1e-9));
}

TEST_CASE("Of two cells one may give all that it can to the other, and the bound is theirs by hand") {
  if (no_solver()) return;
  const Part pair(6, 0.4, [](int i, int j) { return j == 2 && (i == 2 || i == 3); });
  // Alike by symmetry: each keeps h1 + h2 of its n droplets, whatever it gives the other and gets back.
  const double lost = 3 * kTable1.h2_mm + 4 * kTable1.h3_mm;
  CHECK(pair.bound(0.0) == Approx(lost / (kTable1.h1_mm + kTable1.h2_mm)).epsilon(1e-9));
}

TEST_CASE("The README's cylinder cannot spill less than 1.52 %, and 1.45 % with a mean error of 1 um") {
  if (no_solver()) return;
  const Part part = cylinder();
  REQUIRE(part.mask.count() == 1124);
  const double um = 1e-3;
  CHECK(100 * part.bound(0.0) == Approx(1.517).margin(0.0005));
  CHECK(100 * part.bound(0.5 * um) == Approx(1.483).margin(0.0005));
  CHECK(100 * part.bound(1.0 * um) == Approx(1.450).margin(0.0005));
  CHECK(100 * part.bound(2.0 * um) == Approx(1.383).margin(0.0005));
  CHECK(100 * part.bound(5.0 * um) == Approx(1.183).margin(0.0005));
}

TEST_CASE("A cuboid of 8 x 8 droplets spills 6.4 % at least") {
  if (no_solver()) return;
  CHECK(100 * square(8).bound(0.0) == Approx(6.4).margin(0.05));
}

TEST_CASE(
    "No sequence of two layers of any droplets on 2 x 3 cells spills less than the bound at its error") {
  if (no_solver()) return;
  const Part part(7, 0.009, [](int i, int j) { return i >= 2 && i < 4 && j >= 2 && j < 5; });
  std::vector<std::size_t> cells;
  for (std::size_t c = 0; c < part.mask.size(); ++c)
    if (part.mask.cells[c]) cells.push_back(c);
  REQUIRE(cells.size() == 6);
  const std::vector<double> errors_mm{0.0005, 0.001, 0.0015, 0.002, 0.003, 0.005, 0.009};
  std::vector<double> least(errors_mm.size(), INFINITY);
  deposition::HeightChange<1> change(part.mask.spec, deposition::stencil_of(kTable1),
                                     deposition::Border::kLose);
  for (unsigned first = 0; first < 64; ++first)
    for (unsigned second = 0; second < 64; ++second) {
      HeightMap h(part.mask.spec, 0.0);
      for (const unsigned layer : {first, second}) {
        DropletPattern drops(part.mask.spec);
        for (std::size_t k = 0; k < 6; ++k) drops.cells[cells[k]] = layer >> k & 1u;
        change.deposit(h, drops);
      }
      const double mean_abs_mm = error_stats(h, part.target, part.mask).mean_abs_mm;
      const double overspill = outline_stats(h, part.target, part.mask).overspill;
      for (std::size_t n = 0; n < errors_mm.size(); ++n)
        if (mean_abs_mm <= errors_mm[n]) least[n] = std::min(least[n], overspill);
    }
  REQUIRE(std::isfinite(least[3]));
  for (std::size_t n = 0; n < errors_mm.size(); ++n) {
    CAPTURE(errors_mm[n]);
    CHECK(part.bound(errors_mm[n]) <= least[n] + 1e-9);
  }
}

TEST_CASE("Behind a wall at the grid's border nothing is spilled") {
  const Part all(3, 0.4, [](int, int) { return true; });
  CHECK(edge_bound(all.target, all.mask, kTable1, deposition::Border::kKeep, 0.0) == 0.0);
}

TEST_CASE("A part without volume and a negative error are refused") {
  const Part none(3, 0.0, [](int, int) { return true; });
  CHECK_THROWS_WITH(none.bound(0.0), Catch::Contains("no volume"));
  CHECK_THROWS_WITH(square(1).bound(-0.001), Catch::Contains("0 or more"));
}
