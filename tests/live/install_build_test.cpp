// firn host --install: this build at another computer, in its user's own folder.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "files/command.h"
#include "print/hosts/install_build.h"
#include "runtime/build_info.h"
#include "tests/cli/run_firn.h"
#include "tests/live/far_hosts.h"
#include "tests/live/live_checks.h"
#include "tests/live/no_hosts.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

/// A home of this build that has these programs alone, without symbols for debuggers.
fs::path small_home(const TempFolder& folder, const std::vector<std::string>& programs) {
  fs::create_directories(folder.path() / "bin");
  for (const std::string& name : programs)
    REQUIRE(
        run_command({"strip", "-o", (folder.path() / "bin" / name).string(), FIRN_BINARY_DIR "/bin/" + name})
            .code == 0);
  return folder.path();
}

std::string refusal(const std::string& address, const fs::path& home) {
  try {
    install_build(address, home);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "taken";
}

}  // namespace

TEST_CASE(
    "this build is copied to another computer, sound files stay, damaged ones are mended, and it prints "
    "there",
    "[hosts]") {
  if (no_hosts()) return;
  const FarHosts hosts({"bench"});
  const TempFolder folder;
  const fs::path home = small_home(folder, {"firn", "lamp"});
  const InstalledBuild build = install_build("bench", home);
  const fs::path there = hosts.folder() / "bench" / "data" / "firn";
  CHECK(build.program == there / "current" / "bin" / "firn");
  CHECK(build.name == build_name());
  const fs::path lamp = there / "builds" / build_folder_name() / "bin" / "lamp";
  const auto written = fs::last_write_time(lamp);
  CHECK(install_build("bench", home).program == build.program);
  CHECK(fs::last_write_time(lamp) == written);

  std::fstream(lamp, std::ios::in | std::ios::out).seekp(1000).put('?');
  install_build("bench", home);
  CHECK(file_text(lamp) == file_text(home / "bin" / "lamp"));
  CHECK(std::distance(fs::directory_iterator(there / "builds"), fs::directory_iterator()) == 1);

  Experiment e = tiny_part(83);
  e.run.time_scale = 1.0;
  e.part.shape.height_mm = 0.012;
  e.hosts.address["bench"] = "bench:" + build.program;
  e.hosts.of_node["lamp"] = "bench";
  LiveRun run(e);
  run.start(false);
  CHECK(status_of(run) == 0);
  check_finished_run(run);
}

TEST_CASE("a build that does not start at the other computer is not taken, and the one before stays",
          "[hosts]") {
  if (no_hosts()) return;
  const FarHosts hosts({"bench"});
  const TempFolder folder, broken;
  const InstalledBuild build = install_build("bench", small_home(folder, {"firn"}));
  fs::create_directory(broken.path() / "bin");
  std::ofstream(broken.path() / "bin" / "firn") << "#!/bin/sh\necho 'firn: error while loading shared "
                                                   "libraries: libnlopt.so.0: no such file' >&2\nexit 127\n";
  fs::permissions(broken.path() / "bin" / "firn", fs::perms::owner_all);
  CHECK_THAT(refusal("bench", broken.path()), Contains("does not take this build") &&
                                                  Contains("libnlopt.so.0") && Contains("docs/packages.md"));
  CHECK(run_command({build.program, "--version"}).output == build.name + "\n");
  CHECK_THAT(refusal("nowhere", broken.path()), Contains("cannot be reached"));
}

TEST_CASE("firn host --install asks for hosts, and names each computer that does not take the build",
          "[hosts]") {
  const TempFolder folder;
  const std::string file = (folder.path() / "lab.toml").string();
  std::ofstream(file) << "include = \"" << kInkjet << "\"\n";
  CHECK_THAT(firn_says({"host", "--install", file}).err, Contains("has no [hosts]"));
  std::ofstream(file) << "include = \"" << kInkjet << "\"\n[hosts]\nbench = \"no-such-computer.invalid\"\n";
  CHECK_THAT(firn_says({"host", "--install", file, "--host", "attic"}).err,
             Contains("[hosts] has no 'attic'"));
  const Said said = firn_says({"host", "--install", file});
  CHECK(said.code == 3);
  CHECK_THAT(said.err, Contains("host bench (no-such-computer.invalid) cannot be reached"));
}
