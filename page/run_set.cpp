#include "page/run_set.h"

#include <algorithm>
#include <set>
#include <utility>

#include "config/experiment.h"
#include "config/labs.h"
#include "core/options/for_people.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/operator/operator_client.h"
#include "runs/folder/address.h"
#include "runs/folder/documents.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/running.h"
#include "runs/folder/verdict.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

runs::ProvenanceDocument provenance_of(const fs::path& run) {
  return runs::parse_provenance(read_file(RunPaths(run).provenance_path()), RunPaths::kProvenance);
}

// A row of the list from the run's line in the index.
Json list_row(const fs::path& folder, const std::string& label, const Json& listing,
              const std::map<fs::path, runs::RunDigest::Error>& of_opened,
              const std::map<fs::path, runs::RunDigest::Error>& known_errors) {
  const auto text = [&](const char* key) {
    const auto at = listing.find(key);
    return at != listing.end() && at->is_string() ? at->get<std::string>() : std::string();
  };
  const std::string outcome = text("outcome"), lab = text("lab");
  const bool live = outcome.starts_with("running");
  Json r{{"id", runs::RunAddress{listing.value("run_id", std::int64_t{0}), runs::place_of(folder)}.text()},
         {"label", label},
         {"lab", lab},
         {"height_unit", lab_words(lab).in_mm ? "mm" : "um"},
         {"experiment", text("name")},
         {"scheme", text("scheme")},
         {"seed", listing.value("seed", Json(nullptr))},
         {"started_utc", text("started_utc")},
         {"outcome", live ? "printing" : outcome},
         {"layers", listing.value("layers", 0)}};
  // The digest of a run that goes on is old.
  const auto& errors = live ? of_opened : known_errors;
  const auto error = errors.find(folder);
  const bool measured = !listing.at("rms_um").is_null();
  if (error != errors.end() && !measured) r["layers"] = error->second.layers;
  r["rms_um"] = measured                ? listing.at("rms_um")
                : error != errors.end() ? Json(error->second.rms_um)
                                        : Json(nullptr);
  r["mean_um"] = measured                ? listing.at("mean_um")
                 : error != errors.end() ? Json(error->second.mean_um)
                                         : Json(nullptr);
  if (outcome == "unreadable") r["trouble"] = text("reason");
  if (!listing.at("part").is_null()) {
    const Json& size = listing.at("size_mm");
    r["part"] = runs::part_words({text("part"), {size.at(0), size.at(1), size.at(2)}});
  }
  for (const char* key : {"overspill_percent", "audit", "within", "host", "meta", "tags", "notes"})
    r[key] = listing.at(key);
  const std::string verdict = text("verdict");  // or why it stopped, as firn runs has it
  const std::string words = verdict.empty() ? for_people(text("reason")) : verdict;
  r["verdict"] = words.empty() || live ? Json(nullptr) : Json(words);
  if (live) r["state"] = OperatorClient::state_of(folder);
  r["live"] = live;
  return r;
}

std::string started(const fs::path& run) try {
  return provenance_of(run).text("started_utc");
} catch (const std::exception&) {
  return "";
}

}  // namespace

RunSet::RunSet(std::vector<fs::path> places, fs::path live, fs::path index)
    : live_(std::move(live)), index_(std::make_shared<Index>(std::move(index))) {
  for (const fs::path& place : places) {
    if (!fs::is_directory(place)) throw UsageError(place.string() + ": no such folder");
    places_.push_back(fs::canonical(place));
  }
  if (!live_.empty()) live_ = fs::canonical(live_);
}

std::vector<fs::path> RunSet::folders() const { return folders(places_, live_); }

std::vector<fs::path> RunSet::folders(const std::vector<fs::path>& places, const fs::path& live) {
  std::set<fs::path> all;
  if (!live.empty()) all.insert(live);
  for (const fs::path& place : places) {
    if (runs::is_run(place)) {
      all.insert(place);
      continue;
    }
    std::error_code gone;
    for (const auto& entry : fs::directory_iterator(place, gone))
      if (runs::is_run(entry.path())) all.insert(entry.path());
  }
  return {all.begin(), all.end()};
}

std::optional<fs::path> RunSet::find(const std::string& id) const {
  if (id == kLiveRun && !live_.empty()) return live_;
  const auto address = runs::parse_address(id);
  std::optional<fs::path> named;
  for (const fs::path& folder : folders()) {
    if (address && runs::place_of(folder) == address->place && runs::address_of(folder) == *address)
      return folder;
    if (folder.filename() != id) continue;
    if (named) return std::nullopt;
    named = folder;
  }
  return named;
}

