// Layers in several sub-patterns and of two inks, printed by the scheduler through crashes.
#include <catch2/catch.hpp>

#include <set>

#include "tests/procs/fake_lab.h"

namespace firn {
namespace {

using test::FakeLab;

Experiment interlaced(int sub_patterns, bool two_inks) {
  Experiment e = test::small();
  e.process.sub_patterns = sub_patterns;
  if (two_inks) e.geometry.solid.kind = "pipe";
  return e;
}

std::set<int> doubtful_layers(const FakeLab& lab) {
  std::set<int> layers;
  for (const auto& r : lab.all(channels::kDepositionReport))
    if (r.unknown_to > r.unknown_from) layers.insert(r.layer);
  return layers;
}

void check_print(const FakeLab& lab, bool two_inks) {
  CHECK_FALSE(lab.both_armed);
  CHECK_FALSE(lab.wet_contact);
  CHECK_FALSE(lab.wrong_place);
  CHECK_FALSE(lab.beside_place);
  const std::set<int> doubtful = doubtful_layers(lab);
  for (int layer = 1; layer <= lab.layers; ++layer) {
    CAPTURE(layer);
    const auto cells = lab.droplets.find(layer);
    for (std::size_t c = 0; c < lab.planned.at(layer).size(); ++c) {
      const auto fired = cells == lab.droplets.end()             ? std::vector<Material>{}
                         : cells->second.count(std::uint32_t(c)) ? cells->second.at(std::uint32_t(c))
                                                                 : std::vector<Material>{};
      if (doubtful.count(layer))
        REQUIRE(int(fired.size()) <= lab.planned.at(layer).cells[c]);
      else
        REQUIRE(int(fired.size()) == lab.planned.at(layer).cells[c]);
      for (const Material ink : fired) REQUIRE(ink == (two_inks ? lab.inks.at(layer).of(c) : Material::kA));
    }
  }
}

TEST_CASE(
    "the passes of a layer fire its plan, each droplet once, by the jet of its ink, no sub-pattern on a wet "
    "one") {
  for (const int sub_patterns : {1, 2, 4})
    for (const bool two_inks : {false, true})
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        CAPTURE(sub_patterns, two_inks, seed);
        FakeLab lab(seed, interlaced(sub_patterns, two_inks));
        REQUIRE(lab.print(0.0) == 0);
        check_print(lab, two_inks);
      }
}

TEST_CASE("however often it crashes, no sub-pattern of either ink fires a droplet twice") {
  int crashes = 0, doubts = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const int sub_patterns = seed % 3 == 0 ? 1 : seed % 3 == 1 ? 2 : 4;
    const bool two_inks = seed % 2;
    CAPTURE(seed, sub_patterns, two_inks);
    FakeLab lab(seed, interlaced(sub_patterns, two_inks));
    crashes += lab.print(0.05);
    check_print(lab, two_inks);
    doubts += int(doubtful_layers(lab).size());
  }
  CHECK(crashes > 100);
  CHECK(doubts > 10);
}

TEST_CASE("droplets at places inside their cells are fired once each, however often the scheduler crashes") {
  int crashes = 0, doubts = 0, twice = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Experiment e = interlaced(seed % 3 == 0 ? 2 : 1, seed % 2);
    e.actuation.offsets = seed % 4 < 2 ? OffsetKind::kX : OffsetKind::kGrid;
    if (seed % 2 == 0) {  // so slow a jet that rows of near droplets take two runs
      e.process.pass_speed_mm_s = 7.0;
      e.jet.max_rate_hz = e.jet_b.drive.max_rate_hz = 30;
    }
    CAPTURE(seed);
    FakeLab lab(seed, e);
    crashes += lab.print(0.05);
    check_print(lab, seed % 2);
    doubts += int(doubtful_layers(lab).size());
    for (const stage_command_t& c : lab.all(channels::kStageCommand)) twice += c.apart_mm > 0.0;
  }
  CHECK(crashes > 50);
  CHECK(doubts > 5);
  CHECK(twice > 20);
}

TEST_CASE(
    "droplets of both sizes are fired once each, by a jet that was armed for their size, however often the "
    "scheduler crashes") {
  int small = 0, of_first = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Experiment e = interlaced(seed % 3 == 0 ? 2 : 1, false);
    e.actuation.offsets = OffsetKind::kX;
    e.actuation.small_share = 0.45;
    CAPTURE(seed);
    FakeLab lab(seed, e);
    lab.print(seed % 2 ? 0.05 : 0.0);
    check_print(lab, false);
    CHECK_FALSE(lab.other_size);
    small += lab.small_drops;
    for (const auto& [layer, cells] : lab.droplets) of_first += int(cells.size());
  }
  CHECK(small > 100);
  CHECK(of_first > small);
}

