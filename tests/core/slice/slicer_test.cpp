#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/planar.h"
#include "core/slice/mesh/slicer.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::slice;
using namespace firn::test;

namespace {

Placement on_platform() {
  Placement p;
  for (AxisPlace& t : p.translation) t.mode = AxisPlace::Mode::kNumber;
  return p;
}

SliceOptions options(double tolerance_mm = 0.0, double height_mm = 0.25) {
  SliceOptions o;
  o.chord_tolerance_mm = tolerance_mm;
  o.layer_height_mm = height_mm;
  return o;
}

Sliced sliced(const SampleMesh& m, const SliceOptions& o = options(), const Placement& p = {}) {
  return slice::slice(view(m), p, o, serially);
}

double volume_of(const Sliced& s, double height_mm = 0.25) {
  double sum = 0.0;
  for (const geometry::Region& r : s.layers) sum += area_mm2(r) * height_mm;
  return sum;
}

std::size_t total(const Sliced& s, DefectKind kind) {
  std::size_t n = 0;
  for (const Defect& d : s.defects) n += d.kind == kind ? d.count : 0;
  return n;
}

void check_in_order(const Sliced& s) {
  for (std::size_t n = 0; n < s.layers.size(); ++n) {
    INFO("layer " << n + 1);
    REQUIRE(crossing_by_all_pairs(s.layers[n]) == "");
    REQUIRE(canonical(s.layers[n]) == s.layers[n]);
  }
}

// Area of a layer by points on a raster, each judged by the mesh's own facets.
void check_by_raster(const SampleMesh& m, const geometry::Region& region, double z_mm, double step_mm) {
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  for (const auto& v : m.vertices) {
    x0 = std::min(x0, double(v[0]));
    x1 = std::max(x1, double(v[0]));
    y0 = std::min(y0, double(v[1]));
    y1 = std::max(y1, double(v[1]));
  }
  const Section section(m, z_mm);
  std::size_t inside = 0, differ = 0;
  for (double y = y0 - 1.37 * step_mm; y < y1 + step_mm; y += step_mm)
    for (double x = x0 - 1.61 * step_mm; x < x1 + step_mm; x += step_mm) {
      const bool in_mesh = section.winding(x, y) > 0;
      const geometry::Point at{std::int32_t(std::lround(x * geometry::kUnitsPerMm)),
                               std::int32_t(std::lround(y * geometry::kUnitsPerMm))};
      inside += in_mesh;
      differ += in_mesh != (winding(region, at) > 0);
    }
  CHECK(double(differ) <= 1.0 + 1e-4 * double(inside));  // points on the outline may be judged either way
  CHECK(std::abs(double(inside) * step_mm * step_mm - area_mm2(region)) <=
        0.01 * area_mm2(region) + 8 * step_mm * step_mm);
}

}  // namespace

TEST_CASE(
    "Layers are cut at their middles, half a unit above the grid, while the middle lies below the top") {
  CHECK(layer_planes(0.25, 2500) == std::vector<std::int32_t>{1250});
  CHECK(layer_planes(0.25, 1250).empty());
  CHECK(layer_planes(0.25, 1251) == std::vector<std::int32_t>{1250});
  CHECK(layer_planes(0.25, 1'727'500).size() == 691);  // the height of the thesis's statue
  CHECK_THROWS_AS(layer_planes(0.0, 100), std::invalid_argument);
  CHECK_THROWS_AS(layer_planes(0.001, 1 << 30), std::invalid_argument);
}

