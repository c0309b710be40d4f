#include "page/watched_run.h"

#include <utility>

#include "config/changes.h"
#include "config/devices.h"
#include "config/fields.h"
#include "files/run_documents.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"
#include "page/event_words.h"
#include "page/view_json.h"
#include "page/web_rules.h"
#include "print/folder/run_config.h"
#include "print/folder/running.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;

constexpr double kLookS = 0.5;  // for the end of a print

ViewFacts facts_of(Experiment& e) {
  ViewFacts f;
  f.time_scale = e.run.time_scale;
  for (const std::string& node : simulated_ports(e)) f.ports[node] = "simulated";
  const auto real = real_ports(e);
  for (const auto& [node, address] : outside_ports(e)) {
    f.ports[node] = port_text(e.devices, node);
    if (real.contains(node)) f.real.insert(node);
  }
  for (const Field& field : fields(e))
    if (f.ports.contains(std::string(field.section())) && belongs(field, e))
      f.details[std::string(field.section())].emplace_back(field.name(), value_text(field), field.unit);
  std::map<std::string, std::string> settings;
  for (const Field& field : fields(e)) {
    if (!belongs(field, e)) continue;
    settings[field.key] = value_text(field) + (field.unit.empty() ? "" : " " + std::string(field.unit));
    if (const auto* number = std::get_if<double*>(&field.value)) f.numbers[field.key] = **number;
  }
  for (const InterlockWords& row : interlocks())
    for (const std::string_view key : list_words(row.limits))
      if (const auto at = settings.find(std::string(key)); at != settings.end())
        f.limits[row.code] += (f.limits[row.code].empty() ? "" : ", ") + at->first + " " + at->second;
  return f;
}

std::string text_or_empty(const fs::path& file) { return fs::exists(file) ? read_file(file) : ""; }

}  // namespace

WatchedRun::WatchedRun(fs::path folder, double now_s) : folder_(std::move(folder)) {
  const fs::path file = folder_ / "provenance.json";
  const ProvenanceDocument provenance = parse_provenance(read_file(file), file.string());
  for (const auto& [key, value] : provenance.texts) texts_[key] = value;
  for (const auto& [role, sha] : provenance.inputs) inputs_[role] = folder_ / "inputs" / sha;
  if (!printing_process(folder_)) open_log();
  try {
    std::string recorded = log_ ? log_->config() : "";
    if (recorded.empty()) recorded = recorded_config(folder_);
    experiment_ =
        parse_recorded_experiment(recorded.empty() ? read_file(folder_ / "experiment.toml") : recorded,
                                  (folder_ / "experiment.toml").string());
  } catch (const std::exception& e) {
    trouble_ = e.what();
  }
  if (log_)
    read_log();
  else
    follow_files();
  poll(now_s);
  view_->take_new();
}

void WatchedRun::make_view(RunMaps::Reader reader) {
  maps_.emplace(folder_, experiment_, inputs_, std::move(reader));
  view_.emplace(facts_of(experiment_));
}

// Rows of a scan are shown while it is made alone.
void WatchedRun::open_log() {
  auto channels = RunView::channels();
  channels.merge(RunMaps::channels());
  channels.erase(std::string(channels::kHeightProfile.name));
  log_ = RecordedLog::open(folder_, channels);
}

void WatchedRun::read_log() {
  make_view([this](const Place& place) { return log_->read(place); });
  log_->each([&](std::string_view channel, std::span<const std::byte> message, Place place) {
    maps_->take(channel, message, place);
    view_->take(channel, message, 0.0);
  });
  take_values();
}

void WatchedRun::follow_files() {
  auto channels = RunView::channels();
  channels.merge(RunMaps::channels());
  tail_.emplace(folder_, std::move(channels));
  make_view([this](const Place& place) { return tail_->read(place); });
}

void WatchedRun::take_values() {
  for (const auto& [layer, um] : maps_->take_predictions()) view_->predicted(layer, um);
  for (const auto& [layer, percent] : maps_->take_overspill()) view_->overspill(layer, percent);
}

void WatchedRun::look_for_the_end(double now_s) {
  if (now_s < looked_s_ + kLookS) return;
  looked_s_ = now_s;
  live_ = printing_process(folder_).has_value();
  if (live_ || view_->end()) return;
  try {
    const std::string text = text_or_empty(folder_ / "result.json");
    const ResultDocument r = parse_result(text, "result.json");
    view_->over(r.outcome, r.reason);
  } catch (const std::invalid_argument&) {
    view_->over("interrupted", "nobody prints this run now");
  }
}

WatchedRun::News WatchedRun::poll(double now_s) {
  if (log_ && live_) {  // it was resumed
    log_.reset();
    follow_files();
  }
  const auto before = maps_->newest_layer();
  const bool grown =
      tail_ && tail_->poll([&](std::string_view channel, std::span<const std::byte> message, Place place) {
        maps_->take(channel, message, place);
        view_->take(channel, message, now_s);
      });
  if (grown) {
    view_->alive(now_s);
    take_values();
    for (const Exchange& e : tail_->take_exchanges()) view_->exchanged(e.node, e.words());
  }
  look_for_the_end(now_s);
  News news;
  news.map = grown && maps_->newest_layer() != before;
  NewRows rows = view_->take_new();
  for (const auto& [key, value] : rows.settings) {
    Changes changes(experiment_);
    if (changes.set(key, value).empty()) experiment_ = changes.experiment();
  }
  if (rows.state) news.frames.push_back(state(now_s));
  add_frames(rows, view_->end(), news.frames);
  return news;
}

std::optional<std::pair<double, double>> WatchedRun::last_error_um() const {
  if (view_->layers().empty()) return std::nullopt;
  const LayerRow& last = view_->layers().rbegin()->second;
  return std::pair(last.rms_um, last.mean_um);
}

std::string WatchedRun::state(double now_s) const { return state_frame(view_->state(now_s)); }

std::string WatchedRun::hello(double now_s) const {
  HelloFacts f;
  f.id = folder_.filename().string();
  f.texts = &texts_;
  f.experiment = &experiment_;
  f.trouble = trouble_;
  f.grid = maps_->grid();
  f.live = live_;
  f.notes = read_notes(folder_);
  return hello_frame(f, *view_, now_s);
}

Notes read_notes(const fs::path& run) try {
  return parse_notes(text_or_empty(run / "notes.json"), nullptr);
} catch (const std::exception&) {
  return {};
}

void write_notes(const fs::path& run, const Notes& notes) {
  write_file_atomically(run / "notes.json", to_json(notes));
}

}  // namespace firn::page
