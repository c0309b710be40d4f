// Includes and their errors: folders, missing files, circles, depth.
#include "config/include.h"

#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/experiment.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

std::string mistake(const fs::path& path) {
  try {
    load_experiment(path);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("The experiment overrides its lab, and --set overrides both") {
  const test::TempFolder f;
  f.file("labs/lab.toml", "[grid]\nnx = 50\nny = 51\n");
  const fs::path path = f.file("experiments/x.toml", "include = \"../labs/lab.toml\"\n[grid]\nnx = 52\n");
  const Experiment e = load_experiment(path, {"grid.pitch_x_mm=0.3"});
  CHECK(e.grid.nx == 52);
  CHECK(e.grid.ny == 51);
  CHECK(e.grid.pitch_x_mm == 0.3);
}

TEST_CASE(
    "A path in an included file is resolved from that file's folder, one of the experiment from its own") {
  const test::TempFolder f;
  f.file("shop/labs/lab.toml",
         "lab.kind = \"ice\"\ncontrol.scheme = \"smf\"\nice.machine = \"arm.toml\"\n"
         "ice.slice = \"../slicing/fine.toml\"\nice.mesh = \"lab.stl\"\n");
  const fs::path path =
      f.file("mine/parts/x.toml", "include = \"../../shop/labs/lab.toml\"\nice.mesh = \"part.stl\"\n");
  const auto same = [&](const std::string& said, const char* where) {
    return (path.parent_path() / said).lexically_normal() == f.path() / where;
  };
  Experiment e = load_experiment(path);
  CHECK(same(e.ice.machine, "shop/labs/arm.toml"));
  CHECK(same(e.ice.slice, "shop/slicing/fine.toml"));
  CHECK(same(e.ice.mesh, "mine/parts/part.stl"));
  e = load_experiment(path, {"ice.machine=arm.toml"});
  CHECK(same(e.ice.machine, "mine/parts/arm.toml"));
  f.file("abs.toml", "include = \"shop/labs/lab.toml\"\nice.machine = \"/opt/arm.toml\"\n");
  CHECK(load_experiment(f.path() / "abs.toml").ice.machine == "/opt/arm.toml");
}

TEST_CASE("The file of a scheme in Python is relative to the file that names it, as any path") {
  const auto scheme_of = [](const std::string& base, const std::string& leaf) {
    return parse_experiment({{"labs/base.toml", base}, {"experiments/mine.toml", leaf}}, {}).control.scheme;
  };
  const std::string python = "[control]\nscheme = \"python:own/level.py:Level(gain=0.5)\"\n";
  CHECK(scheme_of("", python) == "python:own/level.py:Level(gain=0.5)");
  CHECK(scheme_of(python, "include = \"../labs/base.toml\"\n") ==
        "python:../labs/own/level.py:Level(gain=0.5)");
  CHECK(scheme_of("[control]\nscheme = \"python:/a/b.py:C\"\n", "include = \"../labs/base.toml\"\n") ==
        "python:/a/b.py:C");
  const Experiment e =
      parse_experiment({{"x.toml", ""}}, {"control.scheme=python:../own/level.py:Level(name=\"a\")"});
  CHECK(parse_experiment(dump(e), "dump").control.scheme == "python:../own/level.py:Level(name=\"a\")");
}

TEST_CASE("A scheme in Python that names no file or no class is refused with the form that is wanted") {
  for (const char* wrong :
       {"python:", "python:a.py", "python:a.py:", "python:a.py:1b", "python:a:B", "python:.py:B",
        "python:a b.py:C", "python:a.py:B(", "python:a.py:B(1", "python:a.py:B)", "python::B"}) {
    INFO(wrong);
    CHECK_THROWS_WITH(parse_experiment({{"x.toml", ""}}, {std::string("control.scheme=") + wrong}),
                      Catch::Contains("must read python:FILE.py:CLASS"));
  }
}

TEST_CASE("A missing include names the missing file and the file that includes it") {
  const test::TempFolder f;
  const fs::path path = f.file("x.toml", "include = \"gone.toml\"\n");
  CHECK_THAT(mistake(path),
             Contains("gone.toml") && Contains("no such file (included by " + path.string() + ")"));
  CHECK_THAT(mistake(f.path() / "none.toml"), Contains("none.toml") && Contains("no such file"));
}

TEST_CASE("A folder in place of an experiment is called a folder") {
  const test::TempFolder f;
  CHECK_THAT(mistake(f.path()), Contains("is a folder, not a file"));
}

TEST_CASE("An include that comes back to itself is refused, by whatever name it does") {
  const test::TempFolder f;
  f.file("a.toml", "include = \"./sub/../b.toml\"\n");
  f.file("b.toml", "include = \"a.toml\"\n");
  fs::create_directories(f.path() / "sub");
  CHECK_THAT(mistake(f.path() / "a.toml"), Contains("comes back to itself"));
  CHECK_THAT(mistake(f.file("self.toml", "include = \"self.toml\"\n")), Contains("comes back to itself"));
}

TEST_CASE("Eight levels of includes are read, nine are refused") {
  const test::TempFolder f;
  f.file("l1.toml", "[grid]\nnx = 50\n");
  for (int n = 2; n <= 9; ++n)
    f.file("l" + std::to_string(n) + ".toml", "include = \"l" + std::to_string(n - 1) + ".toml\"\n");
  CHECK(load_experiment(f.path() / "l8.toml").grid.nx == 50);
  CHECK_THAT(mistake(f.path() / "l9.toml"), Contains("deeper than 8"));
}

TEST_CASE("A mistake in an included file is named by that file and its line") {
  const test::TempFolder f;
  f.file("lab.toml", "[grid]\n\nnx = 0\n");
  CHECK_THAT(mistake(f.file("x.toml", "include = \"lab.toml\"\n")),
             Contains("lab.toml:3") && Contains("grid.nx"));
}
