#include <catch2/catch.hpp>

#include "core/geometry/planar.h"
#include "core/geometry/tolerant_boolean.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/support/scaffold.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

constexpr std::int32_t kScaffoldHeight = 2500;
constexpr double kScaffoldTolerance = 0.05;

struct Part {
  std::string name;
  std::vector<geometry::Region> layers;
};

Part scaffold_ball() {
  Part part{"ball", {}};
  for (int k = 0; k < 40; ++k) {
    geometry::Region layer;
    const double z = (k + 0.5) / 20 - 1;
    outlines::add_circle(layer, 0, 0, 12 * std::sqrt(1 - z * z), 80);
    part.layers.push_back(layer);
  }
  return part;
}

// Widens downward by more than the buffer at a step; an arm that hangs in the air; a hole that closes.
Part steps() {
  Part part{"steps", {}};
  for (int k = 0; k < 24; ++k) {
    geometry::Region layer;
    if (k < 8) {
      outlines::add_box(layer, -20, -20, 20, 20);
      outlines::add_box(layer, -6, -6, 6, 6, true);
    } else if (k < 16) {
      outlines::add_box(layer, -9, -9, 9, 9);
    } else {
      outlines::add_box(layer, -9, -4, 34, 4);
      outlines::add_circle(layer, 0, 30, 3, 24);
    }
    part.layers.push_back(layer);
  }
  return part;
}

// Every outline crosses the one above many times.
Part wobble() {
  Part part{"wobble", {}};
  for (std::uint64_t k = 0; k < 20; ++k) part.layers.push_back(outlines::random_star(70 + k, 40, 10, 16));
  return part;
}

Part prism() { return {"prism", std::vector<geometry::Region>(12, outlines::gear())}; }

bool in_any(std::span<const geometry::Region> layers, std::size_t from, geometry::Point p) {
  for (std::size_t k = from; k < layers.size(); ++k)
    if (winding(layers[k], p) > 0) return true;
  return false;
}

double distance_above_mm(std::span<const geometry::Region> layers, std::size_t from, geometry::Point p) {
  if (in_any(layers, from, p)) return 0;
  double best = 1e300;
  for (std::size_t k = from; k < layers.size(); ++k)
    best = std::min(best, oracle::distance_to_all(to_vec(p), oracle::segments_of(layers[k])));
  return best * geometry::kMmPerUnit;
}

TEST_CASE(
    "Full scaffold: within 3.3 mm of ice at its height or above, everywhere up to there, and nowhere in "
    "ice") {
  for (const Part& part : {scaffold_ball(), steps(), wobble(), prism()}) {
    INFO(part.name);
    const std::vector<geometry::Region> scaffold =
        scaffold_regions(part.layers, kScaffoldHeight, {}, kScaffoldTolerance);
    REQUIRE(scaffold.size() == part.layers.size());
    for (std::size_t k = 0; k < part.layers.size(); k += 3) {
      INFO("layer " << k);
      CHECK(!first_contact(scaffold[k]));
      for (double x = -41.037; x < 42; x += 1.71) {
        for (double y = -41.013; y < 42; y += 1.63) {
          const geometry::Point p = outlines::at_mm(x, y);
          const bool stands = winding(scaffold[k], p) > 0, ice = winding(part.layers[k], p) > 0;
          const double d = distance_above_mm(part.layers, k, p);
          if (stands) CHECK((!ice && d <= 3.3));
          if (!ice && d < 3.3 - 4.5 * kScaffoldTolerance - 0.01) CHECK(stands);
        }
      }
      // No place of its outline is further than the buffer either.
      for (const geometry::Vec p : oracle::along(scaffold[k], 5000))
        CHECK(distance_above_mm(part.layers, k, geometry::to_point(p)) <= 3.3);
    }
  }
}

TEST_CASE(
    "With full scaffold every ice boundary has scaffold beside it, and what overhangs stands on ice or "
    "scaffold") {
  for (const Part& part : {scaffold_ball(), steps(), wobble(), prism()}) {
    INFO(part.name);
    const std::vector<geometry::Region> scaffold =
        scaffold_regions(part.layers, kScaffoldHeight, {}, kScaffoldTolerance);
    for (std::size_t k = 0; k < part.layers.size(); ++k) {
      for (const oracle::Segment& s : oracle::segments_of(part.layers[k])) {
        const geometry::Vec m = 0.5 * (s.a + s.b),
                            out = (50 / length(s.b - s.a)) * (geometry::Vec{} - left_of(s.b - s.a));
        const geometry::Point beside = geometry::to_point(m + out);
        CHECK((winding(scaffold[k], beside) > 0 || winding(part.layers[k], beside) > 0));
        if (k == 0) continue;
        const geometry::Point inside = geometry::to_point(m - out);
        if (winding(part.layers[k], inside) > 0)
          CHECK((winding(scaffold[k - 1], inside) > 0 || winding(part.layers[k - 1], inside) > 0));
      }
    }
  }
}