TEST_CASE("A box becomes its outline in every layer, counter-clockwise from the smallest corner") {
  const Sliced s = sliced(box(1, 2, 0, 4, 6, 1));
  REQUIRE(s.layers.size() == 4);
  for (const geometry::Region& layer : s.layers) {
    REQUIRE(layer.size() == 1);
    const auto ring = layer[0];
    CHECK(ring[0] == geometry::Point{10'000, 20'000});
    CHECK(twice_area(ring) == 2 * std::int64_t(30'000) * 40'000);
  }
  CHECK(s.defects.empty());
  CHECK(s.facts.closed);
  CHECK(s.facts.volume_mm3 == Approx(12.0));
  const Sliced few = sliced(box(1, 2, 0, 4, 6, 1), options(0.01));
  for (const geometry::Region& layer : few.layers) CHECK(layer.points.size() == 4);
}

TEST_CASE("The contours of closed meshes enclose the volume of the divergence theorem within 0.1 %") {
  for (const SampleMesh& m :
       {torus(20, 7, 180, 90), moved(gear(24, 12.0f), 0, 0, 0), nested_shells(), sphere(0, 0, 10, 10)}) {
    const Sliced s = sliced(m), coarse = sliced(m, options(0.05));
    const double volume = volume_by_tetrahedra(m);
    CHECK(s.facts.closed);
    CHECK(s.facts.volume_mm3 == Approx(volume).epsilon(1e-5));
    CHECK(std::abs(volume_of(s) / volume - 1.0) <= 1e-3);
    CHECK(std::abs(volume_of(coarse) / volume - 1.0) <= 1e-3);  // chord tolerance 0.05 mm on parts of 20 mm
    check_in_order(s);
    check_in_order(coarse);
  }
}

TEST_CASE("Areas agree with a raster of points judged by the facets themselves") {
  const std::vector<SampleMesh> meshes = {torus(20, 7, 90, 45), nested_shells(), gear(), spheres()};
  for (const SampleMesh& m : meshes) {
    const Sliced s = sliced(m);
    RandomStream random(7, Purpose::kTest);
    for (int k = 0; k < 3; ++k) {
      const std::size_t n = random.below(std::uint32_t(s.layers.size()));
      INFO("layer " << n + 1);
      check_by_raster(m, s.layers[n], (double(n) + 0.5) * 0.25 + 0.5 * geometry::kMmPerUnit, 0.11);
    }
  }
}

TEST_CASE("44 spheres that run into each other become one area per layer, never crossing") {
  const Sliced s = sliced(spheres());
  CHECK(s.facts.closed);
  CHECK(s.counts.repaired_layers > 20);
  CHECK(total(s, DefectKind::kOverlap) == s.counts.repaired_layers);
  check_in_order(s);
  check_in_order(sliced(spheres(), options(0.05)));
}

TEST_CASE("The order of facets and of their corners changes no byte") {
  for (const SampleMesh& m : {torus(15, 5, 60, 30), spheres(20, 3), moebius(), t_junctions(), with_nan(),
                              both(box(0, 0, 0, 9, 9, 9), box(0, 0, 0, 9, 9, 9))}) {
    const Sliced s = sliced(m, options(0.02));
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Sliced other = sliced(unwelded(shuffled(m, seed)), options(0.02));
      CHECK(other.layers == s.layers);
      CHECK(other.defects == s.defects);
      CHECK(other.facts.volume_mm3 == s.facts.volume_mm3);
    }
  }
}

TEST_CASE("A mesh that is inside out is turned, and so is a body inside out beside a good one") {
  const Sliced good = sliced(nested_shells()), turned = sliced(inside_out(nested_shells()));
  CHECK(turned.layers == good.layers);
  CHECK(total(turned, DefectKind::kInsideOut) == 1);
  const SampleMesh hollow = both(sphere(60, 0, 12, 6), inside_out(sphere(60, 0, 12, 3)));
  const Sliced mixed = sliced(both(nested_shells(), inside_out(hollow))),
               right = sliced(both(nested_shells(), hollow));
  CHECK(mixed.layers == right.layers);
  CHECK(total(mixed, DefectKind::kTurned) > 0);
}

TEST_CASE(
    "Layers of upright walls have the region of the lowest of them, wherever the walls' facets border each "
    "other") {
  const SampleMesh gears = both(
      gear(40, 5.0f), prism(90, 5.0f, 60.0f, 20.0f, [](std::uint32_t n) { return n % 3 ? 14.0 : 15.0; }));
  const Sliced exact = sliced(gears, options(0.0)), s = sliced(gears, options(0.05));
  REQUIRE(s.layers.size() == 20);
  std::size_t others = 0;  // whose borders lie elsewhere
  for (std::size_t n = 1; n < s.layers.size(); ++n) {
    CHECK(s.layers[n] == s.layers[0]);
    CHECK(s.contours[n] == s.contours[0]);
    others += exact.layers[n] != exact.layers[0];
  }
  CHECK(others > 10);
}

