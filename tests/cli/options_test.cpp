#include <catch2/catch.hpp>

#include <vector>

#include "cli/options.h"
#include "files/usage_error.h"

using namespace firn;

namespace {

Call parse(std::vector<const char*> words) {
  words.insert(words.begin(), "firn");
  return parse_command_line(commands(), int(words.size()), words.data());
}

}  // namespace

TEST_CASE("A subcommand is found with its name and something to run") {
  const Call call = parse({"config", "check", "x.toml", "--set", "a.b=1", "--set", "c=2"});
  CHECK(call.command == "config check");
  CHECK(call.run);
}

TEST_CASE("Usage errors name the command and the argument and are raised by run, not before") {
  CHECK_THROWS_WITH(parse({"confg"}).run(),
                    Catch::Contains("unknown command 'confg'; the nearest known one is config"));
  CHECK_THROWS_WITH(parse({"config", "check"}).run(), Catch::Contains("FILE is required"));
  CHECK_THROWS_WITH(parse({"dataflow", "--jsn"}).run(), Catch::Contains("--jsn"));
  CHECK_THROWS_AS(parse({}).run(), UsageError);
  CHECK_THROWS_AS(parse({"config"}).run(), UsageError);
  CHECK_THROWS_AS(parse({"--bogus"}).run(), UsageError);
  CHECK(parse({"config", "check"}).command == "config check");
}

TEST_CASE("A program of one command points to the one that has them all") {
  const char* words[] = {"firn-demo", "print"};
  CHECK_THROWS_WITH(parse_command_line(commands().first(1), 2, words).run(),
                    Catch::Contains("unknown command 'print': this program has ") &&
                        Catch::Contains(" alone; try ./firn print"));
}

TEST_CASE("A number that cannot be is refused with the option and the number, before anything runs") {
  CHECK_THROWS_WITH(parse({"print", "x.toml", "--tolerance", "-1"}).run(),
                    Catch::Contains("--tolerance: -1 is not a number above 0"));
  CHECK_THROWS_WITH(parse({"print", "x.toml", "--speedup", "inf"}).run(),
                    Catch::Contains("--speedup: inf is not a number above 0"));
  CHECK_THROWS_WITH(parse({"print", "x.toml", "--tolerance", "two"}).run(),
                    Catch::Contains("two is not a number above 0"));
  CHECK_THROWS_WITH(parse({"compare", "x.toml", "--seeds", "0"}).run(),
                    Catch::Contains("--seeds") && Catch::Contains("0"));
}

TEST_CASE("An unreadable experiment is a configuration error that names the file") {
  CHECK_THROWS_WITH(parse({"config", "check", "nowhere.toml"}).run(), "nowhere.toml: no such file");
}
