#include "cli/runs_command.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>

#include "cli/option_set.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/exit_codes.h"
#include "print/folder/run_list.h"
#include "print/folder/run_pack.h"
#include "print/folder/running.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string size_text(std::uint64_t bytes) {
  return bytes >= 1'000'000'000 ? fmt::format("{:.1f} GB", double(bytes) * 1e-9)
         : bytes >= 1'000'000   ? fmt::format("{:.1f} MB", double(bytes) * 1e-6)
                                : fmt::format("{:.0f} kB", double(bytes) * 1e-3);
}

Json entry_json(const RunEntry& r) {
  return {
      {"run", r.folder.string()}, {"started_utc", r.started_utc}, {"name", r.name},     {"scheme", r.scheme},
      {"outcome", r.outcome},     {"layers", r.layers},           {"reason", r.reason}, {"bytes", r.bytes}};
}

void show_runs(const std::vector<RunEntry>& runs, bool json, const char* nothing) {
  if (json) {
    Json all = Json::array();
    for (const RunEntry& r : runs) all.push_back(entry_json(r));
    return fmt::print("{}\n", all.dump(2));
  }
  std::uint64_t sum = 0;
  for (const RunEntry& r : runs) {
    fmt::print("{:<44} {:<10} {:>4} layers {:>9}  {}\n", r.folder.string(), r.scheme, r.layers,
               size_text(r.bytes), r.outcome);
    sum += r.bytes;
  }
  if (runs.empty())
    fmt::print("{}\n", nothing);
  else
    fmt::print("{} runs, {}\n", runs.size(), size_text(sum));
}

double age_days(const RunEntry& r) {
  std::tm tm{};
  if (!::strptime(r.started_utc.c_str(), "%Y-%m-%dT%H:%M:%SZ", &tm)) return 0.0;
  const auto started = std::chrono::system_clock::from_time_t(::timegm(&tm));
  return std::chrono::duration<double>(std::chrono::system_clock::now() - started).count() / 86'400.0;
}

int clean(const RunsOptions& o) {
  if (!o.older_than_days && !o.keep && o.outcome.empty())
    throw UsageError("clean: which runs? give --older-than DAYS, --keep N or --outcome TEXT");
  std::vector<RunEntry> runs = list_runs(o.runs);
  if (o.keep) runs.resize(runs.size() - std::min(runs.size(), std::size_t(*o.keep)));
  std::erase_if(runs, [&](const RunEntry& r) {
    return r.running || (o.older_than_days && age_days(r) < *o.older_than_days) ||
           (!o.outcome.empty() && r.outcome != o.outcome);
  });
  show_runs(runs, o.json, "no run to remove");
  if (!o.yes) {
    if (!runs.empty()) fmt::print(stderr, "nothing was removed; --yes removes them\n");
    return kOk;
  }
  for (const RunEntry& r : runs) {
    refuse_running(r.folder);  // a resume may have begun meanwhile
    fs::remove_all(r.folder);
  }
  return kOk;
}

int for_each_run(const RunsOptions& o, PackReport (*act)(const fs::path&)) {
  Json all = Json::array();
  for (std::size_t n = 1; n < o.words.size(); ++n) {
    const fs::path run = o.words[n];
    if (!fs::exists(run / "provenance.json")) throw UsageError(run.string() + ": is no run folder");
    const PackReport r = act(run);
    if (o.json)
      all.push_back({{"run", run.string()}, {"bytes_before", r.before}, {"bytes", r.after}});
    else
      fmt::print("{}: {} -> {}\n", run.string(), size_text(r.before), size_text(r.after));
  }
  if (o.json) fmt::print("{}\n", all.dump(2));
  return kOk;
}

}  // namespace

int run_runs(const RunsOptions& o) {
  const std::string action = o.words.empty() ? "list" : o.words.front();
  const std::size_t further = o.words.empty() ? 0 : o.words.size() - 1;
  if (action == "pack" || action == "expand") {
    if (further == 0) throw UsageError(action + ": give at least one run folder");
    return for_each_run(o, action == "pack" ? pack_run : expand_run);
  }
  if (further != (action == "find" ? 1 : 0))
    throw UsageError(action + (action == "find" ? ": one WORD is wanted" : ": takes no further word"));
  if (action == "clean") return clean(o);
  if (action != "list" && action != "find")
    throw UsageError("'" + action + "' is none of list, find, clean, pack, expand");
  std::vector<RunEntry> runs = list_runs(o.runs);
  if (action == "find") std::erase_if(runs, [&](const RunEntry& r) { return !mentions(r, o.words[1]); });
  show_runs(runs, o.json, action == "find" ? "no run mentions it" : "no runs");
  return kOk;
}

void declare_runs(OptionSet& options) {
  auto& o = options.calls(run_runs);
  options.option("ACTION", o.words,
                 "list (default) | find WORD | clean | pack RUN... | expand RUN...; docs/commands/runs.md");
  options.option("--runs", o.runs, "where the run folders are").show_default();
  options.option("--older-than", o.older_than_days, "DAYS: clean: runs that began before").within(0.0, 1e6);
  options.option("--keep", o.keep, "N: clean: all but the newest N").within(0, 1'000'000);
  options.option("--outcome", o.outcome, "clean: runs that ended so: \"interrupted\", \"stopped safely\"");
  options.flag("--yes", o.yes, "clean: remove them; without it they are only listed");
  options.json_flag(o.json);
}

}  // namespace firn
