#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "cli/runs_command.h"
#include "core/options/enumerators.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/interrupt.h"
#include "print/progress.h"
#include "runs/folder/archive_copy.h"
#include "runs/folder/far_archive.h"
#include "runs/folder/run_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using CopyState = runs::ArchiveCopy::State;

constexpr const char* kCopyStates[] = {"copied", "renewed", "is there", "left out"};
static_assert(std::size(kCopyStates) == kTableSize<CopyState>);

std::vector<fs::path> runs_of_places(const std::vector<std::string>& places) {
  std::vector<fs::path> found;
  for (const fs::path place : places) {
    if (!fs::is_directory(place))
      throw UsageError(place.string() +
                       ": no such folder: nothing has been printed there yet; --runs names another");
    if (runs::is_run(place)) {
      found.push_back(place);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(place))
      if (runs::is_run(entry.path())) found.push_back(entry.path());
  }
  std::ranges::sort(found);
  return found;
}

std::unique_ptr<runs::Archive> archive_at(const std::string& word) {
  if (auto far = runs::far_place(word)) return std::make_unique<runs::FarArchive>(std::move(*far));
  return std::make_unique<runs::FolderArchive>(word);
}

runs::ArchiveCopy copy_one(const fs::path& run, runs::Archive& archive) try {
  return runs::copy_to_archive(run, archive);
} catch (const UsageError& e) {
  if (std::string_view(e.what()).find("rsync is not installed") != std::string_view::npos) throw;
  return {CopyState::kLeftOut, e.what(), ""};
} catch (const std::runtime_error& e) {
  return {CopyState::kLeftOut, e.what(), ""};
}

}  // namespace

int sync_runs(const RunsOptions& o) {
  if (o.words.size() != 2) throw UsageError("sync: give the folder of the archive, or HOST:PATH");
  const std::vector<fs::path> all = runs_of_places(o.runs);
  const std::unique_ptr<runs::Archive> archive = archive_at(o.words[1]);
  nlohmann::ordered_json told = nlohmann::ordered_json::array();
  JobProgress progress("copying");
  const InterruptGuard guard;
  bool failed = false;
  std::size_t done = 0;
  for (const fs::path& run : all) {
    if (InterruptGuard::raised()) return kInterrupted;
    progress.show(double(done++) / double(all.size()), run.filename().string());
    const runs::ArchiveCopy copy = copy_one(run, *archive);
    failed = failed || copy.state == CopyState::kLeftOut;
    const char* state = kCopyStates[std::size_t(copy.state)];
    told.push_back({{"run", run.string()}, {"state", state}, {"why", copy.why}, {"seal", copy.digest}});
    if (o.json) continue;
    progress.done();
    fmt::print("{}: {}{}\n", run.string(), state, copy.why.empty() ? "" : ": " + copy.why);
  }
  progress.done();
  if (o.json) fmt::print("{}\n", told.dump(2));
  if (all.empty() && !o.json) fmt::print("no runs\n");
  return failed ? kFailed : kOk;
}

}  // namespace firn