std::string RunSet::label(const fs::path& run) const {
  const auto all = folders();
  return label(run, std::ranges::count(all, run.filename(), &fs::path::filename) > 1);
}

std::string RunSet::label(const fs::path& run, bool others_have_the_name) {
  return run.filename().string() + (others_have_the_name ? " in " + run.parent_path().string() : "");
}

std::shared_ptr<WatchedRun> RunSet::opened(const std::string& id) {
  const auto folder = find(id);
  const auto at = folder ? opened_.find(*folder) : opened_.end();
  auto run = at == opened_.end() ? nullptr : at->second.lock();
  if (run && run->run_id() != runs::address_of(*folder).run_id) run = nullptr;  // another run took its place
  if (run) last_ = run;
  return run;
}

void RunSet::keep(const std::shared_ptr<WatchedRun>& run) {
  opened_[run->folder()] = run;
  last_ = run;
}

std::vector<std::shared_ptr<WatchedRun>> RunSet::opened() {
  std::vector<std::shared_ptr<WatchedRun>> runs;
  for (auto at = opened_.begin(); at != opened_.end();)
    if (auto run = at->second.lock()) {
      runs.push_back(std::move(run));
      ++at;
    } else {
      at = opened_.erase(at);
    }
  return runs;
}

std::function<void()> RunSet::error_to_read() {
  const std::lock_guard lock(digests_->mutex);
  if (!listed_ || digests_->reading) return nullptr;
  for (const fs::path& folder : folders()) {
    if (digests_->of.contains(folder) || runs::printing_process(folder)) continue;
    digests_->reading = true;
    return [digests = digests_, folder] {
      runs::RunDigest digest = runs::digest_run(folder);
      const std::lock_guard done(digests->mutex);
      digests->reading = false;
      digests->of.insert_or_assign(folder, std::move(digest));
    };
  }
  return nullptr;
}

runs::RunDigest RunSet::Digests::get(const fs::path& folder) {
  {
    const std::lock_guard lock(mutex);
    if (const auto at = of.find(folder); at != of.end()) return at->second;
  }
  runs::RunDigest digest = runs::digest_run(folder);
  const std::lock_guard lock(mutex);
  if (!runs::printing_process(folder)) of.insert_or_assign(folder, digest);
  return digest;
}

std::function<runs::LampSum()> RunSet::lamp_before(const fs::path& run) const {
  return [digests = digests_, all = folders(), run] {
    runs::LampSum sum;
    sum.lamp = runs::lamp_of(run);
    const std::pair begun(started(run), run);
    if (sum.lamp.empty() || begun.first.empty()) return sum;
    for (const fs::path& folder : all) {
      const std::pair other(started(folder), folder);
      if (other.first.empty() || other >= begun) continue;
      const runs::RunDigest digest = digests->get(folder);
      if (digest.lamp != sum.lamp) continue;
      sum.open_s += digest.lamp_open_s;
      ++sum.runs;
    }
    return sum;
  };
}

std::function<std::string()> RunSet::list(const std::string& where) {
  listed_ = true;
  Errors of_opened;
  for (const auto& run : opened())
    if (const auto last = run->last_error_um())
      of_opened[run->folder()] = {last->first, last->second, run->newest_layer().value_or(0)};
  std::vector<fs::path> places = places_;
  if (!live_.empty() && std::ranges::find(places, live_.parent_path()) == places.end())
    places.push_back(live_);
  return [places, where, index = index_, digests = digests_, of_opened = std::move(of_opened)] {
    return list_json(places, *index, where, *digests, of_opened);
  };
}

std::string RunSet::list_json(std::vector<fs::path> places, Index& index, const std::string& where,
                              Digests& digests, const Errors& of_opened) {
  const runs::Query query = runs::parse_query(where);
  std::erase_if(places, [](const fs::path& place) { return !fs::is_directory(place); });  // it was moved away
  std::vector<runs::FoundRun> found;
  {
    const std::lock_guard lock(index.mutex);
    index.of.refresh(places);
    found = index.of.find(query, where, places, {"started", true, 0});
  }
  Errors known_errors = of_opened;
  {
    const std::lock_guard lock(digests.mutex);
    for (const auto& [folder, digest] : digests.of)
      if (digest.last) known_errors[folder] = *digest.last;
  }
  std::map<fs::path, int> named;
  for (const runs::FoundRun& r : found) ++named[r.folder.filename()];
  Json runs = Json::array();
  for (const runs::FoundRun& r : found) {
    const bool others = named[r.folder.filename()] > 1;
    runs.push_back(
        list_row(r.folder, label(r.folder, others), Json::parse(r.listing), of_opened, known_errors));
  }
  return Json{{"runs", runs}}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace firn::page
