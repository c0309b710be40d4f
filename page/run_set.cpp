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
#include "page/view_json.h"
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

void add_result(const runs::RunResult& result, Json& r) {
  const auto known = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
  const auto text = [](const std::string& words) { return words.empty() ? Json(nullptr) : Json(words); };
  r["part"] = result.part ? Json(part_words(*result.part)) : Json(nullptr);
  r["overspill_percent"] = known(result.overspill_percent);
  r["audit"] = text(result.audit);
  const std::string verdict = verdict_words(result, lab_words(r.value("lab", "")));
  r["verdict"] =
      text(verdict.empty() ? for_people(result.reason) : verdict);  // why it stopped, as firn runs has it
  r["within"] = known(within_tolerance(result));
}

std::string started(const fs::path& run) try {
  return provenance_of(run).text("started_utc");
} catch (const std::exception&) {
  return "";
}

}  // namespace

RunSet::RunSet(std::vector<fs::path> places, fs::path live) : live_(std::move(live)) {
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

std::function<std::string()> RunSet::list() {
  listed_ = true;
  Errors of_opened;
  for (const auto& run : opened())
    if (const auto last = run->last_error_um())
      of_opened[run->folder()] = {last->first, last->second, run->newest_layer().value_or(0)};
  return [places = places_, live = live_, digests = digests_, of_opened = std::move(of_opened)] {
    return list_json(folders(places, live), *digests, of_opened);
  };
}

std::string RunSet::list_json(const std::vector<fs::path>& all, Digests& digests, const Errors& of_opened) {
  Errors known_errors = of_opened;
  {
    const std::lock_guard lock(digests.mutex);
    for (const auto& [folder, digest] : digests.of)
      if (digest.last) known_errors[folder] = *digest.last;
  }
  std::map<fs::path, int> named;
  for (const fs::path& folder : all) ++named[folder.filename()];
  Json runs = Json::array();
  for (const fs::path& folder : all) {
    Json r{{"id", runs::address_of(folder).text()}, {"label", label(folder, named[folder.filename()] > 1)}};
    const auto pid = runs::printing_process(folder);
    std::optional<runs::RunDigest::Error> error;
    runs::RunMeta meta;
    // Of a run that goes on the digest of before is old.
    const Errors& errors = pid ? of_opened : known_errors;
    if (const auto found = errors.find(folder); found != errors.end()) error = found->second;
    try {
      const runs::ProvenanceDocument p = provenance_of(folder);
      meta = runs::run_meta(p);
      const std::string lab = lab_kind_in(read_file(RunPaths(folder).experiment_path()));
      r["lab"] = lab;
      r["height_unit"] = lab_words(lab).in_mm ? "mm" : "um";
      r["experiment"] = p.text("name");
      r["scheme"] = p.text("scheme");
      const Json seeds = Json::parse(p.text("seeds"), nullptr, false);
      r["seed"] = seeds.is_object() ? seeds.value("plant", Json(nullptr)) : Json(nullptr);
      r["started_utc"] = p.text("started_utc");
      r["outcome"] = pid ? "printing" : "interrupted";
      r["layers"] = error ? error->layers : 0;
      if (const fs::path file = RunPaths(folder).result_path(); !pid && fs::exists(file)) {
        const runs::RunResult result = runs::parse_result(read_file(file), RunPaths::kResult);
        r["outcome"] = result.outcome;
        r["layers"] = result.layers;
        if (result.error) error = {result.error->rms_um, result.error->mean_um, result.layers};
        add_result(result, r);
      }
      if (pid) r["state"] = OperatorClient::state_of(folder);
    } catch (const std::exception& e) {
      r["outcome"] = "unreadable";
      r["trouble"] = e.what();
    }
    r["rms_um"] = error ? Json(error->rms_um) : Json(nullptr);
    r["mean_um"] = error ? Json(error->mean_um) : Json(nullptr);
    r.update(about_json(meta, runs::read_notes(folder)));
    r["live"] = pid.has_value();
    runs.push_back(std::move(r));
  }
  std::stable_sort(runs.begin(), runs.end(), [](const Json& a, const Json& b) {
    return a.value("started_utc", "") > b.value("started_utc", "");
  });
  return Json{{"runs", runs}}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace firn::page
