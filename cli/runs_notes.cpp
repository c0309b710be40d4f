#include <fmt/core.h>

#include <cstdio>
#include <filesystem>

#include "cli/runs_command.h"
#include "cli/user_config.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "runs/folder/address.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path run_of(const RunsOptions& o, const std::string& action) {
  if (o.words.size() < 2) throw UsageError(action + ": give a run folder");
  const fs::path run = runs::folder_of(o.words[1], one_place(o));
  runs::require_run(run);
  return run;
}

std::string author_of(const RunsOptions& o) {
  return o.author.empty() ? read_user_config().name : o.author;  // empty: the user of this process
}

int show(const fs::path& run, bool json) {
  const runs::RunNotes all = runs::read_notes(run);
  if (json) {
    fmt::print("{}\n", Json{{"run", run.string()},
                            {"tags", all.tags()},
                            {"notes", notes_json(all.notes())},
                            {"acknowledged", notes_json(all.acknowledged())}}
                           .dump(2, ' ', false, Json::error_handler_t::replace));
    return kOk;
  }
  std::string tags;
  for (const std::string& tag : all.tags()) tags += (tags.empty() ? "" : ", ") + tag;
  if (!tags.empty()) fmt::print("tags: {}\n", tags);
  for (const runs::NoteEntry& n : all.notes())
    fmt::print("{}  {}: {}\n", n.time_utc.empty() ? "before 0.2" : n.time_utc,
               n.author.empty() ? "?" : n.author, n.text);
  for (const runs::NoteEntry& n : all.acknowledged())
    fmt::print("{}  {} acknowledged: {}\n", n.time_utc, n.author, n.text);
  if (all.entries.empty()) fmt::print("no notes and no tags\n");
  if (all.unreadable > 0)
    fmt::print(stderr, "{}: {} lines of its notes cannot be read\n", run.string(), all.unreadable);
  return kOk;
}

}  // namespace

nlohmann::ordered_json notes_json(const std::vector<runs::NoteEntry>& notes) {
  Json all = Json::array();
  for (const runs::NoteEntry& n : notes)
    all.push_back({{"time_utc", n.time_utc}, {"author", n.author}, {"host", n.host}, {"text", n.text}});
  return all;
}

int tag_run(const RunsOptions& o) {
  const fs::path run = run_of(o, "tag");
  if (o.words.size() == 2) {
    if (o.remove) throw UsageError("tag --remove: which tags?");
    return show(run, o.json);
  }
  std::vector<runs::NoteEntry> entries;
  for (std::size_t n = 2; n < o.words.size(); ++n)
    entries.push_back({o.remove ? runs::NoteEntry::Kind::kUntag : runs::NoteEntry::Kind::kTag,
                       o.words[n],
                       author_of(o),
                       {},
                       {}});
  runs::add_notes(run, std::move(entries));
  return o.json ? show(run, true) : kOk;
}

int note_run(const RunsOptions& o) {
  const fs::path run = run_of(o, "note");
  if (o.words.size() == 2) return show(run, o.json);
  if (o.words.size() > 3) throw UsageError("note: one text is wanted, in quotes");
  runs::add_notes(run, {{runs::NoteEntry::Kind::kNote, o.words[2], author_of(o), {}, {}}});
  return o.json ? show(run, true) : kOk;
}

int seal_runs(const RunsOptions& o) {
  if (o.words.size() < 2) throw UsageError("seal: give at least one run folder");
  Json all = Json::array();
  for (std::size_t n = 1; n < o.words.size(); ++n) {
    const fs::path run = runs::folder_of(o.words[n], one_place(o));
    runs::require_run(run);
    const runs::RunLock lock(run, runs::RunUse::kWrite);
    const bool sealed = runs::seal_notes(run);
    const std::string summary = runs::check_seals(run).summary();
    if (o.json)
      all.push_back({{"run", run.string()}, {"sealed_now", sealed}, {"seal", summary}});
    else
      fmt::print("{}: {}{}\n", run.string(), sealed ? "" : "no new notes; ", summary);
  }
  if (o.json) fmt::print("{}\n", all.dump(2));
  return kOk;
}

}  // namespace firn
