#include <fmt/core.h>

#include <algorithm>
#include <cstdio>

#include "cli/runs_command.h"
#include "config/labs.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/operator/operator_client.h"
#include "print/progress.h"
#include "runs/find/query.h"
#include "runs/find/query_sql.h"
#include "runs/find/run_index.h"
#include "runs/folder/address.h"
#include "runs/folder/verdict.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of_listing(const Json& j, const char* key) {
  const auto at = j.find(key);
  return at != j.end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::string joined_texts(const Json& list) {
  std::string text;
  for (const Json& one : list) text += (text.empty() ? "" : ", ") + one.get<std::string>();
  return text;
}

std::string meta_line(const Json& meta) {
  std::string text;
  for (const auto& [key, value] : meta.items())
    text += (text.empty() ? "" : ", ") + key + " " +
            (value.is_string() ? value.get<std::string>() : value.dump());
  return text;
}

// A line a run, and below it [meta], its part and its verdict.
void show_listed(const std::filesystem::path& folder, const Json& j, const std::string& outcome) {
  const LabWords& words = lab_words(text_of_listing(j, "lab"));
  fmt::print("{:<44} {:<10} {:>4} layers {:>14} {:>9}  {}\n", folder.string(), text_of_listing(j, "scheme"),
             j.at("layers").get<int>(),
             j.at("rms_um").is_null() ? "" : "RMS " + words.length(j.at("rms_um").get<double>()),
             runs_size_text(j.at("bytes").get<std::uint64_t>()), outcome);
  if (!j.at("meta").empty()) fmt::print("    {}\n", meta_line(j.at("meta")));
  if (!j.at("tags").empty()) fmt::print("    tags: {}\n", joined_texts(j.at("tags")));
  for (const Json& note : j.at("notes")) fmt::print("    note: {}\n", text_of_listing(note, "text"));
  std::string text;
  if (!j.at("part").is_null()) {
    const Json& size = j.at("size_mm");
    text = runs::part_words({text_of_listing(j, "part"), {size.at(0), size.at(1), size.at(2)}});
  }
  const auto add = [&](const std::string& more) {
    text += (text.empty() || more.empty() ? "" : "; ") + more;
  };
  if (!j.at("overspill_percent").is_null())
    add("overspill " + for_people(j.at("overspill_percent").get<double>()) + " %");
  if (!j.at("audit").is_null()) add("audit " + text_of_listing(j, "audit"));
  const std::string verdict = text_of_listing(j, "verdict");
  add(verdict.empty() ? for_people(text_of_listing(j, "reason")) : verdict);
  if (!text.empty()) fmt::print("    {}\n", text);
}

// Paused or not says the print itself.
std::string outcome_now(const std::filesystem::path& folder, const Json& listing) {
  constexpr std::string_view kRunning = "running";
  const std::string outcome = text_of_listing(listing, "outcome");
  if (!outcome.starts_with(kRunning)) return outcome;
  const std::string state = OperatorClient::state_of(folder);
  return state == kRunning ? outcome : state + outcome.substr(kRunning.size());
}

}  // namespace

std::string runs_size_text(std::uint64_t bytes) {
  return bytes >= 1'000'000'000 ? fmt::format("{:.1f} GB", double(bytes) * 1e-9)
         : bytes >= 1'000'000   ? fmt::format("{:.1f} MB", double(bytes) * 1e-6)
                                : fmt::format("{:.0f} kB", double(bytes) * 1e-3);
}

std::filesystem::path one_place(const RunsOptions& o) {
  if (o.runs.size() != 1) throw UsageError("--runs: one folder is wanted; list and find take several");
  return o.runs.front();
}

void show_runs(const std::vector<ListedRun>& runs, bool json, const char* nothing) {
  if (json) {
    Json all = Json::array();
    for (const ListedRun& r : runs) {
      Json one{{"run", r.folder.string()}, {"address", runs::address_of(r.folder).text()}};
      one.update(Json::parse(r.listing));
      one["outcome"] = outcome_now(r.folder, one);
      all.push_back(std::move(one));
    }
    return fmt::print("{}\n", all.dump(2, ' ', false, Json::error_handler_t::replace));
  }
  std::uint64_t sum = 0;
  for (const ListedRun& r : runs) {
    const Json listing = Json::parse(r.listing);
    show_listed(r.folder, listing, outcome_now(r.folder, listing));
    sum += listing.at("bytes").get<std::uint64_t>();
  }
  if (runs.empty())
    fmt::print("{}\n", nothing);
  else
    fmt::print("{} runs, {}\n", runs.size(), runs_size_text(sum));
}

int find_runs(const RunsOptions& o) {
  if (o.words.size() < 2)
    throw UsageError("find: which runs? 'rms_um < 2 and meta.ink ~ \"TPGDA\"', or a word");
  std::string condition;
  for (std::size_t n = 1; n < o.words.size(); ++n) condition += (n > 1 ? " " : "") + o.words[n];
  const runs::FindOptions options{o.sort.starts_with('-') ? o.sort.substr(1) : o.sort,
                                  o.sort.starts_with('-'), std::size_t(o.limit)};
  std::vector<ListedRun> found;
  try {
    const runs::Query query = runs::parse_query(condition);
    runs::sql_of(query, condition);  // before runs are read
    try {
      runs::check_query_key(options.sort, options.sort, 1);
    } catch (const runs::QueryError& e) {
      throw UsageError("--sort: " + e.problem);
    }
    runs::RunIndex index(runs::user_index(),
                         [](const std::string& line) { fmt::print(stderr, "{}\n", line); });
    const std::vector<std::filesystem::path> places(o.runs.begin(), o.runs.end());
    JobProgress progress("reading runs");
    index.refresh(places, [&](double fraction) { progress.show(fraction, ""); });
    progress.done();
    for (const runs::FoundRun& r : index.find(query, condition, places, options))
      found.push_back({r.folder, r.listing});
  } catch (const runs::QueryError& e) {
    fmt::print(stderr, "{}", e.shown);
    throw UsageError(std::string("find: ") + e.what());
  }
  show_runs(found, o.json, "no run meets the condition");
  return kOk;
}

}  // namespace firn
