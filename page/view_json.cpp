#include "page/view_json.h"

#include <cmath>
#include <sstream>

#include "config/changes.h"
#include "config/devices.h"
#include "config/fields.h"
#include "config/labs.h"
#include "core/options/enumerators.h"
#include "files/json.h"
#include "page/alarms.h"
#include "print/labs/product.h"
#include "runtime/build_info.h"

namespace firn::page {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kShownPercent = 100.0, kShownUm = 1e3;  // per mm

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }
Json text(const std::string& value) { return value.empty() ? Json(nullptr) : Json(value); }

std::string dumped(const Json& j) { return j.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json as_json(const LayerRow& r) {
  return {{"n", r.n},
          {"t_s", number(r.t_s)},
          {"rms_um", number(r.rms_um)},
          {"mean_um", number(r.mean_um)},
          {"max_um", number(r.max_um)},
          {"overspill_percent", number(r.outline.overspill * kShownPercent)},
          {"missing_percent", number(r.outline.missing * kShownPercent)},
          {"first_ring_um", number(r.outline.first_ring_mm * kShownUm)},
          {"edge_width_um", number(r.outline.edge_width_mm * kShownUm)},
          {"size_x_um", number(r.outline.size_error_x_mm * kShownUm)},
          {"size_y_um", number(r.outline.size_error_y_mm * kShownUm)},
          {"size_cut", r.outline.cut},
          {"droplets", r.droplets > 0 ? Json(r.droplets) : Json(nullptr)},
          {"predicted_rms_um", number(r.predicted_rms_um)},
          {"measured_rms_um", number(r.rms_um)},
          {"decision_ms", r.decide_ms > 0.0 ? number(r.decide_ms) : Json(nullptr)}};
}

Json as_json(const EventRow& e) {
  return {{"n", e.n},
          {"t_s", number(e.t_s)},
          {"severity", kWeightWords[std::size_t(e.weight)]},
          {"source", e.source},
          {"words", e.words},
          {"cause", text(e.cause)},
          {"value", number(e.value)},
          {"limit", number(e.limit)},
          {"unit", text(e.unit)},
          {"do", text(e.remedy)},
          {"manual", text(e.manual)},
          {"alarm", is_alarm(e) ? Json(alarm_text(e)) : Json(nullptr)}};
}

Json as_json(const InstrumentRow& i) {
  Json details = Json::array();
  for (const auto& [label, value, unit] : i.details) details.push_back({label, value, unit});
  return {{"name", i.name},
          {"kind", i.kind},
          {"state", i.state},
          {"words", i.words},
          {"real", i.real},
          {"link", i.link},
          {"last",
           i.last_text.empty() ? Json(nullptr) : Json{{"t_s", number(i.last_t_s)}, {"text", i.last_text}}},
          {"faults", i.faults},
          {"details", details}};
}

Json as_json(const EstimateRow& e) {
  return {{"t_s", number(e.t_s)},
          {"name", e.name},
          {"value", number(e.value)},
          {"sd", number(e.sd)},
          {"unit", e.unit}};
}

Json as_json(const StateRow& s) {
  Json j{{"t_s", number(s.t_s)},
         {"state", kPhaseWords[std::size_t(s.phase)]},
         {"words", s.words},
         {"layer", s.layer},
         {"layers", s.layers > 0 ? Json(s.layers) : Json(nullptr)},
         {"eta_s", number(s.eta_s)},
         {"ages",
          {{"link_s", number(s.link_s)},
           {"surface_s", number(s.surface_s)},
           {"instruments_s", number(s.instruments_s)},
           {"controller_s", number(s.controller_s)}}},
         {"paused", s.paused},
         {"stopping", s.stopping},
         {"doubt", nullptr}};
  if (s.doubt)
    j["doubt"] = {{"words", s.doubt->words}, {"question", s.doubt->question}, {"choices", {"accept"}}};
  if (!s.temperatures.empty()) {
    Json& t = j["temperatures"] = Json::object();
    for (const auto& [place, degC, set] : s.temperatures)
      t[place] = {
          {"value", number(degC)}, {"set", set > -50.0 ? number(set) : Json(nullptr)}, {"unit", "degC"}};
  }
  if (s.flow)
    j["flow"] = {{"value", number(s.flow->value)},
                 {"low", number(s.flow->value - 1.96 * s.flow->sd)},
                 {"high", number(s.flow->value + 1.96 * s.flow->sd)},
                 {"unit", s.flow->unit}};
  if (!s.interval.empty()) j["interval"] = {{"words", s.interval}};
  return j;
}

Json lines_of(const std::string& text) {
  Json lines = Json::array();
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Json as_json(const EndRow& e) {
  return {{"outcome", e.outcome},
          {"words", e.words},
          {"cause", text(e.cause)},
          {"do", text(e.remedy)},
          {"manual", text(e.manual)},
          {"by_operator", e.by_operator},
          {"can_go_on", !e.whole},
          {"verdict", text(e.verdict)},
          {"within", e.within ? Json(*e.within) : Json(nullptr)},
          {"facts", lines_of(e.facts)}};
}

std::string frame(const char* type, const Json& body) {
  Json j{{"type", type}};
  j.update(body);
  return dumped(j);
}

template <class Rows>
Json array_of(const Rows& rows) {
  Json all = Json::array();
  for (const auto& r : rows) all.push_back(as_json(r));
  return all;
}

template <class Rows>
Json values_of(const Rows& rows) {
  Json all = Json::array();
  for (const auto& [key, r] : rows) all.push_back(as_json(r));
  return all;
}

Json settings_of(const Experiment& experiment) {
  Experiment now = experiment, usual;
  usual.lab = experiment.lab;
  usual.control.scheme = experiment.control.scheme;
  std::map<std::string, std::string> defaults;
  for (const Field& f : fields(usual)) defaults[f.key] = value_text(f);
  Json all = Json::array();
  for (const Field& f : fields(now))
    if (belongs(f, now))
      all.push_back({{"key", f.key},
                     {"value", value_text(f)},
                     {"unit", std::string(f.unit)},
                     {"default", defaults[f.key]}});
  return all;
}

Json in_flight_of(const Experiment& experiment) {
  Experiment now = experiment;
  Json all = Json::array();
  for (const Field& f : fields(now)) {
    if (!f.between_layers || !belongs(f, now) || !unread_by_scheme(now, f.key).empty()) continue;
    all.push_back({{"key", f.key},
                   {"value", value_text(f)},
                   {"min", number(f.limits.min)},
                   {"max", number(f.limits.max)},
                   {"unit", std::string(f.unit)},
                   {"words", std::string(f.meaning)},
                   {"choices", f.limits.choices}});
  }
  return all;
}

constexpr const char* kDepositions[] = {"droplets", "paths", "lines"};
static_assert(std::size(kDepositions) == kTableSize<Deposition>);

/// The table's words without the source.
std::string lab_words(const Experiment& e) {
  const std::string_view words = lab_of(e).meaning;
  return std::string(words.substr(0, words.find(" [")));
}

Json goal_of(const Product& product, const Experiment& e) {
  constexpr double kMmPerUm = 1e-3;
  const double um = print_lab(product, e).tolerance_um(e);
  const bool in_mm = lab_of(e).words.in_mm;
  return {{"kind", "rms"},
          {"value", um > 0.0 ? Json(in_mm ? um * kMmPerUm : um) : Json(nullptr)},
          {"unit", in_mm ? "mm" : "um"}};
}

Json grid_of(const std::optional<GridSpec>& g) {
  if (!g) return nullptr;
  return {{"nx", g->nx},
          {"ny", g->ny},
          {"pitch_mm", g->pitch_x_mm},
          {"pitch_y_mm", g->pitch_y_mm},
          {"x0_mm", g->origin_x_mm},
          {"y0_mm", g->origin_y_mm}};
}

Json acknowledged_json(const runs::RunNotes& notes) {
  Json all = Json::array();
  for (const runs::NoteEntry& n : notes.acknowledged())
    all.push_back({{"alarm", n.text}, {"author", n.author}, {"time_utc", n.time_utc}});
  return all;
}

}  // namespace

nlohmann::ordered_json about_json(const runs::RunMeta& meta, const runs::RunNotes& notes) {
  Json j{{"host", meta.host.empty() ? Json(nullptr) : Json(meta.host)},
         {"meta", Json::object()},
         {"tags", notes.tags()},
         {"notes", Json::array()}};
  for (const MetaEntry& e : meta.values)
    std::visit([&](const auto& value) { j["meta"][e.key] = value; }, e.value);
  for (const runs::NoteEntry& n : notes.notes())
    j["notes"].push_back(
        {{"time_utc", n.time_utc}, {"author", n.author}, {"host", n.host}, {"text", n.text}});
  j["acknowledged"] = acknowledged_json(notes);
  return j;
}

std::string hello_frame(const HelloFacts& f, const RunView& view, double now_s) {
  const Experiment& e = *f.experiment;
  const auto known = [&](const char* key) {
    const auto at = f.texts->find(key);
    return at == f.texts->end() ? std::string() : at->second;
  };
  Json run{{"id", f.id},
           {"label", f.label},
           {"lab", e.lab.kind},
           {"lab_words", lab_words(e)},
           {"deposition", kDepositions[std::size_t(lab_of(e).deposition)]},
           {"amount", std::string(lab_of(e).words.amount)},
           {"height_unit", lab_of(e).words.in_mm ? "mm" : "um"},
           {"experiment", known("name")},
           {"scheme", known("scheme")},
           {"seed", e.plant.seed},
           {"started_utc", known("started_utc")},
           {"commit", known("commit")},
           {"live", f.live},
           {"finished", view.end().has_value()},
           {"outcome", view.end() ? Json(view.end()->outcome) : Json(nullptr)},
           {"simulated", real_ports(e).empty()},
           {"grid", grid_of(f.grid)},
           {"layers_planned", view.layers_expected() > 0 ? Json(view.layers_expected()) : Json(nullptr)},
           {"goal", goal_of(*f.product, e)},
           {"settings", settings_of(e)}};
  run.update(about_json(f.meta, f.notes));
  if (!f.trouble.empty()) run["trouble"] = f.trouble;
  const Json allowed = f.live && (f.reader.commands || f.reader.needs_token)
                           ? Json{"pause", "continue", "stop_after_layer", "safe_stop", "accept_doubt", "set"}
                           : Json::array();
  return dumped({{"type", "hello"},
                 {"protocol", kProtocol},
                 {"firn", build_commit()},
                 {"you",
                  {{"name", text(f.reader.name)},
                   {"commands", f.reader.commands},
                   {"needs_token", f.reader.needs_token}}},
                 {"run", run},
                 {"commands",
                  {{"allowed", allowed},
                   {"resume", f.may_resume && (f.reader.commands || f.reader.needs_token)},
                   {"in_flight", f.live ? in_flight_of(e) : Json::array()}}},
                 {"layers", values_of(view.layers())},
                 {"events", array_of(view.events())},
                 {"instruments", values_of(view.instruments())},
                 {"estimates", array_of(view.estimates())},
                 {"state", as_json(view.state(now_s))},
                 {"end", view.end() ? as_json(*view.end()) : Json(nullptr)}});
}

std::string state_frame(const StateRow& state) { return frame("state", as_json(state)); }

std::string acknowledged_frame(const runs::RunNotes& notes) {
  return frame("acknowledged", {{"alarms", acknowledged_json(notes)}});
}

void add_frames(const NewRows& rows, const std::optional<EndRow>& end, std::vector<std::string>& frames) {
  for (const LayerRow& r : rows.layers) frames.push_back(frame("layer", as_json(r)));
  for (const EventRow& e : rows.events) frames.push_back(frame("event", as_json(e)));
  for (const InstrumentRow& i : rows.instruments) frames.push_back(frame("instrument", as_json(i)));
  for (const EstimateRow& e : rows.estimates) frames.push_back(frame("estimate", as_json(e)));
  for (const auto& [key, value] : rows.settings)
    frames.push_back(frame("setting", {{"key", key}, {"value", value}}));
  if (rows.ended && end) frames.push_back(frame("end", as_json(*end)));
}

std::string answer_frame(std::optional<std::int64_t> id, bool ok, const std::string& error,
                         const std::string& words) {
  return frame(
      "answer",
      {{"id", id ? Json(*id) : Json(nullptr)}, {"ok", ok}, {"error", text(error)}, {"words", text(words)}});
}

std::string exchanges_json(const std::vector<runs::Exchange>& exchanges) {
  Json all = Json::array();
  for (const runs::Exchange& e : exchanges) all.push_back({{"name", e.node}, {"text", e.words()}});
  return dumped({{"exchanges", all}});
}

std::string lamp_json(const runs::LampSum& sum) {
  return dumped({{"lamp", sum.lamp}, {"earlier_h", sum.open_s / 3600.0}, {"earlier_runs", sum.runs}});
}

std::string error_frame(const std::string& error) { return frame("error", {{"error", error}}); }

std::string pong_frame(std::int64_t id, double t_s) { return frame("pong", {{"id", id}, {"t_s", t_s}}); }

}  // namespace firn::page
