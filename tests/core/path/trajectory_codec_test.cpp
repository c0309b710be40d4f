#include "core/path/trajectory_codec.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/grid/random.h"

using namespace firn;
using Catch::Contains;

namespace {

TrajectoryHead some_head() {
  return {"cobra600",     "certified",        "firn test",         0.016,
          {354.0, -46.0}, {"J1", "J2", "J3"}, {"rad", "rad", "mm"}};
}

PlannedPath some_path(RandomStream& random, std::size_t samples) {
  PlannedPath p{7, 1, PathKind::kBoundary, 12.5, {}};
  p.trajectory = {42, 0.016,
                  3,  {"rad", "rad", "mm"},
                  {}, {{{"total speed", 0.98, 1.25}, {"J1 jerk", 1.0, 0.5}}, 1.25, 1.2, 0.4}};
  for (std::size_t n = 0; n < samples; ++n)
    for (double v : {random.uniform(-2, 2), random.normal() * 1e-7, 31.25})
      p.trajectory.positions.push_back(v);
  return p;
}

void check_equal(const PlannedPath& a, const PlannedPath& b) {
  CHECK(a.layer == b.layer);
  CHECK(a.material == b.material);
  CHECK(a.kind == b.kind);
  CHECK(a.path_mm == b.path_mm);
  CHECK(a.trajectory.id == b.trajectory.id);
  CHECK(a.trajectory.axes == b.trajectory.axes);
  CHECK(a.trajectory.tick_s == b.trajectory.tick_s);
  CHECK(a.trajectory.axis_units == b.trajectory.axis_units);
  REQUIRE(a.trajectory.positions.size() == b.trajectory.positions.size());
  for (std::size_t n = 0; n < a.trajectory.positions.size(); ++n)  // bit for bit, for any bits
    REQUIRE(std::memcmp(&a.trajectory.positions[n], &b.trajectory.positions[n], sizeof(double)) == 0);
  const Certificate &c = a.trajectory.certificate, &d = b.trajectory.certificate;
  CHECK(c.duration_s == d.duration_s);
  CHECK(c.lower_bound_s == d.lower_bound_s);
  CHECK(c.curvature_ramp_mm == d.curvature_ramp_mm);
  REQUIRE(c.limits.size() == d.limits.size());
  for (std::size_t n = 0; n < c.limits.size(); ++n) {
    CHECK(c.limits[n].limit == d.limits[n].limit);
    CHECK(c.limits[n].ratio == d.limits[n].ratio);
    CHECK(c.limits[n].time_s == d.limits[n].time_s);
  }
}

std::string refusal(std::span<const std::byte> bytes) {
  try {
    decode_trajectory(bytes, some_head());
  } catch (const TrajectoryFormatError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE(
    "Head, trajectories and totals read back to the same bits, and an axis that stands still takes one "
    "number") {
  RandomStream random(81, Purpose::kTest);
  const TrajectoryHead head = some_head();
  CHECK(decode_trajectory_head(encode(head)) == head);
  const TrajectoryTotals totals{3, 1234, 56.78};
  CHECK(decode_trajectory_totals(encode(totals)) == totals);
  for (std::size_t samples : {std::size_t(0), std::size_t(1), std::size_t(2), std::size_t(500)}) {
    const PlannedPath path = some_path(random, samples);
    const std::vector<std::byte> bytes = encode(path);
    check_equal(decode_trajectory(bytes, head), path);
    if (samples > 10) CHECK(bytes.size() < samples * 16 + 200);  // two of three axes move
  }
}

TEST_CASE("Bytes that are cut, changed or too many are refused with the offset, and nothing crashes") {
  RandomStream random(82, Purpose::kTest);
  const std::vector<std::byte> good = encode(some_path(random, 20));
  for (std::size_t n = 0; n < good.size(); ++n)
    CHECK_THAT(refusal(std::span(good).first(n)), Contains("byte "));
  std::vector<std::byte> longer = good;
  longer.push_back(std::byte{0});
  CHECK_THAT(refusal(longer), Contains("1 bytes are left over"));
  for (int trial = 0; trial < 20000; ++trial) {
    std::vector<std::byte> changed = good;
    for (std::uint32_t n = 1 + random.below(4); n > 0; --n)
      changed[random.below(std::uint32_t(changed.size()))] = std::byte(random.below(256));
    try {
      const PlannedPath p = decode_trajectory(changed, some_head());
      for (double v : p.trajectory.positions) REQUIRE(std::isfinite(v));
    } catch (const TrajectoryFormatError&) {
    }
  }
  PlannedPath bad = some_path(random, 20);
  bad.trajectory.positions[5] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(refusal(encode(bad)), Contains("position is not a number"));
  bad = some_path(random, 20);
  bad.trajectory.axes = 2;
  CHECK_THAT(refusal(encode(bad)), Contains("2 axes, but the file has 3"));
  bad.trajectory.positions.pop_back();
  CHECK_THROWS_AS(encode(bad), std::invalid_argument);
}

TEST_CASE("A version of tomorrow and counts above their limits are refused by name") {
  std::vector<std::byte> head = encode(some_head());
  head[0] = std::byte{2};
  CHECK_THROWS_WITH(decode_trajectory_head(head), Contains("version 2 is unknown"));
  RandomStream random(83, Purpose::kTest);
  std::vector<std::byte> path = encode(some_path(random, 3));
  const std::size_t limits_at = 8 + 4 + 1 + 1 + 2 + 4 * 8;
  path[limits_at + 1] = std::byte{9};
  CHECK_THAT(refusal(path), Contains("byte " + std::to_string(limits_at)) && Contains("limit of 64"));
}
