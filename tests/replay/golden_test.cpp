// Runs that earlier versions recorded: they must decode and replay for ever (scripts/make_golden.sh adds
// more).
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "cli/audit_command.h"
#include "cli/replay_command.h"
#include "lcmtypes/channels.h"
#include "print/folder/node_makers.h"
#include "replay/print_verdict.h"

namespace firn {
namespace {

std::vector<std::filesystem::path> golden_runs() {
  std::vector<std::filesystem::path> runs;
  for (const auto& entry : std::filesystem::directory_iterator(FIRN_SOURCE_DIR "/tests/replay/golden"))
    if (entry.is_directory()) runs.push_back(entry.path());
  std::sort(runs.begin(), runs.end());
  return runs;
}

TEST_CASE("every golden run replays identical") {
  REQUIRE(golden_runs().size() >= 2);
  for (const auto& run : golden_runs()) {
    ReplayCommandOptions o;
    o.run = run.string();
    const replay::RunVerdict v = replay_verdict(o);
    INFO(run.string() << "\n" << replay::to_text(v));
    CHECK(v.identical());
    CHECK(v.log_present);
  }
}

TEST_CASE("every node of the house has a golden run that replays it") {
  std::set<std::string> recorded;
  for (const auto& run : golden_runs())
    for (const auto& file : std::filesystem::directory_iterator(run / "nodes"))
      if (file.path().extension() == ".wal") recorded.insert(file.path().stem().string());
  for (const NamedMaker& maker : node_makers()) {
    INFO(info(maker.id).name);
    CHECK(recorded.contains(std::string(info(maker.id).name)));
  }
}

TEST_CASE("every golden run passes the audit against the world's record") {
  for (const auto& run : golden_runs()) {
    const replay::AuditVerdict v = audit_verdict(run);
    INFO(run.string());
    CHECK(v.with_world);
    CHECK(v.clean());
    CHECK(v.finished);
  }
}

}  // namespace
}  // namespace firn
