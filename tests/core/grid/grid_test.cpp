#include "core/grid/grid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/firing_order.h"
#include "core/grid/random.h"

using namespace firn;

namespace {

const GridSpec kLuGrid{40, 40, 0.263256, 0.263256, -3.1, 7.77};

DropletPattern random_pattern(const GridSpec& g, RandomStream& random, std::uint32_t up_to) {
  DropletPattern p(g);
  for (auto& c : p.cells) c = std::uint8_t(random.below(up_to + 1));
  return p;
}

}  // namespace

TEST_CASE("A cell's index is j * nx + i and its centre is origin + (i, j) * pitch") {
  const GridSpec g{4, 3, 0.5, 0.25, 10.0, -1.0};
  CHECK(g.size() == 12);
  CHECK(g.index(1, 2) == 9);
  CHECK(g.x_mm(3) == 11.5);
  CHECK(g.y_mm(2) == -0.5);
  CHECK(g.contains(3, 2));
  CHECK_FALSE(g.contains(4, 0));
  CHECK_FALSE(g.contains(0, -1));
}

TEST_CASE("A grid out of range is refused with the field and its limit") {
  const auto refused = [](GridSpec g, const char* field) {
    CHECK_THROWS_WITH(check(g), Catch::Contains(field));
  };
  CHECK_NOTHROW(check(kLuGrid));
  refused({0, 5}, "nx = 0");
  refused({5, kMaxGridSide + 1}, "ny = 4097");
  refused({5, 5, 0.0, 1.0}, "pitch_x_mm");
  refused({5, 5, 1.0, std::nan("")}, "pitch_y_mm");
  refused({5, 5, 1.0, 101.0}, "pitch_y_mm");
  refused({5, 5, 1.0, 1.0, INFINITY}, "origin_x_mm");
  refused({5, 5, 1.0, 1.0, 0.0, -10001.0}, "origin_y_mm");
}

TEST_CASE("Error statistics are those of the definition, over masked and measured cells") {
  RandomStream random(1, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    HeightMap h(kLuGrid), target(kLuGrid, 0.1);
    Mask mask(kLuGrid);
    std::vector<double> errors;
    int missing = 0;
    for (std::size_t c = 0; c < h.size(); ++c) {
      h.cells[c] = random.below(10) ? random.uniform(0.0, 0.3) : kNotMeasured;
      mask.cells[c] = random.below(2);
      if (!mask.cells[c]) continue;
      if (std::isfinite(h.cells[c]))
        errors.push_back(h.cells[c] - 0.1);
      else
        ++missing;
    }
    const ErrorStats s = error_stats(h, target, mask);
    double mean = 0.0, mean_abs = 0.0, square = 0.0, var = 0.0;
    for (double e : errors) {
      mean += e / double(errors.size());
      mean_abs += std::abs(e) / double(errors.size());
      square += e * e / double(errors.size());
    }
    for (double e : errors) var += (e - mean) * (e - mean) / double(errors.size());
    CHECK(s.cells == std::int64_t(errors.size()));
    CHECK(s.missing == missing);
    CHECK(s.mean_mm == Approx(mean));
    CHECK(s.mean_abs_mm == Approx(mean_abs));
    CHECK(s.rms_mm == Approx(std::sqrt(square)));
    CHECK(s.std_mm == Approx(std::sqrt(var)));
    CHECK(s.min_mm == *std::min_element(errors.begin(), errors.end()));
    CHECK(s.max_mm == *std::max_element(errors.begin(), errors.end()));
    CHECK(s.rms_mm * s.rms_mm == Approx(s.mean_mm * s.mean_mm + s.std_mm * s.std_mm));
  }
  const ErrorStats none = error_stats(HeightMap(kLuGrid), HeightMap(kLuGrid), Mask(kLuGrid));
  CHECK(none.cells == 0);
  CHECK(none.rms_mm == 0.0);
  CHECK_THROWS_AS(error_stats(HeightMap(kLuGrid), HeightMap(GridSpec{2, 2}), Mask(kLuGrid)),
                  std::invalid_argument);
}

