#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "plant/ice/nature.h"
#include "tests/support/ice_paths.h"

using namespace firn;
using namespace firn::plant;

namespace {

IceWorldConfig small_bed() {
  IceWorldConfig c;
  c.field = {0.3, -25.0, -25.0, 50.0, 50.0};
  return c;
}

ice_paths::Run nature_line(const IceWorldConfig& c, double y_mm, double z_mm, double speed = 60.0) {
  return ice_paths::along(
      c.arm, c.arm.valve_a, {{-15.0, y_mm}, {15.0, y_mm}}, z_mm, speed, 1.5, [](double) { return 0.25; },
      ice_paths::calibrated_late_s(c, 0));
}

std::vector<std::byte> bytes_of(IceNature& nature) {
  Archive a;
  nature.io(a);
  return a.bytes();
}

}  // namespace

TEST_CASE("A straight bead lies where its path was, with the volume per length of its flow and speed") {
  IceWorldConfig c = small_bed();
  c.disturbance = {};
  c.disturbance.debris_per_h = c.disturbance.roughness = c.disturbance.pattern = 0.0;
  c.table.roughness_mm = 0.0;
  for (auto& line : c.line) line.pulsation = 0.0;
  for (auto& bead : c.bead) bead.wander_rad = bead.scatter_mm = 0.0;
  IceNature nature(c, 1);
  ice_paths::print(nature, c, nature_line(c, 4.0, 3.24), 0, 1'000'000);
  const Bed& bed = nature.bed();
  double volume = 0.0, moment_x = 0.0, moment_y = 0.0, section = 0.0;
  for (int j = 0; j < bed.height(); ++j)
    for (int i = 0; i < bed.width(); ++i) {
      const double v = bed.z_mm(i, j);
      volume += v;
      moment_x += v * bed.centre_x_mm(i);
      moment_y += v * bed.centre_y_mm(j);
      if (std::abs(bed.centre_x_mm(i)) < 10.0) section += v;
    }
  CHECK(moment_x / volume ==
        Approx(0.0).margin(0.35));  // a drop on the end of its bead runs a little ahead of it
  CHECK(moment_y / volume == Approx(4.0).margin(0.1));
  CHECK(section * bed.cell_mm() * bed.cell_mm() / 20.0 == Approx(0.36).epsilon(0.04));
}

TEST_CASE("What happens does not depend on how often nature is caught up with") {
  const IceWorldConfig c = small_bed();
  IceNature coarse(c, 3), fine(c, 3);
  for (IceNature* nature : {&coarse, &fine}) {
    const auto run = nature_line(c, -3.0, 3.24);
    nature->arm().place(run.points.front());
    nature->arm().follow(run.points, 0.016, 0.012);
    Firing list;
    list.ticks = run.ticks;
    nature->trigger_valve(0, 0.0, std::move(list));
    nature->begin_storage(0.001, 0.01, 50, LaserSettings::kIce);
  }
  RandomStream random(3, Purpose::kTest);
  for (std::int64_t t_us = 0; t_us < 8'000'000; t_us += 1 + random.below(3000)) fine.catch_up(t_us);
  fine.catch_up(8'000'000);
  coarse.catch_up(8'000'000);
  CHECK(bytes_of(fine) == bytes_of(coarse));
}

