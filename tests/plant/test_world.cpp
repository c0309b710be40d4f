#include <catch2/catch.hpp>

#include <unistd.h>
#include <cmath>
#include <filesystem>

#include "core/grid/random.h"
#include "tests/plant/bench_lines.h"

using namespace firn;
using namespace firn::plant;

namespace {

WorldConfig small_world(const char* model = "droplets") {
  WorldConfig c;
  c.grid = {12, 12, 0.263256, 0.263256, 0.0, 0.0};
  c.model = model;
  c.seed = 11;
  return c;
}

std::filesystem::path scratch(const char* name) {
  return std::filesystem::temp_directory_path() /
         (std::string("firn_plant_") + name + "_" + std::to_string(::getpid()));
}

std::string scan_and_read(Bench& b) {
  b.stage("PSOCONTROL @0 OFF");
  go(b, "LINEAR @0 0 @1 -1 F100");
  for (const char* line :
       {"PSOCONTROL @1 RESET", "PSOOUTPUT @1 PULSE", "PSODISTANCE @1 FIXED 1.2 UNITS", "PSOCONTROL @1 ARM"})
    b.stage(line);
  go(b, "LINEAR @1 2 F20");
  return b.ask(kProfilerPort,
               hex("20000000 0100F000 00000000 14000000 42000000 00000000 00000000 01000000 01010000"));
}

}  // namespace

TEST_CASE("A layer printed through bytes lands where the pattern says and is on record droplet by droplet") {
  for (const char* model : {"droplets", "lu2015"}) {
    Bench b(small_world(model));
    start_stage(b);
    start_jet(b);
    print_layer(b, 8, 6);
    const Truth truth = b.world.truth();
    CHECK(truth.droplets_fired == 48);
    CHECK(truth.triggers_gated == 0);
    CHECK(truth.exposures == 1);
    REQUIRE(b.record.history.shots.size() == 48);
    double volume = 0.0;
    for (std::size_t n = 0; n < 48; ++n) {
      const ShotRecord& s = b.record.history.shots[n];
      const int j = int(n) / 8, i = j % 2 == 0 ? int(n) % 8 : 7 - int(n) % 8;
      CHECK((s.i == i && s.j == j));
      CHECK(s.x_mm == Approx(b.world.config().grid.x_mm(i)).margin(1e-4));
      volume += s.volume_mm3;
    }
    CHECK(volume == Approx(truth.ledger.landed).epsilon(1e-12));
    CHECK(truth.ledger.landed - truth.ledger.lost - truth.ledger.shrunk ==
          Approx(truth.volume_mm3).epsilon(1e-12));
    CHECK(truth.height.at(4, 3) * 1e3 == Approx(7.6).margin(1.6));
    CHECK(truth.height.at(11, 11) == 0.0);
  }
}

