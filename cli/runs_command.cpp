// run_runs lists, finds, packs and removes run folders.
#include "cli/commands.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/runs_command.h"
#include "config/labs.h"
#include "core/grid/grid.h"
#include "core/grid/outline.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/hosts/run_hosts.h"
#include "print/operator/operator_client.h"
#include "print/progress.h"
#include "runs/folder/address.h"
#include "runs/folder/list.h"
#include "runs/folder/pack.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/verdict.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string size_text(std::uint64_t bytes) {
  return bytes >= 1'000'000'000 ? fmt::format("{:.1f} GB", double(bytes) * 1e-9)
         : bytes >= 1'000'000   ? fmt::format("{:.1f} MB", double(bytes) * 1e-6)
                                : fmt::format("{:.0f} kB", double(bytes) * 1e-3);
}

Json entry_json(const runs::RunEntry& r) {
  const runs::RunResult result = r.result.value_or(runs::RunResult{});
  const auto known = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
  Json j{{"run", r.folder.string()},
         {"address", runs::address_of(r.folder).text()},
         {"started_utc", r.started_utc},
         {"name", r.name},
         {"lab", r.lab},
         {"scheme", r.scheme},
         {"outcome", r.outcome},
         {"layers", r.layers},
         {"reason", r.reason},
         {"bytes", r.bytes},
         {"part", result.part ? Json(result.part->name) : Json(nullptr)},
         {"size_mm", result.part ? Json(result.part->size_mm) : Json(nullptr)},
         {"tolerance_um", known(result.tolerance_um)},
         {"overspill_percent", known(result.overspill_percent)},
         {"audit", result.audit.empty() ? Json(nullptr) : Json(result.audit)},
         {"host", r.meta.host.empty() ? Json(nullptr) : Json(r.meta.host)},
         {"meta", Json::object()},
         {"tags", r.notes.tags()},
         {"notes", notes_json(r.notes.notes())}};
  for (const MetaEntry& m : r.meta.values) std::visit([&](const auto& v) { j["meta"][m.key] = v; }, m.value);
  for (const auto& [key, um] : {std::pair("rms_um", &runs::MapError::rms_um),
                                {"rms_inside_um", &runs::MapError::rms_inside_um},
                                {"rms_rim_um", &runs::MapError::rms_rim_um}})
    j[key] = result.error ? Json((*result.error).*um) : Json(nullptr);
  for (const OutlineMetric& m : kOutlineMetrics)
    if (m.value != &OutlineStats::overspill) {
      const double v = result.outline ? (*result.outline).*m.value * m.factor : kNotMeasured;
      j[std::string(m.name)] = std::isfinite(v) ? Json(v) : Json(nullptr);
    }
  const std::string verdict = r.result ? verdict_words(result, lab_words(r.lab)) : "";
  j["verdict"] = verdict.empty() ? Json(nullptr) : Json(verdict);
  return j;
}

// A line a run, and below it its part and verdict.
void show_run(const runs::RunEntry& r) {
  const LabWords& words = lab_words(r.lab);
  const bool measured = r.result && r.result->error;
  fmt::print("{:<44} {:<10} {:>4} layers {:>14} {:>9}  {}\n", r.folder.string(), r.scheme, r.layers,
             measured ? "RMS " + words.length(r.result->error->rms_um) : "", size_text(r.bytes), r.outcome);
  if (const std::string printed = runs::meta_words(r.meta.values); !printed.empty())
    fmt::print("    {}\n", printed);
  std::string tags;
  for (const std::string& tag : r.notes.tags()) tags += (tags.empty() ? "" : ", ") + tag;
  if (!tags.empty()) fmt::print("    tags: {}\n", tags);
  for (const runs::NoteEntry& n : r.notes.notes()) fmt::print("    note: {}\n", n.text);
  if (!r.result) return;
  std::string text = r.result->part ? part_words(*r.result->part) : "";
  const auto add = [&](const std::string& more) {
    text += (text.empty() || more.empty() ? "" : "; ") + more;
  };
  if (r.result->overspill_percent) add("overspill " + for_people(*r.result->overspill_percent) + " %");
  if (!r.result->audit.empty()) add("audit " + r.result->audit);
  const std::string verdict = verdict_words(*r.result, words);
  add(verdict.empty() ? for_people(r.reason) : verdict);
  fmt::print("    {}\n", text);
}