TEST_CASE("A plan with a place beyond the table stops the print, and the fault names the cell") {
  Experiment e = interlaced(1, false);
  e.actuation.offsets = OffsetKind::kX;
  FakeLab lab(5, e);
  lab.begin(0);
  while (lab.all(channels::kLayerMetrics).empty() && lab.serve(0.0)) {
  }
  layer_plan_t p{};
  p.layer = 1;
  p.map_id = lab.map_id;
  set_drops(p, DropletPattern(lab.experiment.grid, 1));
  OffsetMap map(lab.experiment.grid);
  map.at(2, 1) = 5;
  set_offsets(p, map);
  lab.give(channels::kLayerPlan, p);
  CHECK(lab.all(channels::kJetCommand).empty());
  CHECK(lab.last(channels::fault(NodeId::kScheduler)).text.find("cell (2, 1) is 5") != std::string::npos);
}

TEST_CASE("each report of an interlaced layer says what pass it was, and one cure follows each sub-pattern") {
  FakeLab lab(3, interlaced(4, true));
  REQUIRE(lab.print(0.0) == 0);
  const auto reports = lab.all(channels::kDepositionReport);
  REQUIRE_FALSE(reports.empty());
  int cures = 0;
  for (const deposition_report_t& r : reports) {
    CHECK(r.pass_index < r.passes);
    CHECK(r.sub_patterns == 4);
    cures += r.cured;
    for (std::size_t c = 0; c < r.drops.size(); ++c) {
      if (!r.drops[c]) continue;
      const int nx = lab.experiment.grid.nx;
      CHECK(sub_pattern_of(int(c) % nx, int(c) / nx, 4) == r.sub_pattern);
      CHECK(lab.inks.at(r.layer).of(c) == Material(r.material));
      CHECK(lab.planned.at(r.layer).cells[c] > r.round);
    }
  }
  std::int64_t exposures = 0;
  for (const auto& s : lab.sent) exposures += s.channel == "LAMP_COMMAND";
  CHECK(exposures == cures);
}

TEST_CASE("one pattern of one ink is told as one round a pass, each cured, nothing for the second jet") {
  FakeLab lab(3, interlaced(1, false));
  REQUIRE(lab.print(0.0) == 0);
  const auto reports = lab.all(channels::kDepositionReport);
  REQUIRE_FALSE(reports.empty());
  for (const deposition_report_t& r : reports) {
    CHECK(Material(r.material) == Material::kA);
    CHECK(r.round == r.pass_index);
    CHECK(r.sub_pattern == 0);
    CHECK(r.sub_patterns == 1);
    CHECK(r.cured == 1);
  }
  CHECK(lab.all(channels::kJetBCommand).empty());
}

TEST_CASE("the stage is sent the cells that a pass fires, and no others") {
  FakeLab lab(3, interlaced(1, false));
  REQUIRE(lab.print(0.0) == 0);
  const auto reports = lab.all(channels::kDepositionReport);
  std::size_t passes = 0;
  for (const stage_command_t& c : lab.all(channels::kStageCommand)) {
    if (StageVerb(c.verb) != StageVerb::kPass) continue;
    REQUIRE(passes < reports.size());
    CHECK(c.fires == reports[passes++].drops);
  }
  CHECK(passes == reports.size());
}

TEST_CASE("a plan without inks stops a print of two inks, and the fault says so") {
  FakeLab lab(5, interlaced(1, true));
  lab.begin(0);
  while (lab.all(channels::kLayerMetrics).empty() && lab.serve(0.0)) {
  }
  layer_plan_t p{};
  p.layer = 1;
  p.map_id = lab.map_id;
  set_drops(p, DropletPattern(lab.experiment.grid, 1));
  lab.give(channels::kLayerPlan, p);
  CHECK(lab.all(channels::kJetCommand).empty());
  CHECK(lab.last(channels::fault(NodeId::kScheduler)).text.find("names no inks") != std::string::npos);
}

TEST_CASE("a cell with droplets and no ink stops the print") {
  FakeLab lab(5, interlaced(1, true));
  lab.begin(0);
  while (lab.all(channels::kLayerMetrics).empty() && lab.serve(0.0)) {
  }
  layer_plan_t p{};
  p.layer = 1;
  p.map_id = lab.map_id;
  set_drops(p, DropletPattern(lab.experiment.grid, 1));
  set_materials(p, MaterialMap(lab.experiment.grid));
  lab.give(channels::kLayerPlan, p);
  CHECK(lab.all(channels::kJetCommand).empty());
  CHECK(lab.last(channels::fault(NodeId::kScheduler)).text.find("of no ink") != std::string::npos);
}

}  // namespace
}  // namespace firn
