#include "core/vision/lines.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;

namespace {

constexpr double kSigma_mm = 0.03, kPeak_mm = 0.005;
const GridSpec kGrid{150, 100, 0.02, 0.02, 0.0, 0.0};

double softened(double d_mm) { return 0.5 * std::erfc(d_mm / 0.02 / std::sqrt(2.0)); }

/// A line through (x, y) in a direction, with a Gauss section, from `from_mm` to `to_mm` along it.
HeightMap drawn(double x, double y, const Point2& u, double from_mm, double to_mm, double noise_mm = 0.0,
                std::uint64_t seed = 1) {
  HeightMap h(kGrid, 0.0);
  for (int j = 0; j < kGrid.ny; ++j)
    for (int i = 0; i < kGrid.nx; ++i) {
      const double dx = kGrid.x_mm(i) - x, dy = kGrid.y_mm(j) - y;
      const double s = dx * u.x_mm + dy * u.y_mm, n = dy * u.x_mm - dx * u.y_mm;
      h.at(i, j) = kPeak_mm * std::exp(-0.5 * n * n / (kSigma_mm * kSigma_mm)) * softened(from_mm - s) *
                   softened(s - to_mm);
      if (noise_mm > 0.0)
        h.at(i, j) +=
            noise_mm * random_normal({seed, Purpose::kTest, 0, 0, std::uint32_t(kGrid.index(i, j))});
    }
  return h;
}

LineStation station(const Point2& at, const Point2& u, double length_mm = 0.6) {
  LineStation s;
  s.at = at;
  s.direction = u;
  s.to_mm = length_mm;
  return s;
}

}  // namespace

TEST_CASE("A drawn line is read back: section, width and middle, at any angle") {
  for (const double angle : {0.0, 0.3, 0.7854, 1.2, 2.5}) {
    const Point2 u{std::cos(angle), std::sin(angle)}, left{-u.y_mm, u.x_mm};
    const double off = 0.017;
    const HeightMap h = drawn(1.5 + off * left.x_mm, 1.0 + off * left.y_mm, u, -9.0, 9.0);
    const auto line = vision::measure_line(h, station({1.5, 1.0}, u), {});
    INFO("angle " << angle);
    REQUIRE(line);
    CHECK(line->area_mm2 == Approx(kPeak_mm * kSigma_mm * std::sqrt(2.0 * M_PI)).epsilon(0.005));
    // Bilinear reading of cells of 20 um widens a line of sigma 30 um by a few per cent.
    CHECK(line->width_mm == Approx(2.3548 * kSigma_mm).epsilon(0.06));
    CHECK(line->offset_mm == Approx(off).margin(0.001));
    CHECK(std::abs(line->overspray) < 0.01);
  }
}

TEST_CASE("Ink beside a line is its overspray") {
  const Point2 u{1.0, 0.0};
  HeightMap h = drawn(1.5, 1.0, u, -9.0, 9.0);
  const double film_mm = 1e-4;
  for (double& v : h.cells) v += film_mm;
  const auto line = vision::measure_line(h, station({1.5, 1.0}, u), {});
  REQUIRE(line);
  const double section = kPeak_mm * kSigma_mm * std::sqrt(2.0 * M_PI) + 0.5 * film_mm;
  CHECK(line->overspray == Approx((0.5 - 2.6 * line->width_mm) * film_mm / section).epsilon(0.05));
}

TEST_CASE("A line's end is found where its level falls to half, and its sign says late or long") {
  const Point2 u{1.0, 0.0};
  for (const double shift : {-0.12, -0.03, 0.0, 0.05, 0.2}) {
    INFO("shift " << shift);
    const HeightMap h = drawn(1.5, 1.0, u, -0.9 + shift, 0.9 + shift);
    LineEnd start{0, true, {0.6, 1.0}, u, true, 1.8}, end{0, false, {2.4, 1.0}, u, true, 1.8};
    CHECK(vision::measure_end(h, start, 0.07, {}).value() == Approx(shift).margin(0.003));
    CHECK(vision::measure_end(h, end, 0.07, {}).value() == Approx(shift).margin(0.003));
    start.free = false;
    CHECK(!vision::measure_end(h, start, 0.07, {}));
    end.length_mm = 0.5;
    CHECK(!vision::measure_end(h, end, 0.07, {}));
  }
}

