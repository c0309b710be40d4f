// The disk that a killed world leaves, at every moment of a print.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "plant/world/kept_world.h"
#include "tests/plant/bench_lines.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::plant;
using firn::test::TempFolder;
namespace fs = std::filesystem;

namespace {

WorldConfig kept_small_world() {
  WorldConfig c;
  c.grid = {12, 12, 0.263256, 0.263256, 0.0, 0.0};
  c.seed = 11;
  return c;
}

/// Bytes for a port and the time that passes after them.
struct Turn {
  std::string_view port;
  std::string bytes;
  std::int64_t us;
};

std::string stage_lines(std::initializer_list<const char*> lines) {
  std::string text;
  for (const char* line : lines) text += std::string(line) + "\n";
  return text;
}

/// Two rows of four droplets with the stage's counter read after each, then a cure.
std::vector<Turn> layer() {
  std::vector<Turn> turns{
      {kJetPort, "Q", 100'000},
      {kJetPort, "X2000", 100'000},
      {kJetPort, hex("53 15 06 00 00 00 C8 00 01 90 00 00 00 14 FF EC 00 1E 00 1E 00 1E CD"), 1'000'000},
      {kJetPort, hex("53 03 08 01 0C"), 100'000},
      {kStagePort,
       stage_lines({"WAIT MODE NOWAIT", "ABS", "ENABLE @0", "ENABLE @1", "ENABLE @2", "HOME @0",
                    "PSOCONTROL @0 RESET", "PSOOUTPUT @0 PULSE", "PSODISTANCE @0 FIXED 0.5 UNITS"}),
       100'000}};
  for (const char* line : {"LINEAR @0 2.2 F20", "LINEAR @0 0 F20"}) {
    turns.push_back({kStagePort, stage_lines({"PSOCONTROL @0 ARM", line}), 60'000});
    turns.push_back({kStagePort, "", 60'000});
    turns.push_back({kStagePort, "", 600'000});
    turns.push_back({kStagePort, stage_lines({"PSOCONTROL @0 OFF", "PSOCOUNT(@0)"}), 10'000});
  }
  for (const char* text : {"CONN18\r", "OPN40\r", "CLS3A\r"}) turns.push_back({kLampPort, text, 300'000});
  return turns;
}

struct Lab {
  explicit Lab(const fs::path& run, std::int64_t from_us = 0)
      : world(run, kept_small_world()), now_us(from_us) {
    for (const auto port : {kStagePort, kJetPort, kProfilerPort, kLampPort}) world.connect(port, now_us);
  }
  void give(const Turn& turn) {
    const auto send = [&](const World::Sent& s) {
      heard[std::string(s.port)].append(reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size());
    };
    if (!turn.bytes.empty()) world.receive(turn.port, std::as_bytes(std::span(turn.bytes)), now_us);
    for (const std::int64_t until_us = now_us + turn.us; now_us < until_us;)
      world.advance(now_us = std::min(until_us, now_us + 50'000), send);
    world.flush_record();
    world.save_if_due();
  }
  KeptWorld world;
  std::int64_t now_us;
  std::map<std::string, std::string> heard;
};

std::vector<double> heights(const KeptWorld& w) { return w.world().truth().height.cells; }

/// Everything the kill left, elsewhere.
fs::path killed(const fs::path& run, const fs::path& to) {
  fs::remove_all(to);
  fs::copy(run, to, fs::copy_options::recursive);
  return to;
}

}  // namespace

TEST_CASE("A world killed at any moment has every droplet, cure and time that it had") {
  const TempFolder folder;
  const fs::path run = folder.path() / "run";
  fs::create_directories(run / "world");
  Lab lab(run);
  std::size_t kills = 0;
  for (int n = 0; n < 2; ++n)
    for (const Turn& turn : layer()) {
      lab.give(turn);
      if (turn.bytes.starts_with("OPN")) continue;  // the light goes out with the power, which may cure
      const KeptWorld again(killed(run, folder.path() / "left"), kept_small_world());
      REQUIRE(again.lost_power());
      const Truth is = again.world().truth(), was = lab.world.world().truth();
      REQUIRE(is.droplets_fired == was.droplets_fired);
      REQUIRE(is.exposures == was.exposures);
      REQUIRE(is.volume_mm3 == was.volume_mm3);
      REQUIRE(heights(again) == heights(lab.world));
      REQUIRE(again.world().now_us() == lab.now_us);
      ++kills;
    }
  CHECK(kills > 20);
  CHECK(lab.world.world().truth().droplets_fired == 16);
  CHECK(lab.world.world().exposures() == 2);
}

TEST_CASE("The record of a world killed twice in one layer names each droplet once") {
  const TempFolder folder;
  const fs::path run = folder.path() / "run", left = folder.path() / "left", twice = folder.path() / "twice";
  fs::create_directories(run / "world");
  Lab lab(run);
  std::int64_t fired = 0;
  for (const Turn& turn : layer()) {
    lab.give(turn);
    Lab second(killed(run, left), lab.now_us);
    for (const Turn& again : layer())
      if (again.port != kLampPort) second.give(again);
    { const KeptWorld third(killed(left, twice), kept_small_world()); }
    fired = second.world.world().truth().droplets_fired;
    REQUIRE(std::int64_t(read_history(twice / "world.rec").shots.size()) == fired);
  }
  CHECK(fired == 16);
}

TEST_CASE("Events that a kill kept from the record are written when the inputs are given again") {
  const TempFolder folder;
  const fs::path run = folder.path() / "run", left = folder.path() / "left";
  fs::create_directories(run / "world");
  Lab lab(run);
  std::uintmax_t before = 0;
  for (const Turn& turn : layer()) {
    if (turn.port == kLampPort) break;
    if (lab.world.world().truth().droplets_fired == 0) before = fs::file_size(run / "world.rec");
    lab.give(turn);
  }
  killed(run, left);
  fs::resize_file(left / "world.rec", before);
  { const KeptWorld again(left, kept_small_world()); }
  const auto is = read_history(left / "world.rec").shots, was = read_history(run / "world.rec").shots;
  REQUIRE(was.size() == 8);
  REQUIRE(is.size() == was.size());
  for (std::size_t n = 0; n < is.size(); ++n) CHECK(is[n].t_us == was[n].t_us);
}

TEST_CASE("After a kill the stage is not homed and its counter is at zero") {
  const TempFolder folder;
  fs::create_directories(folder.path() / "run" / "world");
  Lab lab(folder.path() / "run");
  for (const Turn& turn : layer()) lab.give(turn);
  lab.give({kStagePort, stage_lines({"AXISSTATUS(@0)", "PSOCOUNT(@0)"}), 10'000});
  REQUIRE(lab.heard["stage"].ends_with("%7\n%4\n"));
  Lab again(killed(folder.path() / "run", folder.path() / "left"), lab.now_us);
  again.give({kStagePort, stage_lines({"WAIT MODE NOWAIT", "AXISSTATUS(@0)", "PSOCOUNT(@0)"}), 10'000});
  CHECK(again.heard["stage"] == "%\n%0\n%0\n");
}

TEST_CASE("A world that was closed in order goes on with its instruments as they were") {
  const TempFolder folder;
  fs::create_directories(folder.path() / "world");
  std::int64_t now_us = 0;
  {
    Lab lab(folder.path());
    for (const Turn& turn : layer()) lab.give(turn);
    lab.world.close();
    now_us = lab.now_us;
  }
  Lab again(folder.path(), now_us);
  CHECK_FALSE(again.world.lost_power());
  again.give({kStagePort, stage_lines({"WAIT MODE NOWAIT", "AXISSTATUS(@0)"}), 10'000});
  CHECK(again.heard["stage"] == "%\n%7\n");
}

TEST_CASE("Inputs that belong to an older state are left alone") {
  const TempFolder folder;
  const fs::path run = folder.path() / "run", left = folder.path() / "left";
  fs::create_directories(run / "world");
  Lab lab(run);
  const std::vector<Turn> turns = layer();
  for (const Turn& turn : turns) {
    if (&turn == &turns.back()) killed(run, left);
    lab.give(turn);
  }
  REQUIRE(lab.world.world().exposures() == 1);
  fs::copy_file(run / "world" / "state", left / "world" / "state", fs::copy_options::overwrite_existing);
  const KeptWorld again(left, kept_small_world());
  CHECK(again.world().truth().droplets_fired == 8);
  CHECK(again.world().exposures() == 1);
}
