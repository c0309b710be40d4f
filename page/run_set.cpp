#include "page/run_set.h"

#include <algorithm>
#include <set>
#include <utility>

#include "config/labs.h"
#include "files/json.h"
#include "files/run_documents.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/folder/running.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string started(const fs::path& run) try {
  return parse_provenance(read_file(run / "provenance.json"), "provenance.json").text("started_utc");
} catch (const std::exception&) {
  return "";
}

/// The kind of lab of an experiment's text, which may be older than its keys are.
std::string lab_name(const std::string& experiment) {
  for (const LabKind* lab : lab_kinds())
    if (experiment.find("kind = \"" + std::string(lab->name) + "\"") != std::string::npos)
      return std::string(lab->name);
  return std::string(lab_kinds().front()->name);
}

bool is_run(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "provenance.json", ignored) && fs::is_directory(folder / "nodes", ignored);
}

}  // namespace

RunSet::RunSet(std::vector<fs::path> places, fs::path live) : live_(std::move(live)) {
  for (const fs::path& place : places) {
    if (!fs::is_directory(place)) throw UsageError(place.string() + ": no such folder");
    places_.push_back(fs::canonical(place));
  }
  if (!live_.empty()) live_ = fs::canonical(live_);
}

std::vector<fs::path> RunSet::folders() const {
  std::set<fs::path> all;
  if (!live_.empty()) all.insert(live_);
  for (const fs::path& place : places_) {
    if (is_run(place)) {
      all.insert(place);
      continue;
    }
    std::error_code gone;
    for (const auto& entry : fs::directory_iterator(place, gone))
      if (is_run(entry.path())) all.insert(entry.path());
  }
  return {all.begin(), all.end()};
}

std::optional<fs::path> RunSet::find(const std::string& id) const {
  if (id == "live" && !live_.empty()) return live_;
  for (const fs::path& folder : folders())
    if (folder.filename() == id) return folder;
  return std::nullopt;
}

std::shared_ptr<WatchedRun> RunSet::opened(const std::string& id) {
  const auto folder = find(id);
  const auto at = folder ? opened_.find(*folder) : opened_.end();
  auto run = at == opened_.end() ? nullptr : at->second.lock();
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
    if (digests_->of.contains(folder) || printing_process(folder)) continue;
    digests_->reading = true;
    return [digests = digests_, folder] {
      RunDigest digest = digest_run(folder);
      const std::lock_guard done(digests->mutex);
      digests->reading = false;
      digests->of.insert_or_assign(folder, std::move(digest));
    };
  }
  return nullptr;
}

RunDigest RunSet::Digests::get(const fs::path& folder) {
  {
    const std::lock_guard lock(mutex);
    if (const auto at = of.find(folder); at != of.end()) return at->second;
  }
  RunDigest digest = digest_run(folder);
  const std::lock_guard lock(mutex);
  if (!printing_process(folder)) of.insert_or_assign(folder, digest);
  return digest;
}

std::function<LampSum()> RunSet::lamp_before(const fs::path& run) const {
  return [digests = digests_, all = folders(), run] {
    LampSum sum;
    sum.lamp = lamp_of(run);
    const std::pair begun(started(run), run);
    if (sum.lamp.empty() || begun.first.empty()) return sum;
    for (const fs::path& folder : all) {
      const std::pair other(started(folder), folder);
      if (other.first.empty() || other >= begun) continue;
      const RunDigest digest = digests->get(folder);
      if (digest.lamp != sum.lamp) continue;
      sum.open_s += digest.lamp_open_s;
      ++sum.runs;
    }
    return sum;
  };
}

std::string RunSet::list_json() {
  listed_ = true;
  const std::lock_guard lock(digests_->mutex);
  Json runs = Json::array();
  for (const fs::path& folder : folders()) {
    Json r{{"id", folder.filename().string()}};
    const auto pid = printing_process(folder);
    RunDigest::Error error;
    bool known = false;
    if (const auto at = digests_->of.find(folder); at != digests_->of.end() && at->second.last && !pid) {
      error = *at->second.last;
      known = true;
    } else if (const auto o = opened_.find(folder); o != opened_.end()) {
      const auto run = o->second.lock();
      if (const auto last = run ? run->last_error_um() : std::nullopt) {
        error = {last->first, last->second, run->newest_layer().value_or(0)};
        known = true;
      }
    }
    try {
      const ProvenanceDocument p = parse_provenance(read_file(folder / "provenance.json"), "provenance.json");
      const std::string config =
          fs::exists(folder / "experiment.toml") ? read_file(folder / "experiment.toml") : "";
      r["lab"] = lab_name(config);
      r["experiment"] = p.text("name");
      r["scheme"] = p.text("scheme");
      const Json seeds = Json::parse(p.text("seeds"), nullptr, false);
      r["seed"] = seeds.is_object() ? seeds.value("plant", Json(nullptr)) : Json(nullptr);
      r["started_utc"] = p.text("started_utc");
      r["outcome"] = pid ? "printing" : "interrupted";
      r["layers"] = error.layers;
      if (!pid && fs::exists(folder / "result.json")) {
        const ResultDocument result = parse_result(read_file(folder / "result.json"), "result.json");
        r["outcome"] = result.outcome;
        r["layers"] = result.layers;
      }
    } catch (const std::exception& e) {
      r["outcome"] = "unreadable";
      r["note"] = e.what();
    }
    r["rms_um"] = known ? Json(error.rms_um) : Json(nullptr);
    r["mean_um"] = known ? Json(error.mean_um) : Json(nullptr);
    const Notes notes = read_notes(folder);
    r["tags"] = notes.tags;
    r["note"] = notes.note;
    r["live"] = pid.has_value();
    runs.push_back(std::move(r));
  }
  std::stable_sort(runs.begin(), runs.end(), [](const Json& a, const Json& b) {
    return a.value("started_utc", "") > b.value("started_utc", "");
  });
  return Json{{"runs", runs}}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace firn::page
