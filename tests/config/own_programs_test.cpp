// [nodes.NAME] with a command: the programs of the lab's own that an experiment may name, and how they come
// back from its dump.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "config/error.h"
#include "config/experiment.h"
#include "core/grid/random.h"

using namespace firn;

namespace {

Experiment own_lab(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_experiment({{"lab.toml", text}}, overrides);
}

std::string own_refusal(const std::string& text) {
  try {
    own_lab(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "taken";
}

std::string with_name(const std::string& name) {
  return own_refusal("[nodes.\"" + name + "\"]\ncommand = \"x\"\n");
}

}  // namespace

TEST_CASE("an experiment names programs of the lab's own and how they are watched", "[own]") {
  const Experiment e = own_lab(
      "[nodes.estimate]\ncommand = \"python3 estimate.py\"\nlongest_silence_s = 5\n"
      "[nodes.room]\ncommand = \"./room --every 1\"\nneeded = \"off\"\n");
  REQUIRE(e.own_programs.size() == 2);
  CHECK(e.own_programs.at("estimate").command == "python3 estimate.py");
  CHECK(e.own_programs.at("estimate").longest_silence_s == 5.0);
  CHECK(e.own_programs.at("estimate").is_needed());
  CHECK_FALSE(e.own_programs.at("room").is_needed());
}

TEST_CASE("a program of the lab's own can be named by --set", "[own]") {
  const Experiment e = own_lab("", {"nodes.room.command=./room a=b", "nodes.room.needed=off"});
  CHECK(e.own_programs.at("room").command == "./room a=b");
  CHECK_FALSE(e.own_programs.at("room").is_needed());
}

TEST_CASE("a host of one of Firn's processes does not make it a program of the lab's own", "[own]") {
  CHECK(own_lab("[hosts]\nbench = \"b\"\n[nodes.surface_mapper]\nhost = \"bench\"\n").own_programs.empty());
}

TEST_CASE("an experiment without such programs has none in its dump", "[own]") {
  CHECK(dump(own_lab("")).find("[nodes") == std::string::npos);
}

TEST_CASE("random programs of the lab's own come back from the dump", "[own]") {
  for (std::uint64_t seed = 0; seed < 80; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    OwnPrograms wanted;
    std::vector<std::string> overrides;
    for (std::uint32_t n = 1 + random.below(4); n > 0; --n) {
      const std::string name = "p" + std::to_string(random.below(100)) + (random.below(2) ? "_x" : "-y");
      OwnProgram& program = wanted[name];
      program = {"run \"" + std::to_string(random.below(1000)) + "\" \\ " + name,
                 random.below(2) ? "off" : "", double(random.below(3)) * 0.5};
      const std::string key = "nodes." + name + ".";
      std::erase_if(overrides, [&](const std::string& o) { return o.starts_with(key); });
      overrides.push_back(key + "command=" + program.command);
      if (!program.needed.empty()) overrides.push_back(key + "needed=" + program.needed);
      if (program.longest_silence_s > 0.0)
        overrides.push_back(key + "longest_silence_s=" + std::to_string(program.longest_silence_s));
    }
    INFO("seed " << seed);
    const std::string text = dump(own_lab("", overrides));
    const Experiment again = parse_recorded_experiment(text, "dump");
    CHECK(dump(again) == text);
    REQUIRE(again.own_programs.size() == wanted.size());
    for (const auto& [name, program] : wanted) {
      CHECK(again.own_programs.at(name).command == program.command);
      CHECK(again.own_programs.at(name).needed == program.needed);
      CHECK(again.own_programs.at(name).longest_silence_s == program.longest_silence_s);
    }
  }
}

TEST_CASE("experiments that differ in their own programs are told apart by key", "[own]") {
  const auto differing = differences(own_lab("[nodes.a]\ncommand = \"x\"\n"), own_lab(""));
  REQUIRE(differing.size() == 1);
  CHECK(differing[0].key == "nodes.a.command");
}

TEST_CASE("a name that a process of Firn has, or that is none for a channel, is refused by key", "[own]") {
  for (const char* name :
       {"scheduler", "jet", "launcher", "relay", "Room", "a/b", "a b", "a23456789012345678901234x"})
    CHECK_THAT(with_name(name), Catch::StartsWith("lab.toml:2: nodes." + std::string(name) + ".command") &&
                                    Catch::Contains("a-z, 0-9"));
  for (const char* name : {"room", "jet_2", "a23456789012345678901234", "7"})
    CHECK(with_name(name) == "taken");
}

TEST_CASE("a program of the lab's own without a command, or watched by a wrong word, is refused", "[own]") {
  CHECK_THAT(own_refusal("[nodes.room]\nneeded = \"off\"\n"), Catch::Contains("unknown key"));
  CHECK_THAT(own_refusal("[nodes.room]\ncommand = \" \"\n"), Catch::Contains("must be a command"));
  CHECK_THAT(own_refusal("[nodes.room]\ncommand = 3\n"), Catch::Contains("must be text"));
  CHECK_THAT(own_refusal("[nodes.room]\ncommand = \"x\"\nneeded = \"maybe\"\n"),
             Catch::Contains("nodes.room.needed") && Catch::Contains("one of on, off"));
  CHECK_THAT(own_refusal("[nodes.room]\ncommand = \"x\"\nlongest_silence_s = -1\n"),
             Catch::Contains("nodes.room.longest_silence_s") && Catch::Contains("[0, 3600]"));
}

TEST_CASE("the model of a droplet may come from a program of the lab's own, without an estimator", "[own]") {
  CHECK(own_lab("[control]\nadapt_model = \"own:estimate\"\n").control.adapt_model == "own:estimate");
  CHECK_THAT(own_refusal("[control]\nadapt_model = \"own:jet\"\n"), Catch::Contains("control.adapt_model"));
  CHECK_THAT(own_refusal("[control]\nadapt_model = \"own:\"\n"), Catch::Contains("own:NAME"));
  CHECK_THAT(own_refusal("[control]\nheight_estimate = \"own:x\"\n"),
             Catch::Contains("control.height_estimate"));
}

TEST_CASE("own:NAME is the name of a source, and nothing else is", "[own]") {
  CHECK(own_source("own:estimate") == "estimate");
  for (const char* other : {"on", "off", "", "own", "own:", "python:own:x"}) CHECK(own_source(other).empty());
}
