// Golden runs (scripts/make_golden.sh): those of this minor version must replay to the last byte, those of
// earlier versions must decode for ever (docs/decisions/0012-replay-contract.md).
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "cli/replay_command.h"
#include "lcmtypes/channels.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "replay/promise.h"
#include "runs/folder/run_folder.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

std::vector<std::filesystem::path> golden_runs() {
  std::vector<std::filesystem::path> runs;
  for (const auto& entry : std::filesystem::directory_iterator(FIRN_SOURCE_DIR "/tests/replay/golden"))
    if (entry.is_directory()) runs.push_back(entry.path());
  std::sort(runs.begin(), runs.end());
  return runs;
}

replay::RunVerdict replayed(const std::filesystem::path& run) {
  ReplayCommandOptions o;
  o.run = run.string();
  return replay_verdict(full_product(), o);
}

/// Those whose replay is promised.
std::vector<std::filesystem::path> promised_runs() {
  std::vector<std::filesystem::path> runs = golden_runs();
  std::erase_if(runs, [](const std::filesystem::path& run) {
    const runs::ProvenanceDocument p = runs::RunFolder::open(run).provenance();
    return !replay::beyond_promise(p.text("version"), p.text("commit"), build_version()).empty();
  });
  return runs;
}

TEST_CASE("every golden run of this minor version replays identical") {
  for (const auto& run : promised_runs()) {
    const replay::RunVerdict v = replayed(run);
    INFO(run.string() << "\n" << replay::to_text(v));
    CHECK(v.identical());
    CHECK(v.log_present);
  }
}

TEST_CASE("every node of the house has a golden run of this minor version that replays it") {
  std::set<std::string> recorded;
  for (const auto& run : promised_runs())
    for (const auto& file : std::filesystem::directory_iterator(run / "nodes"))
      if (file.path().extension() == ".wal") recorded.insert(file.path().stem().string());
  for (const NamedMaker& maker : full_product().nodes) {
    INFO(info(maker.id).name);
    CHECK(recorded.contains(std::string(info(maker.id).name)));
  }
}

TEST_CASE("a golden run of an earlier version is read whole, and told with the commit that replays it") {
  const auto promised = promised_runs();
  int earlier = 0;
  for (const auto& run : golden_runs()) {
    if (std::ranges::find(promised, run) != promised.end()) continue;
    ++earlier;
    const replay::RunVerdict v = replayed(run);
    INFO(run.string() << "\n" << replay::to_text(v));
    CHECK(v.damage.empty());
    for (const replay::Finding& f : v.findings) CHECK(f.kind != replay::FindingKind::kUnreadable);
    REQUIRE_FALSE(v.provenance.empty());
    const std::string commit = runs::RunFolder::open(run).provenance().text("commit").substr(0, 40);
    CHECK(v.provenance.front().find("git checkout " + commit) != std::string::npos);
  }
  CHECK(earlier >= 11);
}

TEST_CASE("every golden run passes the audit against the world's record") {
  for (const auto& run : golden_runs()) {
    const replay::AuditVerdict v = replay::audit_run(run);
    INFO(run.string());
    CHECK(v.with_world);
    CHECK(v.clean());
    CHECK(v.finished);
  }
}

}  // namespace
}  // namespace firn