// Paused or not says the print itself.
void ask_state(runs::RunEntry& r) {
  if (const std::string state = OperatorClient::state_of(r.folder); state != "running")
    r.outcome = state + r.outcome.substr(std::string_view("running").size());
}

void show_runs(std::vector<runs::RunEntry> runs, bool json, const char* nothing) {
  for (runs::RunEntry& r : runs)
    if (r.running) ask_state(r);
  if (json) {
    Json all = Json::array();
    for (const runs::RunEntry& r : runs) all.push_back(entry_json(r));
    return fmt::print("{}\n", all.dump(2, ' ', false, Json::error_handler_t::replace));
  }
  std::uint64_t sum = 0;
  for (const runs::RunEntry& r : runs) {
    show_run(r);
    sum += r.bytes;
  }
  if (runs.empty())
    fmt::print("{}\n", nothing);
  else
    fmt::print("{} runs, {}\n", runs.size(), size_text(sum));
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
  std::vector<runs::RunEntry> runs = runs::list_runs(o.runs);
  if (o.keep) runs.resize(runs.size() - std::min(runs.size(), std::size_t(*o.keep)));
  std::erase_if(runs, [&](const runs::RunEntry& r) {
    return r.running || (o.older_than_days && age_days(r) < *o.older_than_days) ||
           (!o.outcome.empty() && r.outcome != o.outcome);
  });
  show_runs(runs, o.json, "no run to remove");
  if (!o.yes) {
    if (!runs.empty()) fmt::print(stderr, "nothing was removed; --yes removes them\n");
    return kOk;
  }
  runs::finish_removals(o.runs);
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
      fmt::print("{}: {} -> {}\n", run.string(), size_text(r.before), size_text(r.after));
  }
  if (o.json) fmt::print("{}\n", all.dump(2));
  return kOk;
}

// The records that a print left on other hosts.
void collect(const fs::path& folder) {
  const runs::RunFolder run = runs::RunFolder::open(folder);
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
  if (further != (action == "find" ? 1 : 0))
    throw UsageError(action + (action == "find" ? ": one WORD is wanted" : ": takes no further word"));
  if (action == "clean") return clean(o);
  if (action != "list" && action != "find")
    throw UsageError("'" + action + "' is none of list, find, tag, note, seal, clean, pack, expand, collect");
  std::vector<runs::RunEntry> runs = runs::list_runs(o.runs);
  if (action == "find")
    std::erase_if(runs, [&](const runs::RunEntry& r) { return !runs::mentions(r, o.words[1]); });
  show_runs(runs, o.json, action == "find" ? "no run mentions it" : "no runs");
  return kOk;
}

}  // namespace

void declare_runs(OptionSet& options) {
  auto& o = options.calls(run_runs);
  options.option(
      "ACTION", o.words,
      "list (default) | find WORD | tag RUN TAG... | note RUN TEXT | seal RUN... | clean | pack RUN... | "
      "expand RUN... | collect RUN...; docs/commands/runs.md");
  options.runs_option(o.runs, "where the run folders are");
  options.option("--older-than", o.older_than_days, "DAYS: clean: runs that began before").within(0.0, 1e6);
  options.option("--keep", o.keep, "N: clean: all but the newest N").within(0, 1'000'000);
  options.option("--outcome", o.outcome, "clean: runs that ended so: \"interrupted\", \"stopped safely\"");
  options.option("--author", o.author, "NAME: tag, note: who writes it; default: the user");
  options.flag("--remove", o.remove, "tag: takes the tags away");
  options.flag("--yes", o.yes, "clean: remove them; without it they are only listed");
  options.json_flag(o.json);
}

}  // namespace firn
