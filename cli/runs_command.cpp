// run_runs lists, finds, packs and removes run folders.
#include "cli/commands.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/runs_command.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/hosts/run_hosts.h"
#include "print/progress.h"
#include "runs/find/run_facts.h"
#include "runs/folder/host_record.h"
#include "runs/folder/list.h"
#include "runs/folder/pack.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::vector<ListedRun> listed(const std::vector<runs::RunEntry>& entries) {
  std::vector<ListedRun> all;
  for (const runs::RunEntry& e : entries) all.push_back({e.folder, runs::run_listing_text(e)});
  return all;
}

double age_days(const runs::RunEntry& r) {
  std::tm tm{};
  if (!::strptime(r.started_utc.c_str(), "%Y-%m-%dT%H:%M:%SZ", &tm)) return 0.0;
  const auto started = std::chrono::system_clock::from_time_t(::timegm(&tm));
  return std::chrono::duration<double>(std::chrono::system_clock::now() - started).count() / 86'400.0;
}

int clean(const RunsOptions& o) {
  if (!o.older_than_days && !o.keep && o.outcome.empty())
    throw UsageError("clean: which runs? give --older-than DAYS, --keep N or --outcome TEXT");
  const fs::path place = one_place(o);
  std::vector<runs::RunEntry> runs = runs::list_runs(place);
  if (o.keep) runs.resize(runs.size() - std::min(runs.size(), std::size_t(*o.keep)));
  std::erase_if(runs, [&](const runs::RunEntry& r) {
    return r.running || (o.older_than_days && age_days(r) < *o.older_than_days) ||
           (!o.outcome.empty() && r.outcome != o.outcome);
  });
  show_runs(listed(runs), o.json, "no run to remove");
  if (!o.yes) {
    if (!runs.empty()) fmt::print(stderr, "nothing was removed; --yes removes them\n");
    return kOk;
  }
  runs::finish_removals(place);
  for (const runs::RunEntry& r : runs)
    if (!runs::remove_run(r))
      fmt::print(stderr, "{}: has changed since it was listed; it stays\n", r.folder.string());
  return kOk;
}

int for_each_run(const RunsOptions& o, const std::string& action) {
  Json all = Json::array();
  JobProgress progress(action);
  const runs::PackWatch watch{
      [&](double fraction, const std::string& file) { progress.show(fraction, file); }, {}};
  for (std::size_t n = 1; n < o.words.size(); ++n) {
    const fs::path run = o.words[n];
    runs::require_run(run);
    const runs::PackReport r = action == "pack" ? runs::pack_run(run, watch) : runs::expand_run(run, watch);
    progress.done();
    if (o.json)
      all.push_back({{"run", run.string()}, {"bytes_before", r.before}, {"bytes", r.after}});
    else
      fmt::print("{}: {} -> {}\n", run.string(), runs_size_text(r.before), runs_size_text(r.after));
  }
  if (o.json) fmt::print("{}\n", all.dump(2));
  return kOk;
}

// The records that a print left on other hosts.
void collect(const fs::path& folder) {
  const runs::RunFolder run = runs::RunFolder::open(folder);
  if (runs::host_records(folder).empty()) {
    fmt::print("{}: was printed on one computer: there is nothing to collect\n", folder.string());
    return;
  }
  const runs::RunLock lock(folder, runs::RunUse::kWrite);
  collect_records(run, fs::read_symlink("/proc/self/exe").parent_path(),
                  [](const std::string& text) { fmt::print(stderr, "{}\n", text); });
  fmt::print("{}: the records of its hosts are here\n", folder.string());
}

/// @throws UsageError: an unknown action, a run folder that is none
int run_runs(const RunsOptions& o) {
  const std::string action = o.words.empty() ? "list" : o.words.front();
  const std::size_t further = o.words.empty() ? 0 : o.words.size() - 1;
  if (action == "pack" || action == "expand") {
    if (further == 0) throw UsageError(action + ": give at least one run folder");
    return for_each_run(o, action);
  }
  if (action == "collect") {
    if (further == 0) throw UsageError(action + ": give at least one run folder");
    for (std::size_t n = 1; n < o.words.size(); ++n) collect(o.words[n]);
    return kOk;
  }
  if (action == "tag") return tag_run(o);
  if (action == "note") return note_run(o);
  if (action == "seal") return seal_runs(o);
  if (action == "find") return find_runs(o);
  if (action == "sync") return sync_runs(o);
  if (action == "use") return sum_runs_use(o);
  if (further != 0) throw UsageError(action + ": takes no further word");
  if (action == "clean") return clean(o);
  if (action != "list")
    throw UsageError("'" + action +
                     "' is none of list, find, tag, note, seal, sync, use, clean, pack, expand, collect");
  std::vector<runs::RunEntry> runs;
  for (const std::string& place : o.runs)
    for (runs::RunEntry& r : runs::list_runs(place)) runs.push_back(std::move(r));
  show_runs(listed(runs), o.json, "no runs");
  return kOk;
}

}  // namespace

void declare_runs(OptionSet& options) {
  auto& o = options.calls(run_runs);
  options.option("ACTION", o.words,
                 "list (default) | find CONDITION | tag RUN TAG... | note RUN TEXT | seal RUN... | sync "
                 "ARCHIVE | use [LAB] | clean | pack RUN... | "
                 "expand RUN... | collect RUN...; docs/commands/runs.md");
  options.runs_option(o.runs, "where the run folders are; find, list and use take several");
  options.option("--sort", o.sort, "KEY: find: order, by \"started\" by default; -KEY: from the largest");
  options.option("--limit", o.limit, "N: find: the first N alone").within(0, 1'000'000);
  options.option("--older-than", o.older_than_days, "DAYS: clean: runs that began before").within(0.0, 1e6);
  options.option("--keep", o.keep, "N: clean: all but the newest N").within(0, 1'000'000);
  options.option("--outcome", o.outcome, "clean: runs that ended so: \"interrupted\", \"stopped safely\"");
  options.option("--author", o.author, "NAME: tag, note: who writes it; default: the user");
  options.flag("--remove", o.remove, "tag: takes the tags away");
  options.flag("--yes", o.yes, "clean: remove them; without it they are only listed");
  options.json_flag(o.json);
}

}  // namespace firn