TEST_CASE("Counts of patterns and masks") {
  DropletPattern p(GridSpec{3, 1});
  p.cells = {0, 5, 200};
  CHECK(p.total() == 205);
  CHECK(p.passes() == 200);
  CHECK(DropletPattern(GridSpec{2, 2}).passes() == 0);
  CHECK(DropletPattern().passes() == 0);
  CHECK(Mask(GridSpec{4, 4}, 1).count() == 16);
}

TEST_CASE("Resampling onto the same grid changes nothing, whatever the origin, also with holes") {
  RandomStream random(2, Purpose::kTest);
  for (int trial = 0; trial < 30; ++trial) {
    const GridSpec g{std::int32_t(1 + random.below(30)), std::int32_t(1 + random.below(30)),
                     random.uniform(0.01, 2.0),          random.uniform(0.01, 2.0),
                     random.uniform(-100.0, 100.0),      random.uniform(-100.0, 100.0)};
    HeightMap h(g);
    for (double& v : h.cells) v = random.below(8) ? random.uniform() : kNotMeasured;
    const HeightMap same = resample(h, g, -1.0);
    for (std::size_t c = 0; c < h.size(); ++c) {
      CHECK(std::isnan(same.cells[c]) == std::isnan(h.cells[c]));
      if (std::isfinite(h.cells[c])) CHECK(same.cells[c] == h.cells[c]);
    }
  }
}

TEST_CASE(
    "Resampling is exact for bilinear surfaces, and cells outside the old footprint get the value asked "
    "for") {
  const GridSpec from{11, 9, 0.5, 0.4, 1.0, 2.0}, to{25, 30, 0.2, 0.15, 0.5, 1.5};
  const auto surface = [](double x, double y) { return 0.3 + 0.1 * x - 0.2 * y + 0.05 * x * y; };
  HeightMap h(from);
  for (int j = 0; j < from.ny; ++j)
    for (int i = 0; i < from.nx; ++i) h.at(i, j) = surface(from.x_mm(i), from.y_mm(j));
  const HeightMap r = resample(h, to, -7.0);
  int inside = 0;
  for (int j = 0; j < to.ny; ++j)
    for (int i = 0; i < to.nx; ++i) {
      const double x = to.x_mm(i), y = to.y_mm(j);
      const bool in = x >= 1.0 - 1e-9 && x <= 6.0 + 1e-9 && y >= 2.0 - 1e-9 && y <= 5.2 + 1e-9;
      inside += in;
      CHECK(r.at(i, j) == Approx(in ? surface(x, y) : -7.0).margin(1e-12));
    }
  CHECK(inside > 300);
  h.at(5, 4) = kNotMeasured;
  CHECK(std::isnan(resample(h, GridSpec{1, 1, 1, 1, from.x_mm(5) + 0.1, from.y_mm(4)}, 0.0).at(0, 0)));
  CHECK(std::isfinite(resample(h, GridSpec{1, 1, 1, 1, from.x_mm(6), from.y_mm(4)}, 0.0).at(0, 0)));
}

TEST_CASE(
    "A pass fires each cell with more drops than the pass number once, rows ascending, serpentine by row "
    "number") {
  RandomStream random(3, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    const GridSpec g{std::int32_t(1 + random.below(12)), std::int32_t(1 + random.below(12))};
    const DropletPattern p = random_pattern(g, random, 3);
    std::int64_t fired = 0;
    for (int pass = 0; pass < 4; ++pass) {
      const auto order = firing_order(p, pass);
      fired += std::int64_t(order.size());
      for (std::size_t n = 0; n < order.size(); ++n) {
        CHECK(int(p.cells[order[n]]) > pass);
        if (n == 0) continue;
        const int j0 = int(order[n - 1]) / g.nx, j1 = int(order[n]) / g.nx;
        const int i0 = int(order[n - 1]) % g.nx, i1 = int(order[n]) % g.nx;
        CHECK(j0 <= j1);
        if (j0 == j1) CHECK((towards_plus_x(j0) ? i0 < i1 : i0 > i1));
      }
    }
    CHECK(fired == p.total());
  }
}
