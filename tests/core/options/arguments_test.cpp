// The command line of a process: each value reaches its own place, and mistakes are named.
#include "core/options/arguments.h"

#include <catch2/catch.hpp>

using namespace firn;

namespace {

struct Read {
  std::string run = "unset", path;
  std::int32_t nodes = -1;
  std::int64_t epoch = -1;
  double scale = -1.0;
  void from(const std::vector<std::string>& arguments) {
    const ProcessArgument table[] = {{"--run", &run},
                                     {"--nodes", &nodes},
                                     {"--epoch", &epoch},
                                     {"--scale", &scale},
                                     {"--path", [this](const std::string& text) { path = text + "!"; }}};
    read_arguments(arguments, table);
  }
};

}  // namespace

TEST_CASE("Values of a process's arguments reach their own places, in any order") {
  Read r;
  r.from({"--scale", "2.5", "--path", "a b", "--run", "--nodes", "--epoch", "5000000000", "--nodes", "-7"});
  CHECK(r.run == "--nodes");  // a value may look like a name
  CHECK(r.path == "a b!");
  CHECK(r.nodes == -7);
  CHECK(r.epoch == 5'000'000'000);
  CHECK(r.scale == 2.5);
}

TEST_CASE("Arguments that are not given leave their places as they are") {
  Read r;
  r.from({"--nodes", "3"});
  CHECK(r.run == "unset");
  CHECK(r.scale == -1.0);
}

TEST_CASE("An argument that is unknown, without a value or no number is refused with name and value") {
  Read r;
  CHECK_THROWS_WITH(r.from({"--run", "x", "--speed", "9"}),
                    "--speed '9': must be an argument of a process of Firn; firn print starts these");
  CHECK_THROWS_WITH(r.from({"--run"}), "--run '': must be followed by its value");
  CHECK_THROWS_WITH(r.from({"--run", "x", "--nodes"}), "--nodes '': must be followed by its value");
  for (const char* text : {"", "3.5", "x", "3 ", "99999999999"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(r.from({"--nodes", text}), "--nodes '" + std::string(text) + "': must be a number");
  }
}