TEST_CASE("Equal seeds give equal bytes, however the bytes to the world are split and time is sliced") {
  WorldConfig config = small_world();
  config.lamp.min_dose_s = 1e-6;
  Bench whole(config), split(config);
  RandomStream random(4, Purpose::kTest);
  const std::string script =
      "WAIT MODE NOWAIT\nABS\nENABLE @0\nENABLE @1\nPSOCONTROL @1 RESET\nPSOOUTPUT @1 PULSE\nPSODISTANCE @1 "
      "FIXED "
      "0.2 UNITS\n"
      "PSOCONTROL @1 ARM\nLINEAR @1 3 F10\nPFBKPROG(@1)\n";
  const std::string ask =
      hex("20000000 0100F000 00000000 14000000 42000000 00000000 00000000 01000000 01010000");
  const std::string jet = "QX2000" + hex("53 02 02 04 53 02 60 62"), lamp = "CONN18\rOPN40\rCLS3A\r";
  for (int round = 0; round < 5; ++round) {
    for (const auto& [port, text] :
         {std::pair{kStagePort, script}, {kJetPort, jet}, {kLampPort, lamp}, {kProfilerPort, ask}}) {
      whole.send(port, text);
      for (std::size_t at = 0; at < text.size();) {
        const std::size_t n = std::min<std::size_t>(text.size() - at, 1 + random.below(7));
        split.send(port, text.substr(at, n));
        at += n;
      }
    }
    whole.run(700'000);
    for (std::int64_t left = 700'000; left > 0;) {
      const std::int64_t slice = std::min<std::int64_t>(left, 1 + random.below(30'000));
      split.run(slice);
      left -= slice;
    }
  }
  REQUIRE(whole.log.size() > 50);
  CHECK(whole.log == split.log);
  CHECK(whole.world.exposures() == 5);
  Bench other([] {
    WorldConfig c = small_world();
    c.seed = 12;
    return c;
  }());
  start_stage(other);
  start_stage(whole);
  CHECK(scan_and_read(other) != scan_and_read(whole));
}

TEST_CASE("next_event_us names the time of the next bytes") {
  Bench b(small_world());
  b.stage("ENABLE @0");
  CHECK(b.world.next_event_us() == INT64_MAX);
  b.send(kStagePort, "ENABLE @0\n");
  CHECK(b.world.next_event_us() == b.now_us + b.world.config().stage.latency_us);
  const std::size_t before = b.log.size();
  b.run(b.world.config().stage.latency_us - 1);
  CHECK(b.log.size() == before);
  b.run(1);
  CHECK(b.log.size() == before + 1);
}

TEST_CASE("A restored world goes on bit for bit") {
  const auto path = scratch("state");
  for (const char* model : {"droplets", "lu2015"}) {
    Bench a(small_world(model));
    start_stage(a);
    start_jet(a);
    print_layer(a, 9, 5);
    for (const auto port : {kStagePort, kJetPort, kProfilerPort, kLampPort})
      a.world.disconnect(port, a.now_us);
    a.world.save(path);
    Bench b(small_world(model));
    b.world = World::restore(path, small_world(model), &b.record);
    b.now_us = a.now_us;
    std::string read[2];
    for (Bench* w : {&a, &b}) {
      w->log.clear();
      for (const auto port : {kStagePort, kJetPort, kProfilerPort, kLampPort})
        w->world.connect(port, w->now_us);
      w->stage("WAIT MODE NOWAIT");
      print_layer(*w, 9, 5);
      read[w == &b] = scan_and_read(*w);
    }
    CHECK(a.log == b.log);
    CHECK(read[0] == read[1]);
    CHECK(a.world.truth().height.cells == b.world.truth().height.cells);
    CHECK(b.world.truth().exposures == 2);
    CHECK(b.record.history.begins.back().restored == 1);
    CHECK(b.record.history.begins.back().droplets_before == 45);
  }
  std::filesystem::remove(path);
}

TEST_CASE("A state that is damaged, cut or of another configuration is refused by name") {
  const auto path = scratch("bad_state");
  Bench a(small_world());
  a.world.save(path);
  WorldConfig other = small_world();
  other.grid.nx = 13;
  CHECK_THROWS_WITH(World::restore(path, other, nullptr), Catch::Contains("configuration"));
  std::filesystem::resize_file(path, 1000);
  CHECK_THROWS_WITH(World::restore(path, small_world(), nullptr),
                    Catch::Contains(path.string()) && Catch::Contains("damaged"));
  std::filesystem::remove(path);
  CHECK_THROWS_WITH(World::restore(path, small_world(), nullptr), Catch::Contains(path.string()));
}

TEST_CASE("The record file gives back every shot, scan and lamp event in order") {
  const auto path = scratch("record");
  std::filesystem::remove(path);
  std::int64_t fired = 0;
  {
    auto record = make_record_file(path);
    Bench b(small_world());
    b.world = World(small_world(), record.get());
    for (const auto port : {kStagePort, kJetPort, kProfilerPort, kLampPort}) b.world.connect(port, b.now_us);
    start_stage(b);
    start_jet(b);
    for (int layer = 0; layer < 7; ++layer) print_layer(b, 10, 6);
    scan_and_read(b);
    fired = b.world.truth().droplets_fired;
    b.world = World(small_world(), nullptr);  // the old world ends before its record does
  }
  const WorldHistory h = read_history(path);
  CHECK(h.damaged == 0);
  CHECK(std::int64_t(h.shots.size()) == fired);
  CHECK(h.scans.size() == 2);
  CHECK(h.lamp.size() == 14);
  CHECK(h.begins.size() == 1);
  for (std::size_t n = 1; n < h.shots.size(); ++n) CHECK(h.shots[n - 1].t_us < h.shots[n].t_us);
  for (const ShotRecord& s : h.shots) CHECK(s.exposures == std::uint32_t(&s - h.shots.data()) / 60);
  std::filesystem::remove(path);
}
