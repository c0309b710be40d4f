// Volume beside the part and widths at half height, against closed forms and counts by hand.
#include "core/grid/outline.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace firn;

namespace {

constexpr GridSpec kOutlineGrid{41, 31, 0.2, 0.3, -4.0, -4.5};
constexpr double kTarget_mm = 0.4;

// A box of 4 x 3 mm: 21 x 11 cells, whose edges lie between cells.
struct Box {
  HeightMap target{kOutlineGrid, 0.0};
  Mask mask{kOutlineGrid};
  Box() {
    for (int j = 0; j < kOutlineGrid.ny; ++j)
      for (int i = 0; i < kOutlineGrid.nx; ++i)
        if (std::abs(kOutlineGrid.x_mm(i)) < 2.1 && std::abs(kOutlineGrid.y_mm(j)) < 1.65) {
          mask.at(i, j) = 1;
          target.at(i, j) = kTarget_mm;
        }
  }
};

// Flanks that fall linearly over `flank_mm`, at half height `wider_mm` wider on each side along x.
HeightMap with_flanks(double half_x_mm, double half_y_mm, double flank_mm) {
  HeightMap h(kOutlineGrid, 0.0);
  const auto side = [&](double at, double half) {
    return std::clamp((half - std::abs(at)) / flank_mm + 0.5, 0.0, 1.0);
  };
  for (int j = 0; j < kOutlineGrid.ny; ++j)
    for (int i = 0; i < kOutlineGrid.nx; ++i)
      h.at(i, j) =
          kTarget_mm * std::min(side(kOutlineGrid.x_mm(i), half_x_mm), side(kOutlineGrid.y_mm(j), half_y_mm));
  return h;
}

}  // namespace

TEST_CASE("A part that equals its target has nothing beside it and no size error") {
  const Box box;
  const OutlineStats s = outline_stats(box.target, box.target, box.mask);
  CHECK(s.overspill == 0.0);
  CHECK(s.first_ring_mm == 0.0);
  CHECK(s.size_error_x_mm == Approx(0.0).margin(1e-12));
  CHECK(s.size_error_y_mm == Approx(0.0).margin(1e-12));
}

TEST_CASE("Widths of linear flanks at half height are exact wherever the flank lies") {
  const Box box;  // 4.2 mm x 3.3 mm between its cells' edges
  std::mt19937 random(5);
  std::uniform_real_distribution<double> half(1.6, 2.4), flank(0.7, 1.2);
  for (int n = 0; n < 50; ++n) {
    const double hx = half(random), hy = half(random);
    const OutlineStats s = outline_stats(with_flanks(hx, hy, flank(random)), box.target, box.mask);
    CHECK(s.size_error_x_mm == Approx(2 * hx - 4.2).margin(1e-9));
    CHECK(s.size_error_y_mm == Approx(2 * hy - 3.3).margin(1e-9));
  }
}

TEST_CASE("Overspill is the volume beside the mask over the target's volume") {
  const Box box;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> height(0.0, 0.5);
  HeightMap h(kOutlineGrid);
  double outside_mm3 = 0.0;
  const double cell_mm2 = kOutlineGrid.pitch_x_mm * kOutlineGrid.pitch_y_mm;
  for (std::size_t c = 0; c < h.size(); ++c) {
    h.cells[c] = height(random);
    if (!box.mask.cells[c]) outside_mm3 += h.cells[c] * cell_mm2;
  }
  const double part_mm3 = double(box.mask.count()) * cell_mm2 * kTarget_mm;
  CHECK(outline_stats(h, box.target, box.mask).overspill == Approx(outside_mm3 / part_mm3));
}

TEST_CASE("The first ring is the cells that share a side with the part, outside and in its holes") {
  Box box;
  box.mask.at(20, 15) = 0;  // a hole of one cell
  box.target.at(20, 15) = 0.0;
  HeightMap h(kOutlineGrid, 0.0);
  h.at(20, 15) = 0.3;
  int ring = 2 * (21 + 11) + 1;
  CHECK(outline_stats(h, box.target, box.mask).first_ring_mm == Approx(0.3 / ring));
  h.at(9, 9) = 5.0;  // a corner's neighbour across the corner only
  CHECK(outline_stats(h, box.target, box.mask).first_ring_mm == Approx(0.3 / ring));
}

TEST_CASE("Cells that were not measured count nowhere, and values that nothing tells are NaN") {
  const Box box;
  HeightMap h(kOutlineGrid, kNotMeasured);
  const OutlineStats none = outline_stats(h, box.target, box.mask);
  CHECK(std::isnan(none.overspill));
  CHECK(std::isnan(none.first_ring_mm));
  CHECK(std::isnan(none.size_error_x_mm));
  for (std::size_t c = 0; c < h.size(); ++c)
    if (box.mask.cells[c]) h.cells[c] = kTarget_mm;
  CHECK(outline_stats(h, box.target, box.mask).size_error_x_mm == Approx(0.0).margin(1e-12));
  const OutlineStats low = outline_stats(HeightMap(kOutlineGrid, 0.1), box.target, box.mask);
  CHECK(std::isnan(low.size_error_x_mm));
  CHECK(std::isfinite(low.overspill));
}

