// Cassettes on the command line: recorded, played as an instrument, held against the driver of today.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "config/include.h"
#include "files/cassette.h"
#include "files/json.h"
#include "files/text_file.h"
#include "print/device/cassette_replay.h"
#include "print/labs/full_product.h"
#include "tests/cli/run_firn.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

TEST_CASE("What was recorded of an instrument is sent again by the driver, and plays as its twin") {
  const auto folder = fresh_folder("cassettes");
  const std::pair<std::string, std::vector<std::string>> all[] = {
      {kInkjet, {"stage", "home"}},          {kInkjet, {"jet", "status"}},
      {kInkjet, {"laser_profiler", "stop"}}, {kInkjet, {"lamp", "expose", "0.5", "60"}},
      {kIce, {"robot", "status"}},           {kIce, {"valve_a", "status"}},
      {kIce, {"laser_point", "status"}},     {kIce, {"heater", "set", "20", "5", "10"}}};
  for (const auto& [lab, words] : all) {
    const std::string file = (folder / (words[0] + ".cassette")).string();
    CAPTURE(words[0]);
    std::vector<std::string> record{"device", lab};
    record.insert(record.end(), words.begin(), words.end());
    record.insert(record.end(), {"--record", file});
    REQUIRE(firn_says(record).code == 0);
    const Said same = firn_says({"cassette", file});
    INFO(same.out << same.err);
    CHECK(same.code == 0);
    CHECK_THAT(same.out, Contains("SIMULATED sim:") && Contains("the driver of today sends the same"));
    std::vector<std::string> play{"device", lab, words[0], "identify", "--json"};
    const std::vector<std::string> coupled =
        lab == kInkjet ? std::vector<std::string>{"stage", "jet", "laser_profiler"}
                       : std::vector<std::string>{"robot", "valve_a", "valve_b", "laser_point"};
    const bool all_of_them = std::ranges::find(coupled, words[0]) != coupled.end();
    for (const std::string& node : all_of_them ? coupled : std::vector<std::string>{words[0]})
      play.insert(play.end(), {"--set", "devices." + node + ".port=\"cassette:" + file + "\""});
    const Said played = firn_says(play);
    INFO(played.err);
    REQUIRE(played.code == 0);
    const Json j = Json::parse(played.out);
    CHECK(j["real"] == false);
    CHECK(j["port"] == "cassette:" + file);
    CHECK_FALSE(j["identity"].get<std::string>().empty());
  }
}

TEST_CASE("A driver that does something else than the tape is told by line, and by what it does") {
  const auto folder = fresh_folder("cassettes-changed");
  const std::string file = (folder / "lamp.cassette").string(), kept = (folder / "kept.cassette").string();
  REQUIRE(firn_says({"device", kInkjet, "lamp", "expose", "0.5", "60", "--record", file}).code == 0);
  std::string text = read_file(file);
  const std::size_t at = text.find("|SIL60");
  REQUIRE(at != std::string::npos);
  text.replace(text.rfind("36 30", at), 5, "37 30");
  write_file_atomically(file, text);
  const Said other = firn_says({"cassette", file, "--keep", kept});
  CHECK(other.code == 1);
  CHECK_THAT(other.out, Contains("DIFFERENT: line") && Contains("the tape has") && Contains("|SIL70") &&
                            Contains("the driver sends") && Contains("|SIL60"));
  CHECK(read_file(kept) == text);
  CHECK_THAT(firn_says({"cassette", kInkjet}).err, Contains("is no cassette"));
  CHECK(firn_says({"cassette", kInkjet}).code == 2);
}

TEST_CASE("Every cassette that a lab has sent is sent again by the driver of today") {
  int cassettes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(FIRN_SOURCE_DIR "/tests/drivers/cassettes")) {
    INFO(entry.path());
    CHECK(replay_cassette(full_product(), parse_cassette(read_file(entry.path()), entry.path().string())) ==
          "");
    ++cassettes;
  }
  CHECK(cassettes >= 5);
}

TEST_CASE("A tape that ends in mid talk, as a print may end, is sent again up to its end") {
  const std::string file = FIRN_SOURCE_DIR "/tests/drivers/cassettes/stage-grbl-print.cassette";
  const Cassette whole = parse_cassette(read_file(file), file);
  int cuts = 0;
  for (std::size_t n = whole.pieces.size(); n > 0; --n) {
    if (whole.pieces[n - 1].kind != Cassette::Kind::kReceived || n % 5 != 0) continue;
    Cassette cut = whole;
    cut.pieces.resize(n);
    INFO("after line " << whole.pieces[n - 1].line);
    CHECK(replay_cassette(full_product(), cut) == "");
    ++cuts;
  }
  CHECK(cuts > 10);
}

TEST_CASE("A lab of cassettes is simulated, and mixes with neither steel nor the simulated world") {
  const std::vector<std::string> mixed{"devices.stage.port=\"cassette:x\"", "devices.jet.port=\"tcp:h:1\""};
  CHECK_THROWS_WITH(load_experiment(kInkjet, mixed), Contains("no trigger line couples them"));
}
