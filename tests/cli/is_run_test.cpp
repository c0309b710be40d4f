// A folder is a run for all commands, lists and readers, or for none of them.
#include <catch2/catch.hpp>

#include "files/usage_error.h"
#include "page/run_set.h"
#include "runs/folder/list.h"
#include "runs/folder/run_folder.h"
#include "runs/read/run_log.h"
#include "runs/read/run_reader.h"
#include "tests/cli/run_firn.h"

using namespace firn;
using namespace firn::test;
namespace fs = std::filesystem;

namespace {

template <class Use>
bool taken(Use use) try {
  use();
  return true;
} catch (const UsageError& error) {
  CHECK_THAT(error.what(), Catch::Contains("is no run folder: it has no "));
  return false;
}

bool command_takes(std::vector<std::string> words) {
  const Said said = firn_says(words);
  return (said.out + said.err).find("is no run folder: it has no ") == std::string::npos;
}

}  // namespace

TEST_CASE("a folder with any of experiment.toml, provenance.json and nodes/ is a run everywhere or nowhere") {
  constexpr const char* kParts[] = {"experiment.toml", "provenance.json", "nodes"};
  const fs::path whole = golden_copy("v1-mpc", "is-run-whole");
  for (unsigned parts = 0; parts < 8; ++parts) {
    const fs::path place = fresh_folder("is-run"), run = place / "run";
    fs::copy(whole, run, fs::copy_options::recursive);
    for (unsigned n = 0; n < 3; ++n)
      if (!(parts >> n & 1)) fs::remove_all(run / kParts[n]);
    const bool expected = parts == 7;
    INFO("parts " << parts);
    CHECK(runs::is_run(run) == expected);
    CHECK(taken([&] { runs::RunFolder::open(run); }) == expected);
    CHECK(taken([&] { runs::RunReader all(run); }) == expected);
    CHECK(taken([&] { runs::read_texts(run); }) == expected);
    CHECK(runs::list_runs(place).size() == (expected ? 1 : 0));
    for (const fs::path& shown : {run, place})
      CHECK((page::RunSet({shown}, {}).list()().find("\"label\":\"run\"") != std::string::npos) == expected);
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {"replay", run.string()},
             {"audit", run.string()},
             {"report", run.string(), "--no-replay", "-o", (place / "r.html").string()},
             {"export", run.string(), "-o", (place / "r.csv").string()},
             {"ctl", run.string(), "pause"},
             {"runs", "pack", run.string()}}) {
      INFO(words.front());
      CHECK(command_takes(words) == expected);
    }
  }
}