TEST_CASE("A nature that was saved in the middle of a path goes on bit for bit") {
  const IceWorldConfig c = small_bed();
  IceNature whole(c, 4);
  const auto run = nature_line(c, 2.0, 3.24);
  whole.arm().place(run.points.front());
  whole.arm().follow(run.points, 0.016, 0.012);
  Firing list;
  list.ticks = run.ticks;
  whole.trigger_valve(0, 0.0, std::move(list));
  whole.catch_up(300'000);
  IceNature again(c, 4);
  Archive saved(bytes_of(whole));
  again.io(saved);
  saved.expect_end();
  for (IceNature* nature : {&whole, &again}) {
    nature->catch_up(5'000'000);
    nature->catch_up(20'000'000);
  }
  CHECK(bytes_of(again) == bytes_of(whole));
}

TEST_CASE("Two seeds print different surfaces, one seed the same") {
  const IceWorldConfig c = small_bed();
  const auto surface = [&](std::uint64_t seed) {
    IceNature nature(c, seed);
    ice_paths::print(nature, c, nature_line(c, 0.0, 3.24), 0, 1'000'000);
    return nature.bed().mean_over({40, 40, 1.0, 1.0, -19.5, -19.5}).cells;
  };
  CHECK(surface(1) == surface(1));
  CHECK(surface(1) != surface(2));
}

TEST_CASE("A valve that is closed in the middle of a list fires no more, and the last pulse is known") {
  const IceWorldConfig c = small_bed();
  IceNature nature(c, 1);
  const auto run = nature_line(c, 0.0, 3.24);
  nature.arm().place(run.points.front());
  Firing list;
  list.ticks = run.ticks;
  nature.trigger_valve(0, 1.0, std::move(list));
  nature.catch_up(1'300'000);
  const Firing done = nature.close_valve(0);
  nature.catch_up(9'000'000);
  CHECK(nature.last_pulse_us(0) <= 1'300'000);
  CHECK(nature.last_pulse_us(0) == done.last_us);
  CHECK(done.next > 0);
  CHECK(done.next < run.ticks.size());
  CHECK(nature.pulses(0) == std::int64_t(done.next));
  CHECK(nature.last_pulse_us(1) == -1);
}

TEST_CASE(
    "A nozzle that goes through what was printed is recorded as a collision, one that clears it is not") {
  IceWorldConfig c = small_bed();
  IceNature nature(c, 1);
  std::int64_t t_us = 1'000'000;
  for (int layer = 0; layer < 6; ++layer)
    t_us = ice_paths::print(nature, c, nature_line(c, 0.0, 3.24 + 0.24 * layer), 0, t_us) + 100'000;
  CHECK(nature.collisions().contacts == 0);
  const double top_mm = nature.bed().highest_mm();
  for (const double z_mm : {top_mm + 0.2, 0.5 * top_mm}) {
    auto across = ice_paths::along(
        c.arm, c.arm.valve_a, {{0.0, -10.0}, {0.0, 10.0}}, z_mm, 40.0, 1.5, [](double) { return 0.25; }, 0.0);
    across.ticks.clear();
    t_us = ice_paths::print(nature, c, across, 0, t_us) + 100'000;
    CHECK((nature.collisions().contacts > 0) == (z_mm < top_mm));  // both nozzles pass, one after the other
  }
  CHECK(nature.collisions().deepest_mm > 0.2 * top_mm);
  CHECK(std::abs(nature.collisions().y_mm) < 2.0);
}

TEST_CASE("The jet scatters more the higher the nozzle stands above the surface") {
  const auto spread = [](double gap_mm) {
    IceWorldConfig c = small_bed();
    c.disturbance.debris_per_h = c.disturbance.roughness = c.disturbance.pattern = 0.0;
    c.table.roughness_mm = 0.0;
    IceNature nature(c, 2);
    ice_paths::print(nature, c, nature_line(c, 0.0, gap_mm), 0, 1'000'000);
    double volume = 0.0, square = 0.0;
    const Bed& bed = nature.bed();
    for (int j = 0; j < bed.height(); ++j)
      for (int i = 0; i < bed.width(); ++i)
        if (std::abs(bed.centre_x_mm(i)) < 12.0) {
          volume += bed.z_mm(i, j);
          square += bed.z_mm(i, j) * bed.centre_y_mm(j) * bed.centre_y_mm(j);
        }
    return std::sqrt(square / volume);
  };
  CHECK(spread(12.0) > 1.3 * spread(2.0));
}

TEST_CASE("Frozen and dead valves are told apart from closed ones: pulses without volume") {
  IceWorldConfig c = small_bed();
  c.heat.start_degC = -5.0;
  IceNature frozen(c, 1);
  ice_paths::print(frozen, c, nature_line(c, 0.0, 3.24), 0, 1000);
  CHECK(frozen.dead_pulses() == frozen.pulses(0));
  CHECK(frozen.bed().volume_mm3() == 0.0);
  IceNature dead(small_bed(), 1);
  dead.break_valve(0, true);
  ice_paths::print(dead, c, nature_line(c, 0.0, 3.24), 0, 1000);
  CHECK(dead.pulses(0) > 10);
  CHECK(dead.dead_pulses() == dead.pulses(0));
}

TEST_CASE(
    "A valve that stays open lets out its flow from its next pulse on until it is mended, and counts "
    "pulses") {
  IceWorldConfig c = small_bed();
  c.disturbance.debris_per_h = 0.0;
  IceNature sound(c, 1), jammed(c, 1);
  jammed.jam_valve(0, true);
  jammed.catch_up(5'000'000);
  CHECK(jammed.bed().volume_mm3() == 0.0);  // not before it has opened
  const std::int64_t begin_us = 6'000'000;
  const std::int64_t end_us = ice_paths::print(sound, c, nature_line(c, 0.0, 3.24), 0, begin_us);
  CHECK(ice_paths::print(jammed, c, nature_line(c, 0.0, 3.24), 0, begin_us) == end_us);
  CHECK(jammed.pulses(0) == sound.pulses(0));
  sound.catch_up(end_us + 1'000'000);
  jammed.catch_up(end_us + 1'000'000);
  const double at_rest_mm3 = jammed.bed().volume_mm3();
  CHECK(at_rest_mm3 > 3.0 * sound.bed().volume_mm3());
  jammed.catch_up(end_us + 3'000'000);
  // The card's full flow, within what pressure and coil make of it.
  CHECK(jammed.bed().volume_mm3() - at_rest_mm3 == Approx(2.0 * c.line[0].full_flow_mm3_s).epsilon(0.3));
  jammed.jam_valve(0, false);
  const double closed_mm3 = jammed.bed().volume_mm3();
  jammed.catch_up(end_us + 9'000'000);
  CHECK(jammed.bed().volume_mm3() == closed_mm3);
  CHECK(jammed.firing(1).volume_mm3 == 0.0);
}

TEST_CASE("The laser's storage is what single readings along the motion would be, at its own clock") {
  IceWorldConfig c = small_bed();
  c.laser.ice_noise_mm = c.laser.scaffold_noise_mm = c.laser.repeatability_mm = 0.0;
  c.table.jigs.push_back({-5.0, -25.0, 5.0, 25.0, 2.0});
  IceNature nature(c, 1);
  const auto run = ice_paths::along(
      c.arm, c.arm.laser, {{-20.0, 0.0}, {20.0, 0.0}}, 1.0, 50.0, 1.5, [](double) { return 0.25; }, 0.0);
  nature.arm().place(run.points.front());
  nature.arm().follow(run.points, 0.016, 0.0125);
  nature.begin_storage(0.0008, 0.01, 70, LaserSettings::kIce);
  nature.catch_up(2'000'000);
  const Storage& s = nature.storage();
  REQUIRE(s.mm.size() == 70);
  CHECK_FALSE(s.active);
  int up = -1;
  for (std::size_t n = 1; n < s.mm.size(); ++n)
    if (s.mm[n] > 0.0 && s.mm[n - 1] < 0.0) up = int(n);
  REQUIRE(up > 0);
  // The laser passes x = -5 when the reference did, plus start delay and servo lag.
  const double ramp_s = 0.1,
               at_s = ramp_s + (15.0 - 0.5 * 50.0 * ramp_s) / 50.0 + 0.0125 + 2.0 / (2.0 * 3.14159265 * 20.0);
  CHECK(s.trigger_s + up * s.period_s == Approx(at_s + 0.5 * s.period_s).margin(0.5 * s.period_s + 0.003));
}
