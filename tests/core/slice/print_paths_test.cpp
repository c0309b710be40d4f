#include "core/slice/paths/print_paths.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/slice/coverage/footprint.h"

namespace firn::slice {
namespace {

LayerPaths layer(std::int32_t number, RandomStream& random) {
  LayerPaths l;
  l.layer = number;
  l.z = 2400 * number;
  l.height = 2400;
  for (int n = 0; n < 6; ++n) {
    std::vector<geometry::Point> line;
    for (int k = 0; k < 12; ++k)
      line.push_back({std::int32_t(random.below(400'000)), std::int32_t(random.below(300'000))});
    l.lines.add(line);
    l.info.push_back(
        {PathKind(random.below(4)), std::uint8_t(random.below(2)), random.below(2) == 1, 15'000});
    if (l.info.back().kind == PathKind::kMeasurement) l.info.back().width = 0;
  }
  l.info[0].kind = PathKind::kBoundary;
  l.info[0].width = 15'000;
  return l;
}

PrintPaths print() {
  RandomStream random(1, Purpose::kTest);
  PrintPaths p;
  p.head = {"test", 3, {{"part", "water"}, {"scaffold", "scaffold"}}, "laser", "a = 1\n"};
  for (const std::int32_t n : {1, 2, 5}) p.layers.push_back(layer(n, random));
  return p;
}

}  // namespace

TEST_CASE("The paths of a print come back as they were, and a layer is found by its number") {
  const PrintPaths p = print();
  const PrintPaths back = decode_print_paths(encode(p));
  CHECK(back.head == p.head);
  CHECK(back.layers == p.layers);
  REQUIRE(find_layer(back, 5));
  CHECK(*find_layer(back, 5) == p.layers[2]);
  CHECK(find_layer(back, 4) == nullptr);
  CHECK(find_layer(back, 6) == nullptr);
}

TEST_CASE(
    "The bare table is layer 0 at height 0, with the lines of the first layer that is measured, before all "
    "others") {
  PrintPaths p = print();
  for (std::size_t n = 0; n < p.layers.size(); ++n)
    for (PathInfo& i : p.layers[n].info) {
      i.kind = n > 0 ? i.kind : PathKind::kBoundary;
      i.width = i.width ? i.width : 15'000;
    }
  p.layers[1].info[3].kind = PathKind::kMeasurement;
  p.layers[1].info[3].width = 0;
  const LayerPaths table = table_layer(p);
  CHECK(table.layer == 0);
  CHECK(table.z == 0);
  CHECK(table.lines == p.layers[1].lines);
  CHECK(table.info == p.layers[1].info);
  const PrintPaths with = with_table(p);
  REQUIRE(with.layers.size() == 4);
  CHECK(with.layers[0] == table);
  CHECK(find_layer(with, 0) == &with.layers[0]);
  CHECK(std::equal(p.layers.begin(), p.layers.end(), with.layers.begin() + 1));
  for (LayerPaths& l : p.layers)
    for (PathInfo& i : l.info) i.kind = PathKind::kBoundary;
  CHECK_THROWS_WITH(with_table(p), Catch::Contains("no layer has measurement paths"));
}

TEST_CASE(
    "Bytes that are cut or changed in their frame are refused with the byte, and nothing crashes on any") {
  const std::vector<std::byte> good = encode(print());
  for (std::size_t n = 0; n < good.size(); n += 7)
    CHECK_THROWS_AS(decode_print_paths(std::span(good).first(n)), FormatError);
  CHECK_THROWS_WITH(decode_print_paths(std::span(good).first(3)), Catch::Contains("signature"));
  std::vector<std::byte> more = good;
  more.push_back(std::byte(0));
  CHECK_THROWS_WITH(decode_print_paths(more), Catch::Contains("left over"));
  RandomStream random(2, Purpose::kTest);
  for (int n = 0; n < 2000; ++n) {
    std::vector<std::byte> bad = good;
    bad[random.below(std::uint32_t(bad.size()))] ^= std::byte(1u << random.below(8));
    try {
      decode_print_paths(bad);
    } catch (const FormatError&) {
    }
  }
  PrintPaths twice = print();
  twice.layers[1].layer = 1;
  CHECK_THROWS_WITH(encode(twice), Catch::Contains("layer 1 stands behind layer 1"));
}

TEST_CASE(
    "The footprint's grid holds every bead, with centres at multiples of the pitch, and its cells are those "
    "near a line") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const LayerPaths l = layer(1, random);
    const double pitch = 0.5 + 0.1 * double(seed % 4);
    const GridSpec g = footprint_grid(l, pitch);
    const Grid<std::uint8_t> material = footprint_materials(l, g);
    const double i0 = g.origin_x_mm / pitch;
    CHECK(i0 == Approx(std::floor(i0 + 0.5)).margin(1e-9));
    // brute force: points along every line, a hundredth of the width apart
    for (int j = 0; j < g.ny; j += 3)
      for (int i = 0; i < g.nx; i += 3) {
        double best = 1e9;
        for (std::size_t n = 0; n < l.lines.size(); ++n) {
          if (l.info[n].kind == PathKind::kMeasurement) continue;
          const auto line = l.lines[n];
          for (std::size_t k = 0; k + 1 < line.size() + (l.info[n].closed ? 1 : 0); ++k) {
            const geometry::Point a = line[k], b = line[(k + 1) % line.size()];
            for (double t = 0.0; t <= 1.0; t += 0.001) {
              const double x = (a.x + t * (b.x - a.x)) * geometry::kMmPerUnit - g.x_mm(i),
                           y = (a.y + t * (b.y - a.y)) * geometry::kMmPerUnit - g.y_mm(j);
              if (x * x + y * y < best) best = x * x + y * y;
            }
          }
        }
        const double d = std::sqrt(best);
        if (std::abs(d - 0.75) > 0.02) CHECK((material.at(i, j) != 0) == (d < 0.75));
      }
    for (std::size_t n = 0; n < l.lines.size(); ++n)
      for (const geometry::Point& p : l.lines[n]) {
        if (l.info[n].kind == PathKind::kMeasurement) continue;
        CHECK(p.x * geometry::kMmPerUnit + 1e-9 >= g.x_mm(0));
        CHECK(p.x * geometry::kMmPerUnit - 1e-9 <= g.x_mm(g.nx - 1));
        CHECK(p.y * geometry::kMmPerUnit + 1e-9 >= g.y_mm(0));
        CHECK(p.y * geometry::kMmPerUnit - 1e-9 <= g.y_mm(g.ny - 1));
      }
    CHECK(footprint_mask(material).count() > 0);
  }
}

TEST_CASE(
    "Each cell is of the material of its nearest line, and a layer that deposits nothing has no footprint") {
  LayerPaths l;
  l.layer = 3;
  l.lines.add(std::vector<geometry::Point>{{0, 0}, {100'000, 0}});
  l.lines.add(std::vector<geometry::Point>{{0, 20'000}, {100'000, 20'000}});
  l.info = {{PathKind::kFill, 0, false, 30'000}, {PathKind::kFill, 1, false, 30'000}};
  const Grid<std::uint8_t> m = footprint_materials(l, footprint_grid(l, 0.4));
  for (int j = 0; j < m.spec.ny; ++j)
    for (int i = 5; i < m.spec.nx - 5; ++i) {
      const double y = m.spec.y_mm(j);
      if (y > -1.5 && y < 0.95) CHECK(int(m.at(i, j)) == 1);
      if (y > 1.05 && y < 3.5) CHECK(int(m.at(i, j)) == 2);
    }
  l.info[0].kind = l.info[1].kind = PathKind::kMeasurement;
  CHECK_THROWS_WITH(footprint_grid(l, 0.4), Catch::Contains("layer 3 deposits nothing"));
  CHECK_THROWS_WITH(footprint_grid(l, 0.0), Catch::Contains("pitch"));
}

TEST_CASE(
    "Spots between beads belong to what a layer should cover, and a bore and a notch in the border do not") {
  Mask m({30, 20, 1.0, 1.0, 0.0, 0.0});
  for (int j = 2; j < 18; ++j)
    for (int i = 2; i < 28; ++i) m.at(i, j) = 1;
  const Mask whole = m;
  CHECK(without_narrow_holes(whole, 2.0) == whole);
  m.at(5, 5) = 0;                                             // a spot
  for (int i = 10; i < 20; ++i) m.at(i, 4) = m.at(i, 5) = 0;  // a long one, two cells wide
  CHECK(without_narrow_holes(m, 2.0) == whole);
  Mask expected = whole;
  for (int j = 9; j < 13; ++j)
    for (int i = 9; i < 13; ++i) m.at(i, j) = expected.at(i, j) = 0;  // a bore
  for (int j = 0; j < 8; ++j) m.at(24, j) = expected.at(24, j) = 0;   // a notch
  m.at(25, 8) = 0;                                                    // touches it at a corner only
  CHECK(without_narrow_holes(m, 2.0) == expected);
  CHECK(without_narrow_holes(m, 0.5) == m);
}

TEST_CASE(
    "Coverage is width over distance: 1 where beads touch, more where they overlap, less where they leave a "
    "slit") {
  for (const double apart_mm : {2.5, 3.0, 3.5}) {
    LayerPaths l;
    l.layer = 1;
    l.z = l.height = 2400;
    for (int n = 0; n < 20; ++n) {
      const auto y = std::int32_t(std::lround(apart_mm * n * geometry::kUnitsPerMm));
      l.lines.add(std::vector<geometry::Point>{{0, y}, {40 * geometry::kUnitsPerMm, y}});
      l.info.push_back({PathKind::kFill, 0, false, 3 * geometry::kUnitsPerMm});
    }
    for (const std::int32_t x : {0, 40}) {  // so that slits are enclosed
      l.lines.add(std::vector<geometry::Point>{
          {x * geometry::kUnitsPerMm, 0},
          {x * geometry::kUnitsPerMm, std::int32_t(std::lround(19 * apart_mm * geometry::kUnitsPerMm))}});
      l.info.push_back({PathKind::kBoundary, 0, false, 3 * geometry::kUnitsPerMm});
    }
    const GridSpec g = footprint_grid(l, 1.0);
    const HeightMap c = extrusion_coverage(l, g, 15.0, 2.0);
    double sum = 0.0, cells = 0.0;
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i)
        if (g.x_mm(i) > 10.0 && g.x_mm(i) < 30.0 && g.y_mm(j) > 12.0 && g.y_mm(j) < 19.0 * apart_mm - 12.0) {
          CHECK(c.at(i, j) == Approx(3.0 / apart_mm).epsilon(0.08));
          sum += c.at(i, j);
          cells += 1.0;
        }
    CHECK(sum / cells == Approx(3.0 / apart_mm).epsilon(0.02));
    CHECK(c.at(0, 0) > 0.0);
  }
}

}  // namespace firn::slice