TEST_CASE("A long upright wall of many facets has one region in all its layers") {
  const SampleMesh block = prism(400, 5.0f, 20.0f, 20.0f, [](std::uint32_t n) {
    const double a = 2 * std::numbers::pi * n / 400;
    return 12.0 / std::max(std::abs(std::cos(a)), std::abs(std::sin(a)));
  });
  const Sliced s = sliced(block, options(0.05));
  for (std::size_t n = 1; n < s.layers.size(); ++n) CHECK(s.layers[n] == s.layers[0]);
}

TEST_CASE("Layers whose walls lean by two units a layer have each its own region") {
  SampleMesh leaning = gear(40, 5.0f);
  for (auto& v : leaning.vertices) v[0] += v[2] * 0.0008f;
  const Sliced s = sliced(leaning, options(0.05));
  for (std::size_t n = 1; n < s.layers.size(); ++n) CHECK(s.layers[n] != s.layers[n - 1]);
}

TEST_CASE("A mirrored part keeps its inside") {
  Placement mirror;
  mirror.scale = {-1, 1, 1};
  mirror.translation[0] = {AxisPlace::Mode::kNumber, 0.0};
  const Sliced s = sliced(moved(gear(7, 3.0f), 3, 1, 0), options(), mirror), plain = sliced(gear(7, 3.0f));
  CHECK(s.defects.empty());
  CHECK(volume_of(s) == Approx(volume_of(plain)).epsilon(1e-6));
  CHECK(s.facts.volume_mm3 > 0.0);
}

TEST_CASE("Facets wound against the rest are outvoted by their contour") {
  SampleMesh m = torus(20, 7, 90, 45);
  const Sliced good = sliced(m);
  for (std::size_t n = 0; n < m.triangles.size(); n += 7) std::swap(m.triangles[n][1], m.triangles[n][2]);
  const Sliced mended = sliced(m);
  CHECK(mended.layers == good.layers);
  CHECK_FALSE(mended.facts.closed);
  CHECK(total(mended, DefectKind::kTurned) > 0);
  CHECK(total(mended, DefectKind::kOpenDropped) == 0);
}

TEST_CASE("Facets that come twice count once in the area, and are told") {
  const SampleMesh m = box(0, 0, 0, 5, 5, 2);
  const Sliced s = sliced(both(m, m));
  CHECK(s.layers == sliced(m).layers);
  CHECK(total(s, DefectKind::kBranching) > 0);
}

TEST_CASE("T-junctions leave no gap") {
  const Sliced s = sliced(t_junctions());
  CHECK_FALSE(s.facts.closed);
  CHECK(total(s, DefectKind::kOpenDropped) == 0);
  for (const geometry::Region& layer : s.layers) CHECK(area_mm2(layer) == Approx(400.0).epsilon(1e-4));
}

