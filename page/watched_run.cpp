#include "page/watched_run.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "config/changes.h"
#include "config/devices.h"
#include "config/fields.h"
#include "config/labs.h"
#include "core/options/for_people.h"
#include "core/options/number.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"
#include "page/alarms.h"
#include "page/event_words.h"
#include "page/view_json.h"
#include "page/web_rules.h"
#include "runs/folder/address.h"
#include "runs/folder/config_change.h"
#include "runs/folder/documents.h"
#include "runs/folder/one_run.h"
#include "runs/folder/running.h"
#include "runs/folder/verdict.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;

constexpr double kLookS = 0.5;  // for the end of a print

// A whole number of TOML, 300.0, as people write it.
std::string for_a_panel(std::string text) {
  constexpr std::string_view kNoDecimals = ".0";
  if (text.ends_with(kNoDecimals) && whole_number<double>(text))
    text.resize(text.size() - kNoDecimals.size());
  return text;
}

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
      f.details[std::string(field.section())].emplace_back(field.name(), for_a_panel(value_text(field)),
                                                           field.unit);
  std::map<std::string, std::string> settings;
  for (const Field& field : fields(e)) {
    if (!belongs(field, e)) continue;
    settings[field.key] = value_text(field) + (field.unit.empty() ? "" : " " + std::string(field.unit));
    f.platen = f.platen || field.key == "heater.platen_degC";
  }
  for (const InterlockWords& row : interlocks())
    for (const std::string_view key : list_words(row.limits))
      if (const auto at = settings.find(std::string(key)); at != settings.end())
        f.limits[row.code] += (f.limits[row.code].empty() ? "" : ", ") + at->first + " " + at->second;
  return f;
}

std::string text_or_empty(const fs::path& file) { return fs::exists(file) ? read_file(file) : ""; }

}  // namespace

WatchedRun::WatchedRun(const Product& product, fs::path folder, double now_s)
    : product_(product), folder_(std::move(folder)) {
  const RunPaths paths(folder_);
  const fs::path file = paths.provenance_path();
  const runs::ProvenanceDocument provenance = runs::parse_provenance(read_file(file), file.string());
  runs::require_one_run(folder_);
  meta_ = runs::run_meta(provenance);
  run_id_ = provenance.run_id.value_or(0);
  for (const auto& [key, value] : provenance.texts) texts_[key] = value;
  for (const auto& [role, sha] : provenance.inputs) inputs_[role] = paths.input_path(sha);
  live_ = runs::printing_process(folder_).has_value();
  open_reader();
  try {
    std::string recorded = reader_->config();
    if (recorded.empty()) recorded = runs::recorded_config(folder_);
    experiment_ = parse_recorded_experiment(recorded.empty() ? read_file(paths.experiment_path()) : recorded,
                                            paths.experiment_path().string());
  } catch (const std::exception& e) {
    trouble_ = e.what();
  }
  make_view();
  poll(now_s);
  view_->take_new();
}

// Of a run that is over from its log, which has the rows of scans too: they are shown while they are made
// alone.
void WatchedRun::open_reader() {
  auto channels = RunView::channels();
  channels.merge(RunMaps::channels());
  if (!live_) {
    auto of_log = channels;
    of_log.erase(std::string(channels::kHeightProfile.name));
    reader_.emplace(folder_, std::move(of_log), runs::RunReader::Source::kLog);
    if (reader_->reads_log()) return;
  }
  reader_.emplace(folder_, std::move(channels));
}

void WatchedRun::make_view() {
  maps_.emplace(folder_, experiment_, inputs_,
                [this](const runs::Place& place) { return reader_->read(place); });
  view_.emplace(facts_of(experiment_));
}

void WatchedRun::take_values() {
  for (const auto& [layer, um] : maps_->take_predictions()) view_->predicted(layer, um);
  for (const auto& [layer, stats] : maps_->take_outlines()) view_->outline(layer, stats);
}

void WatchedRun::look_for_the_end(double now_s) {
  if (now_s < looked_s_ + kLookS) return;
  looked_s_ = now_s;
  live_ = runs::printing_process(folder_).has_value();
  try {
    const std::string text = text_or_empty(RunPaths(folder_).result_path());
    const runs::RunResult r = runs::parse_result(text, RunPaths::kResult);
    view_->over(r.outcome, for_people(r.reason));
    const LabWords& words = lab_of(experiment_).words;
    view_->judged(verdict_words(r, words), within_tolerance(r), result_lines(r, words));
  } catch (const std::exception&) {
    if (!live_ && !view_->end()) view_->over("interrupted", "nobody prints this run now");
  }
}

WatchedRun::News WatchedRun::poll(double now_s) {
  if (reader_->reads_log() && live_) {  // it was resumed
    open_reader();
    make_view();
  }
  const auto before = maps_->newest_layer();
  const bool recorded = reader_->reads_log();
  const bool grown =
      reader_->poll([&](std::string_view channel, std::span<const std::byte> message, runs::Place place) {
        maps_->take(channel, message, place);
        view_->take(channel, message, recorded ? 0.0 : now_s);
      });
  if (grown) {
    if (!recorded) view_->alive(now_s);
    take_values();
    for (const runs::Exchange& e : reader_->take_exchanges()) view_->exchanged(e.node, e.words());
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
  look_at_notes(news);
  return news;
}

// Alarms are acknowledged by pages of other processes, too.
void WatchedRun::look_at_notes(News& news) {
  std::error_code none;
  const std::uintmax_t bytes = fs::file_size(RunPaths(folder_).notes_path(), none);
  if (none || std::exchange(notes_bytes_, bytes) == bytes) return;
  news.frames.push_back(acknowledged_frame(runs::read_notes(folder_)));
}

bool WatchedRun::has_alarm(const std::string& text) const {
  return std::ranges::any_of(view_->events(),
                             [&](const EventRow& e) { return is_alarm(e) && alarm_text(e) == text; });
}

std::optional<std::pair<double, double>> WatchedRun::last_error_um() const {
  if (view_->layers().empty()) return std::nullopt;
  const LayerRow& last = view_->layers().rbegin()->second;
  return std::pair(last.rms_um, last.mean_um);
}

std::string WatchedRun::state(double now_s) const { return state_frame(view_->state(now_s)); }

std::string WatchedRun::hello(double now_s, const std::string& label, bool may_resume,
                              const Reader& reader) const {
  HelloFacts f;
  f.id = runs::RunAddress{run_id_, runs::place_of(folder_)}.text();
  f.label = label;
  f.product = &product_;
  f.texts = &texts_;
  f.experiment = &experiment_;
  f.trouble = trouble_;
  f.grid = maps_->grid();
  f.live = live_;
  f.may_resume = may_resume;
  f.notes = runs::read_notes(folder_);
  f.meta = meta_;
  f.reader = reader;
  return hello_frame(f, *view_, now_s);
}

}  // namespace firn::page
