// Kinds of labs: who takes part, which keys a dump holds.
#include "config/labs.h"

#include <catch2/catch.hpp>
#include <set>

#include "config/fields.h"

using namespace firn;
using Catch::Contains;

TEST_CASE("An unknown kind of lab is named with the known ones") {
  CHECK_THROWS_WITH(lab_kind("laser"), Contains("lab.kind = \"laser\" is not one of inkjet, ice"));
  for (const LabKind* lab : lab_kinds()) CHECK(&lab_kind(lab->name) == lab);
}

TEST_CASE("An instrument takes part in its own lab only, and every other node in all labs") {
  Experiment inkjet, ice;
  ice.lab.kind = "ice";
  for (const char* node : {"stage", "jet", "lamp", "laser_profiler"}) {
    CHECK(takes_part(inkjet, node));
    CHECK_FALSE(takes_part(ice, node));
  }
  for (const char* node : {"robot", "valve_a", "valve_b", "heater", "path_planner"}) {
    CHECK(takes_part(ice, node));
    CHECK_FALSE(takes_part(inkjet, node));
  }
  for (const char* node : {"scheduler", "controller", "surface_mapper", "safety", "recorder"}) {
    CHECK(takes_part(inkjet, node));
    CHECK(takes_part(ice, node));
  }
}

TEST_CASE("The second jet takes part for two inks, the droplet estimator when it is switched on") {
  Experiment e;
  CHECK_FALSE(takes_part(e, "jet_b"));
  CHECK_FALSE(takes_part(e, "droplet_estimator"));
  e.geometry.solid.kind = "pipe";
  e.estimator.droplets = "on";
  CHECK(takes_part(e, "jet_b"));
  CHECK(takes_part(e, "droplet_estimator"));
}

TEST_CASE("A dump holds the keys of its own lab, and none of an instrument of another") {
  Experiment inkjet, ice;
  ice.lab.kind = "ice";
  const std::string a = dump(inkjet), b = dump(ice);
  for (const char* section : {"[stage]", "[jet]", "[lamp]", "[laser_profiler]", "[grid]"}) {
    CHECK_THAT(a, Contains(section));
    CHECK_THAT(b, !Contains(section));
  }
  for (const char* section : {"[robot]", "[valve_a]", "[valve_b]", "[heater]", "[plant.ice]"}) {
    CHECK_THAT(b, Contains(section));
    CHECK_THAT(a, !Contains(section));
  }
}

TEST_CASE("Every key belongs to at least one lab") {
  Experiment e;
  std::set<std::string> orphans;
  for (const Field& f : fields(e)) {
    const bool held = std::ranges::any_of(lab_kinds(), [&](const LabKind* lab) {
      return std::ranges::any_of(lab->keys, [&](std::string_view front) { return f.key.starts_with(front); });
    });
    if (!held) orphans.insert(std::string(f.key));
  }
  CHECK(orphans == std::set<std::string>{});
}