TEST_CASE(
    "Overhang scaffold carries what leans out further than its angle, down to ice or ground, and nothing "
    "else") {
  const Part part = steps();
  SupportOptions options{.kind = Support::kOverhang, .buffer_mm = 1.0};
  const std::vector<geometry::Region> scaffold =
      scaffold_regions(part.layers, kScaffoldHeight, options, kScaffoldTolerance);
  const geometry::Point under_arm = outlines::at_mm(25, 0), over_plate = outlines::at_mm(14, 0),
                        beside = outlines::at_mm(-15, 0);
  CHECK(winding(scaffold[15], under_arm) > 0);
  CHECK(winding(scaffold[0], under_arm) > 0);
  CHECK(winding(scaffold[15], over_plate) > 0);
  CHECK(winding(scaffold[8], over_plate) > 0);
  CHECK(winding(scaffold[7], over_plate) == 0);
  CHECK(winding(scaffold[3], outlines::at_mm(0, 0)) > 0);  // the lid over the hole
  CHECK(winding(scaffold[10], beside) == 0);
  for (const geometry::Region& layer : scaffold_regions(
           scaffold_ball().layers, kScaffoldHeight, {.kind = Support::kOverhang, .overhang_rad = 1.5}, 0.05))
    CHECK(area_mm2(layer) < 500);
}

TEST_CASE("No support, no part: no scaffold") {
  CHECK(scaffold_regions({}, kScaffoldHeight, {}, kScaffoldTolerance).empty());
  for (const geometry::Region& layer : scaffold_regions(scaffold_ball().layers, kScaffoldHeight,
                                                        {.kind = Support::kNone}, kScaffoldTolerance))
    CHECK(layer.empty());
}

TEST_CASE("Merging with no slack is the union") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    INFO("seed " << seed);
    const geometry::Region a = outlines::random_star(seed, 30, 5, 30),
                           b = outlines::random_star(seed + 100, 25, 5, 30);
    const geometry::Region merged = union_within(a, b, 0), united = unite(a, b);
    CHECK(area_mm2(merged) == Approx(area_mm2(united)).epsilon(1e-6));
  }
  const geometry::Region gear = outlines::gear();
  CHECK(area_mm2(union_within(gear, gear, 0)) == Approx(area_mm2(gear)).epsilon(1e-9));
  geometry::Region box, inner, window, apart, beside;
  outlines::add_box(box, 0, 0, 20, 20);
  outlines::add_box(inner, 5, 5, 10, 10);
  outlines::add_box(apart, 30, 0, 35, 5);
  outlines::add_box(beside, 20, 0, 30, 20);  // shares an edge
  window = box;
  outlines::add_box(window, 2, 2, 12, 12, true);
  CHECK(area_mm2(union_within(box, inner, 0)) == Approx(400));
  CHECK(area_mm2(union_within(inner, box, 0)) == Approx(400));
  CHECK(area_mm2(union_within(box, apart, 0)) == Approx(425));
  CHECK(area_mm2(union_within(box, beside, 0)) == Approx(600));
  CHECK(area_mm2(union_within(window, inner, 0)) == Approx(325));
  CHECK(area_mm2(union_within(window, box, 0)) == Approx(400));
  CHECK(area_mm2(union_within({}, box, 0)) == Approx(400));
  CHECK(area_mm2(union_within(box, {}, 0)) == Approx(400));
}

TEST_CASE(
    "What a layer sticks out by less than the slack comes later: errors do not pile up over a thousand "
    "layers") {
  const std::int32_t slack = 250;
  geometry::Region merged, plug_hole;
  double radius = 10;
  for (int k = 0; k < 1000; ++k, radius += 0.003) {
    geometry::Region layer;
    outlines::add_circle(layer, 0.01 * std::sin(k), 0, radius, 90, false, 0.001 * k);
    merged = union_within(merged, layer, slack);
    if (k % 50) continue;
    for (const geometry::Point p : layer.points) {
      if (winding(merged, p) > 0) continue;
      CHECK(oracle::distance_to_all(to_vec(p), oracle::segments_of(merged)) <= slack + 2);
    }
    CHECK(merged.size() == 1);
    CHECK(merged.points.size() < 600);
  }
  // A plug that fits its hole within the slack is not slight.
  outlines::add_box(plug_hole, 0, 0, 30, 30);
  outlines::add_circle(plug_hole, 15, 15, 8, 60, true);
  geometry::Region plug;
  outlines::add_circle(plug, 15, 15, 8.001, 57);
  CHECK(area_mm2(union_within(plug_hole, plug, slack)) == Approx(900).margin(1));
}

}  // namespace
}  // namespace firn::slice
