#include "lcmtypes/convert.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/grid/random.h"
#include "firn/fault_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/validate.h"

using namespace firn;
using Catch::Contains;

namespace {

PlannedPath some_path() {
  RandomStream random(91, Purpose::kTest);
  PlannedPath p{12, 1, PathKind::kMeasurement, 0.0, {}};
  p.trajectory = {
      3, 0.016, 2, {"rad", "mm"}, {}, {{{"total jerk", 0.999, 1.5}, {"J1 rate", 0.5, 0.25}}, 1.6, 1.5, 0.4}};
  for (int n = 0; n < 200; ++n) p.trajectory.positions.push_back(random.uniform(-3, 3));
  return p;
}

std::vector<std::byte> bytes_of(const trajectory_t& m) {
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

trajectory_t some_message() {
  trajectory_t m = to_message(some_path());
  m.header.seq = 1;
  return m;
}

}  // namespace

TEST_CASE("A trajectory goes through its message with every bit and its certificate") {
  const PlannedPath path = some_path();
  const std::vector<std::byte> bytes = bytes_of(some_message());
  trajectory_t received{};
  REQUIRE(received.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()));
  const PlannedPath back = from_message(received);
  CHECK(back.layer == path.layer);
  CHECK(back.material == path.material);
  CHECK(back.kind == path.kind);
  CHECK(back.trajectory.id == path.trajectory.id);
  CHECK(back.trajectory.tick_s == path.trajectory.tick_s);
  CHECK(back.trajectory.axis_units == path.trajectory.axis_units);
  CHECK(back.trajectory.positions == path.trajectory.positions);
  CHECK(back.trajectory.certificate.duration_s == 1.6);
  CHECK(back.trajectory.certificate.lower_bound_s == 1.5);
  REQUIRE(back.trajectory.certificate.limits.size() == 2);
  CHECK(back.trajectory.certificate.limits[0].limit == "total jerk");
  CHECK(back.trajectory.certificate.limits[0].ratio == 0.999);
  CHECK(back.trajectory.certificate.limits[1].time_s == 0.25);
}

TEST_CASE("A trajectory message outside its limits is refused by member, value and limit") {
  const auto said = [](auto change) {
    trajectory_t m = some_message();
    change(m);
    return validate("TRAJECTORY", "trajectory_t", bytes_of(m)).value_or("");
  };
  CHECK(said([](trajectory_t&) {}) == "");
  CHECK_THAT(said([](trajectory_t& m) { m.samples = 99; }), Contains("n = 200 is not samples * axes = 198"));
  CHECK_THAT(said([](trajectory_t& m) { m.position[7] = std::nan(""); }), Contains("position"));
  CHECK_THAT(said([](trajectory_t& m) { m.tick_s = 0; }), Contains("tick_s = 0"));
  CHECK_THAT(said([](trajectory_t& m) { m.kind = 4; }), Contains("kind = 4 is outside 0..3"));
  CHECK_THAT(said([](trajectory_t& m) { m.ratio[0] = -1; }), Contains("ratio"));
}

TEST_CASE("A figure goes through its message, and a number that is not finite counts as not known") {
  const Figure whole{-0.125, 0.5, "mm", "ice.clearance_mm"}, bare{};
  for (const Figure& f : {whole, bare, Figure{3.0, {}, "us"}}) {
    const Figure back = from_message(to_message(f));
    CHECK(back.value == f.value);
    CHECK(back.limit == f.limit);
    CHECK(back.unit == f.unit);
    CHECK(back.key == f.key);
  }
  const figure_t m = to_message(Figure{kNotMeasured, std::numeric_limits<double>::infinity(), "mm"});
  CHECK(m.known == 0);
  CHECK(m.value == 0.0);
  CHECK(m.limit == 0.0);
  fault_t fault{};
  fault.header.run_id = fault.header.seq = 1;
  fault.node = "stage";
  fault.figure = to_message(whole);
  const auto problem = [&] {
    std::vector<std::byte> bytes(std::size_t(fault.getEncodedSize()));
    fault.encode(bytes.data(), 0, int(bytes.size()));
    return validate(*find_channel("FAULT_STAGE"), bytes).value_or("");
  };
  CHECK(problem() == "");
  fault.figure.value = kNotMeasured;
  CHECK_THAT(problem(), Contains("figure.value"));
  fault.figure.value = 0.0;
  fault.figure.known = 4;
  CHECK_THAT(problem(), Contains("figure.known"));
}