TEST_CASE("Maps that do not fit each other are refused") {
  const Box box;
  CHECK_THROWS_WITH(outline_stats(HeightMap(GridSpec{3, 3}), box.target, box.mask),
                    Catch::Contains("do not fit"));
}

TEST_CASE(
    "A map that reaches beyond the target's grid counts what lies there, and is cut only at its border") {
  const Box box;
  GridSpec wide = kOutlineGrid;
  wide.nx += 6;
  wide.ny += 4;
  wide.origin_x_mm -= 3 * wide.pitch_x_mm;
  wide.origin_y_mm -= 2 * wide.pitch_y_mm;
  HeightMap h(wide, 0.0);
  for (int j = 0; j < kOutlineGrid.ny; ++j)
    for (int i = 0; i < kOutlineGrid.nx; ++i) h.at(i + 3, j + 2) = box.target.at(i, j);
  CHECK(outline_stats(h, box.target, box.mask).overspill == 0.0);
  h.at(1, 17) = kTarget_mm;  // beyond the target's grid
  const OutlineStats s = outline_stats(h, box.target, box.mask);
  CHECK(s.overspill == Approx(1.0 / double(box.mask.count())));
  CHECK(s.size_error_x_mm > 2.0);
  CHECK_FALSE(s.cut);
  h.at(0, 17) = kTarget_mm;
  CHECK(outline_stats(h, box.target, box.mask).cut);
}

TEST_CASE("A part that fills the target's grid to its border is counted whole within a wider map") {
  const HeightMap target(kOutlineGrid, kTarget_mm);
  const Mask mask(kOutlineGrid, 1);
  GridSpec wide = kOutlineGrid;
  wide.nx += 4;
  wide.ny += 4;
  wide.origin_x_mm -= 2 * wide.pitch_x_mm;
  wide.origin_y_mm -= 2 * wide.pitch_y_mm;
  HeightMap h(wide, 0.0);
  for (int j = 0; j < kOutlineGrid.ny; ++j)
    for (int i = 0; i < kOutlineGrid.nx; ++i) h.at(i + 2, j + 2) = kTarget_mm;
  const OutlineStats s = outline_stats(h, target, mask);
  CHECK(s.overspill == 0.0);
  CHECK(s.missing == 0.0);
}

TEST_CASE("Missing volume is what lies below the target inside, whatever lies above it elsewhere") {
  const Box box;
  HeightMap h = box.target;
  h.at(20, 15) -= 0.1;
  h.at(21, 15) += 0.3;
  h.at(2, 2) = 0.2;
  const double cells = double(box.mask.count());
  const OutlineStats s = outline_stats(h, box.target, box.mask);
  CHECK(s.missing == Approx(0.1 / (cells * kTarget_mm)));
  CHECK(s.overspill == Approx(0.2 / (cells * kTarget_mm)));
  CHECK(s.misplaced == Approx(0.3 / (cells * kTarget_mm)));
}

TEST_CASE("A cylinder that is wider than its target by d has a size error of 2 d along either axis") {
  const GridSpec g{101, 101, 0.1, 0.1, -5.0, -5.0};
  HeightMap target(g, 0.0), height(g, 0.0);
  Mask mask(g);
  const double radius = 3.0, wider = 0.27;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double r = std::hypot(g.x_mm(i), g.y_mm(j));
      if (r < radius + 1e-9) {
        mask.at(i, j) = 1;
        target.at(i, j) = kTarget_mm;
      }
      height.at(i, j) = kTarget_mm * std::clamp((radius + 0.05 + wider - r) / 0.6 + 0.5, 0.0, 1.0);
    }
  const OutlineStats s = outline_stats(height, target, mask);
  CHECK(s.size_error_x_mm == Approx(2 * wider).margin(0.002));
  CHECK(s.size_error_y_mm == Approx(2 * wider).margin(0.002));
}

TEST_CASE("The RMS inside leaves out cells with a neighbour beside the part") {
  const Box box;
  HeightMap h = box.target;
  for (int j = 0; j < kOutlineGrid.ny; ++j)
    for (int i = 0; i < kOutlineGrid.nx; ++i)
      if (box.mask.at(i, j)) h.at(i, j) -= inside_of(box.mask).at(i, j) ? 0.001 : 0.05;
  const OutlineStats s = outline_stats(h, box.target, box.mask);
  const double all = double(box.mask.count()), in = double(inside_of(box.mask).count());
  CHECK(s.rms_inside_mm == Approx(0.001));
  CHECK(s.rms_mm == Approx(std::sqrt((in * 1e-6 + (all - in) * 2.5e-3) / all)));
}

TEST_CASE("Every value of an outline has one name, with its unit at the end") {
  for (const OutlineMetric& m : kOutlineMetrics) {
    CHECK(&outline_metric(m.name) == &m);
    CHECK(m.name.ends_with(m.unit == "%" ? "_pct" : "_um"));
  }
  CHECK_THROWS_WITH(outline_metric("overspil"), Catch::Contains("overspil"));
}