TEST_CASE("An end is found beside and behind a few cells that were not measured, and not in a longer gap") {
  const Point2 u{1.0, 0.0};
  const LineEnd end{0, false, {2.4, 1.0}, u, true, 1.8};
  const auto read = [&](double from_mm, double to_mm) {
    HeightMap h = drawn(1.5, 1.0, u, -0.9, 0.9);
    for (int j = 45; j <= 55; ++j)
      for (int i = 0; i < kGrid.nx; ++i)
        if (kGrid.x_mm(i) >= from_mm && kGrid.x_mm(i) <= to_mm) h.at(i, j) = kNotMeasured;
    return vision::measure_end(h, end, 0.07, {});
  };
  CHECK(read(1.79, 1.85).value() == Approx(0.0).margin(0.003));
  CHECK(read(2.59, 2.65).value() == Approx(0.0).margin(0.003));
  CHECK(read(2.35, 2.41).value() == Approx(0.0).margin(0.02));
  CHECK(!read(2.2, 2.5));
}

TEST_CASE("A layer's own end is found in the ink that it added, though the layer before went farther") {
  const Point2 u{1.0, 0.0};
  const LineEnd start{0, true, {0.6, 1.0}, u, true, 1.8}, end{0, false, {2.4, 1.0}, u, true, 1.8};
  const HeightMap before = drawn(1.5, 1.0, u, -1.0, 1.1);
  const double level = vision::level_inside(before, end, 0.07, {}).value();
  for (const double shift : {-0.05, 0.0, 0.04}) {
    INFO("shift " << shift);
    HeightMap after = drawn(1.5, 1.0, u, -0.9 + shift, 0.9 + shift);
    for (std::size_t c = 0; c < after.size(); ++c) after.cells[c] += before.cells[c];
    for (const LineEnd& e : {start, end})
      CHECK(vision::measure_added_end({before, after, level, 1.0}, e, 0.07, {}).value() ==
            Approx(shift).margin(0.003));
    CHECK(!vision::measure_added_end({before, after, level, level}, end, 0.07, {}));
    CHECK(!vision::measure_added_end({before, before, level, 1.0}, end, 0.07, {}));
  }
}

TEST_CASE("Noise of a tenth of a layer leaves section and end where they are", "[seeded]") {
  const Point2 u{0.8, 0.6};
  double worst_section = 0.0, worst_end = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const HeightMap h = drawn(1.5, 1.0, u, -0.7, 9.0, 0.1 * kPeak_mm, seed);
    vision::LineWindow look;
    look.noise_mm = 0.1 * kPeak_mm;
    const auto line = vision::measure_line(h, station({1.74, 1.18}, u), look);
    REQUIRE(line);
    worst_section = std::max(worst_section,
                             std::abs(line->area_mm2 / (kPeak_mm * kSigma_mm * std::sqrt(2.0 * M_PI)) - 1.0));
    const LineEnd start{0, true, {1.5 - 0.7 * 0.8, 1.0 - 0.7 * 0.6}, u, true, 3.0};
    worst_end = std::max(worst_end, std::abs(vision::measure_end(h, start, 0.07, look).value()));
  }
  CHECK(worst_section < 0.08);
  CHECK(worst_end < 0.02);
}

TEST_CASE("Where nothing was printed there is no width, and without a measurement no reading") {
  const Point2 u{1.0, 0.0};
  HeightMap h(kGrid, 0.0);
  const auto none = vision::measure_line(h, station({1.5, 1.0}, u), {});
  REQUIRE(none);
  CHECK(none->area_mm2 == 0.0);
  CHECK(std::isnan(none->width_mm));
  for (double& v : h.cells) v = kNotMeasured;
  CHECK(!vision::measure_line(h, station({1.5, 1.0}, u), {}));
  LineStation crowded = station({1.5, 1.0}, u);
  crowded.room_mm = 0.15;
  CHECK(!vision::measure_line(HeightMap(kGrid, 0.0), crowded, {}));
}
