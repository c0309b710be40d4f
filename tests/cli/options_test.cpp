#include <catch2/catch.hpp>

#include <vector>

#include "cli/commands.h"
#include "cli/options.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"

using namespace firn;

namespace {

Call parse(std::vector<const char*> words) {
  words.insert(words.begin(), "firn");
  return parse_command_line(all_commands(), full_product(), int(words.size()), words.data());
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
  CHECK_THROWS_AS(parse({"config"}).run(), UsageError);
  CHECK_THROWS_AS(parse({"--bogus"}).run(), UsageError);
  CHECK(parse({"config", "check"}).command == "config check");
}

TEST_CASE("A program of one command points to the one that has them all") {
  const char* words[] = {"firn-demo", "print"};
  CHECK_THROWS_WITH(parse_command_line(all_commands().first(1), full_product(), 2, words).run(),
                    Catch::Contains("unknown command 'print': this program has ") &&
                        Catch::Contains(" alone; try ./firn print"));
}

TEST_CASE("A number that cannot be is refused with the option and the number, before anything runs") {
  CHECK_THROWS_WITH(parse({"print", "x.toml", "--tolerance", "-1"}).run(),
                    Catch::Contains("--tolerance: -1 is not a number above 0"));
  CHECK_THROWS_WITH(parse({"print", "x.toml", "--speedup", "inf"}).run(),
                    Catch::Contains("--speedup: inf is not a finite number"));
  CHECK_THROWS_WITH(parse({"print", "x.toml", "--tolerance", "two"}).run(),
                    Catch::Contains("two is not a number above 0"));
  CHECK_THROWS_WITH(parse({"compare", "x.toml", "--seeds", "0"}).run(),
                    Catch::Contains("--seeds") && Catch::Contains("0"));
}

TEST_CASE("A number that its type cannot hold, and an empty one, are refused with the option and the limit") {
  CHECK_THROWS_WITH(parse({"calibrate", "jet", "--seed", "-1"}).run(),
                    Catch::Contains("--seed: -1 is not a whole number from 0 to 18446744073709551615"));
  CHECK_THROWS_WITH(parse({"calibrate", "jet", "--seed", "99999999999999999999"}).run(),
                    Catch::Contains("--seed: 99999999999999999999 is not a whole number from 0 to"));
  CHECK_THROWS_WITH(parse({"calibrate", "jet", "--seed", ""}).run(),
                    Catch::Contains("--seed: the value is empty"));
  CHECK_THROWS_WITH(
      parse({"plan", "x.csv", "--machine", "m.toml", "--plot-path", "9223372036854775808"}).run(),
      Catch::Contains("--plot-path: 9223372036854775808 is not a whole number"));
  CHECK_THROWS_WITH(parse({"plan", "x.csv", "--machine", "m.toml", "--ramp", "nan"}).run(),
                    Catch::Contains("--ramp: nan is not a finite number"));
  CHECK_THROWS_WITH(parse({"calibrate", "jet", "--dwells", "1e300"}).run(),
                    Catch::Contains("--dwells: Value 1e300 not in range 1 to 3000"));
}

TEST_CASE("An empty item of a list is refused with the option and the list") {
  for (const char* list : {"60,,70", "60,70,", ",60,70", ",", ""}) {
    CAPTURE(list);
    CHECK_THROWS_WITH(parse({"droplets", "a.png", "b.png", "--delay-us", list}).run(),
                      Catch::Contains("--delay-us: ") && Catch::Contains("empty"));
    CHECK_THROWS_WITH(parse({"calibrate", "jet", (std::string("--voltages=") + list).c_str()}).run(),
                      Catch::Contains("--voltages: ") && Catch::Contains("empty"));
  }
  CHECK_THROWS_WITH(parse({"plan", "x.csv", "--machine", "m.toml", "--origin", "1,,2"}).run(),
                    Catch::Contains("--origin: \"1,,2\" has an empty item; items are separated by one ','"));
}

TEST_CASE("An unreadable experiment is a configuration error that names the file") {
  CHECK_THROWS_WITH(parse({"config", "check", "nowhere.toml"}).run(), "nowhere.toml: no such file");
}