TEST_CASE(
    "Contours over a hole in the mesh are closed within the tolerances and dropped beyond, each with its "
    "place") {
  SampleMesh m = box(0, 0, 0, 10, 10, 10);
  m.triangles.resize(10);  // the wall x = 10 is missing
  SliceOptions o = options();
  o.closing_gap_mm = 2.0;
  o.closing_share = 0.0;
  Sliced s = sliced(m, o);
  CHECK(s.layers.size() == 40);
  for (const geometry::Region& layer : s.layers) CHECK(layer.empty());
  CHECK(total(s, DefectKind::kOpenDropped) == 40);
  const auto dropped = std::find_if(s.defects.begin(), s.defects.end(),
                                    [](const Defect& d) { return d.kind == DefectKind::kOpenDropped; });
  CHECK(dropped->layer == 1);
  CHECK(dropped->at == geometry::Point{100'000, 0});
  CHECK(dropped->size_mm == Approx(30.0));
  o.closing_gap_mm = 10.0;
  s = sliced(m, o);
  CHECK(total(s, DefectKind::kGapClosed) == 40);
  CHECK(volume_of(s) == Approx(1000.0));
  o.closing_gap_mm = 0.0;
  o.closing_share = 0.5;  // 10 of 30 mm
  CHECK(volume_of(sliced(m, o)) == Approx(1000.0));
}

TEST_CASE("What bounds nothing leaves empty layers and says so") {
  const Sliced strip = sliced(moebius(), options());
  CHECK_FALSE(strip.facts.closed);
  CHECK(total(strip, DefectKind::kNotClosed) == 1);
  SliceOptions strict = options();
  strict.closing_share = 0.0;
  strict.closing_gap_mm = 0.5;
  const Sliced dropped = sliced(moebius(), strict);
  CHECK(total(dropped, DefectKind::kOpenDropped) > 20);
  const Sliced one = sliced(single_triangle());
  CHECK(one.layers.size() == 20);
  for (const geometry::Region& layer : one.layers) CHECK(layer.empty());
  CHECK(total(one, DefectKind::kOpenDropped) + total(one, DefectKind::kGapClosed) ==
        20);  // short ones fold on themselves
  const Sliced none = sliced(SampleMesh{});
  CHECK(none.layers.empty());
  CHECK(none.defects.empty());
}

TEST_CASE("Facets without any order become regions that cross nowhere, whatever is dropped") {
  RandomStream random(9, Purpose::kTest);
  for (int round = 0; round < 12; ++round) {
    SampleMesh soup;
    const auto corners = 4 + random.below(20);
    for (std::uint32_t n = 0; n < corners;
         ++n)  // few places, so that edges branch and facets lie in each other
      soup.vertices.push_back({float(random.below(8)), float(random.below(8)), float(random.uniform(0, 8))});
    for (int n = 0; n < 60; ++n)
      soup.triangles.push_back({random.below(corners), random.below(corners), random.below(corners)});
    const Sliced s = sliced(soup, options(round % 2 ? 0.05 : 0.0, 0.5));
    check_in_order(s);
    CHECK(sliced(shuffled(soup, 3), options(round % 2 ? 0.05 : 0.0, 0.5)).layers == s.layers);
  }
}

TEST_CASE("Corners that are no numbers cost their facets only") {
  const Sliced s = sliced(with_nan());
  CHECK(s.layers == sliced(box(0, 0, 0, 10, 10, 10)).layers);
  CHECK(total(s, DefectKind::kNotFinite) == 3);
  CHECK(s.facts.closed);
}

TEST_CASE("What lies below the platform is told and not printed") {
  const Sliced s = sliced(moved(box(0, 0, 0, 5, 5, 4), 0, 0, -2));
  CHECK(s.layers.size() == 8);
  CHECK(total(s, DefectKind::kBelow) == 1);
}

TEST_CASE("Later parts give way to earlier ones") {
  std::vector<geometry::Region> water = sliced(box(0, 0, 0, 10, 10, 5)).layers,
                                wax = sliced(box(5, 5, 0, 20, 20, 8)).layers;
  std::vector<std::vector<geometry::Region>*> parts = {&water, &wax};
  subtract_by_priority(parts, serially);
  CHECK(area_mm2(water[3]) == Approx(100.0));
  CHECK(area_mm2(wax[3]) == Approx(225.0 - 25.0));
  CHECK(area_mm2(wax[25]) == Approx(225.0));
  CHECK(common(water[3], wax[3]).empty());
}

TEST_CASE("Options that make no sense are refused by name") {
  SliceOptions o = options();
  o.chord_tolerance_mm = -1.0;
  CHECK_THROWS_WITH(sliced(box(0, 0, 0, 1, 1, 1), o), Catch::Contains("chord_tolerance_mm"));
  o = options();
  o.closing_share = std::nan("");
  CHECK_THROWS_WITH(sliced(box(0, 0, 0, 1, 1, 1), o), Catch::Contains("closing_share"));
  CHECK_THROWS_WITH(sliced(box(0, 0, 0, 1, 1, 1), options(0.0, -0.1)), Catch::Contains("layer_height_mm"));
  CHECK_THROWS_WITH(sliced(box(0, 0, 0, 1, 1, 200'000)), Catch::Contains("beyond the limit"));
  CHECK(sliced(box(0, 0, 0, 1, 1, 1), options(), on_platform()).layers.size() == 4);
}
