#include "runs/folder/list.h"

#include <algorithm>

#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/pack.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/running.h"

namespace firn::runs {

namespace fs = std::filesystem;

RunEntry run_entry(const fs::path& folder) {
  RunEntry e;
  e.folder = folder;
  const auto pid = printing_process(folder);
  e.running = pid.has_value();
  try {
    const auto provenance = nlohmann::json::parse(read_file(RunPaths(folder).provenance_path()));
    e.started_utc = provenance.value("started_utc", "");
    e.name = provenance.value("name", "");
    e.scheme = provenance.value("scheme", "");
    if (const auto id = provenance.find("run_id"); id != provenance.end() && id->is_number_integer())
      e.run_id = id->get<std::int64_t>();  // of a run that cannot be read, too: orders go by it
    if (const auto seeds = provenance.find("seeds"); seeds != provenance.end() && seeds->is_object())
      if (const auto seed = seeds->find("plant"); seed != seeds->end() && seed->is_number_integer())
        e.seed = seed->get<std::int64_t>();
    e.bytes = folder_bytes(folder);
    const RunFolder run = RunFolder::open(folder);
    e.lab = lab_kind_in(run.experiment_toml());
    e.meta = run_meta(run.provenance());
    e.notes = read_notes(folder);
    e.result = pid ? std::nullopt : run.result();
    e.outcome = pid        ? "running (pid " + std::to_string(*pid) + ")"
                : e.result ? e.result->outcome
                           : "interrupted";
    if (e.result) {
      e.reason = e.result->reason;
      e.layers = e.result->layers;
    }
  } catch (const std::exception& error) {
    e.outcome = "unreadable";
    e.reason = error.what();
  }
  return e;
}

std::vector<RunEntry> list_runs(const fs::path& root) {
  if (!fs::is_directory(root))
    throw UsageError(root.string() +
                     ": no such folder: nothing has been printed there yet; --runs names another");
  std::vector<RunEntry> runs;
  for (const auto& entry : fs::directory_iterator(root))
    if (is_run(entry.path())) runs.push_back(run_entry(entry.path()));
  std::ranges::sort(runs, {}, [](const RunEntry& r) { return std::pair(r.started_utc, r.folder.string()); });
  return runs;
}

bool remove_run(const RunEntry& seen) {
  const fs::path root = seen.folder.parent_path(),
                 going = root / (kRemoving + seen.folder.filename().string());
  const RunLock lock(seen.folder, RunUse::kRemove);
  const RunEntry now = run_entry(seen.folder);
  if (now.outcome != seen.outcome || now.started_utc != seen.started_utc) return false;
  if (fs::is_symlink(fs::symlink_status(seen.folder))) return fs::remove(seen.folder);
  fs::rename(seen.folder, going);
  fs::remove_all(going);
  return true;
}

void finish_removals(const fs::path& root) {
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(root))
    if (entry.path().filename().string().starts_with(kRemoving)) left.push_back(entry.path());
  for (const fs::path& folder : left) try {
      const RunLock lock(folder, RunUse::kRemove);
      fs::remove_all(folder);
    } catch (const UsageError&) {  // another process is removing it
    }
}

}  // namespace firn::runs
