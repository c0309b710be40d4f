#include "runs/find/run_facts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "config/fields.h"
#include "config/labs.h"
#include "core/grid/grid.h"
#include "core/grid/outline.h"
#include "core/options/for_people.h"
#include "core/options/number.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "runs/folder/verdict.h"

namespace firn::runs {
namespace {

using ListingJson = nlohmann::ordered_json;

constexpr std::pair<std::string_view, double MapError::*> kErrors[] = {
    {"rms_um", &MapError::rms_um},
    {"mean_um", &MapError::mean_um},
    {"std_um", &MapError::std_um},
    {"rms_inside_um", &MapError::rms_inside_um},
    {"rms_rim_um", &MapError::rms_rim_um}};

// "running (pid 12)" is no outcome to ask for.
std::string outcome_of(const RunEntry& e) { return e.running ? "running" : e.outcome; }

class Facts {
 public:
  explicit Facts(std::vector<Fact>& facts) : facts_(facts) {}

  void word(std::string key, const std::string& text) {
    if (!text.empty()) facts_.push_back({std::move(key), std::nullopt, text});
  }
  void number(std::string key, double value) {
    if (std::isfinite(value)) facts_.push_back({std::move(key), value, for_people(value)});
  }

 private:
  std::vector<Fact>& facts_;
};

void add_result(const RunResult& r, Facts& facts) {
  if (r.error)
    for (const auto& [key, member] : kErrors) facts.number(std::string(key), (*r.error).*member);
  if (r.tolerance_um) facts.number("tolerance_um", *r.tolerance_um);
  if (const auto within = within_tolerance(r)) facts.word("within", *within ? "true" : "false");
  if (r.part) {
    facts.word("part", r.part->name);
    facts.number("size_x_mm", r.part->size_mm[0]);
    facts.number("size_y_mm", r.part->size_mm[1]);
    facts.number("size_z_mm", r.part->size_mm[2]);
  }
  if (r.overspill_percent) facts.number("overspill_percent", *r.overspill_percent);
  if (r.outline)
    for (const OutlineMetric& m : kOutlineMetrics)
      if (m.value != &OutlineStats::overspill)
        facts.number(std::string(m.name), (*r.outline).*m.value * m.factor);
  facts.word("audit", r.audit);
}

// Settings that are not the program's defaults.
void add_settings(const std::string& toml, Facts& facts) {
  Experiment defaults, experiment = parse_recorded_experiment(toml, RunPaths::kExperiment);
  const std::vector<Field> usual = fields(defaults), own = fields(experiment);
  std::map<std::string_view, const Field*> by_key;
  for (const Field& f : usual) by_key[f.key] = &f;
  for (const Field& f : own) {
    if (f.key == "run.name" || !belongs(f, experiment)) continue;
    const auto known = by_key.find(f.key);
    const std::string text = value_text(f);
    if (known != by_key.end() && text == value_text(*known->second)) continue;
    if (const auto* word = std::get_if<std::string*>(&f.value))
      facts.word(f.key, **word);
    else if (const auto* number = std::get_if<double*>(&f.value))
      facts.number(f.key, **number);
    else if (const auto value = whole_number<double>(text))
      facts.number(f.key, *value);
    else
      facts.word(f.key, text.starts_with('"') ? text.substr(1, text.size() - 2) : text);
  }
}

// Everything that a word is looked for in.
std::string searched_text(const RunEntry& e, const std::string& toml) {
  std::string text =
      e.folder.filename().string() + "\n" + outcome_of(e) + "\n" + e.reason + "\n" + e.meta.host;
  for (const MetaEntry& m : e.meta.values) text += "\n" + meta_value_text(m.value);
  for (const std::string& tag : e.notes.tags()) text += "\n" + tag;
  for (const NoteEntry& note : e.notes.notes()) text += "\n" + note.text;
  std::set<std::string> values;
  std::istringstream in(toml);
  for (std::string line; std::getline(in, line);)
    if (const std::size_t equals = line.find('='); equals != line.npos)
      values.insert(line.substr(equals + 1));
  for (const std::string& value : values) text += "\n" + value;
  return text;
}

std::string text_of_experiment(const std::filesystem::path& run) try {
  return read_file(RunPaths(run).experiment_path());
} catch (const std::exception&) {  // the list names it
  return "";
}

}  // namespace

std::vector<FactKey> fact_keys() {
  std::vector<FactKey> keys{{"folder", "name of the run folder"},
                            {"name", "run.name"},
                            {"started", "beginning, such as 2026-11-30T12:00:00Z; 2026-12 is before it"},
                            {"lab", "inkjet, ice or aerosol"},
                            {"scheme", "control.scheme"},
                            {"outcome",
                             "finished, ended early, stopped safely, waits for operator, out of tolerance, "
                             "interrupted, running, unreadable"},
                            {"reason", "of the outcome"},
                            {"layers", "printed layers; of a print that has ended"},
                            {"seed", "of the simulated world"},
                            {"rms_um", "RMS of the last map about the target"},
                            {"mean_um", "mean error of the last map"},
                            {"std_um", "roughness of the last map"},
                            {"rms_inside_um", "RMS of cells away from the rim"},
                            {"rms_rim_um", "RMS of cells of the rim"},
                            {"tolerance_um", "largest RMS that is within tolerance"},
                            {"within", "true or false: the last map is within tolerance"},
                            {"part", "name of the part"},
                            {"size_x_mm", "size of the part along x"},
                            {"size_y_mm", "size of the part along y"},
                            {"size_z_mm", "height of the part"},
                            {"overspill_percent", "volume beside the part over the part's"},
                            {"audit", "clean, or the violations"},
                            {"host", "computer that printed"},
                            {"bytes", "size of the run folder"},
                            {"tag", "any tag"},
                            {"note", "any note"}};
  for (const OutlineMetric& m : kOutlineMetrics)
    if (m.value != &OutlineStats::overspill) keys.push_back({m.name, m.meaning});
  return keys;
}

RunFacts run_facts(const RunEntry& e, bool settings) {
  RunFacts all;
  all.lab = e.lab;
  all.started_utc = e.started_utc;
  all.ended = e.result.has_value();
  Facts facts(all.facts);
  facts.word("folder", e.folder.filename().string());
  facts.word("name", e.name);
  facts.word("started", e.started_utc);
  facts.word("lab", e.lab);
  facts.word("scheme", e.scheme);
  facts.word("outcome", outcome_of(e));
  facts.word("reason", e.reason);
  if (e.result) facts.number("layers", e.layers);
  if (e.seed) facts.number("seed", double(*e.seed));
  facts.number("bytes", double(e.bytes));
  facts.word("host", e.meta.host);
  if (e.result) add_result(*e.result, facts);
  for (const MetaEntry& m : e.meta.values) {
    const auto* number = std::get_if<double>(&m.value);
    const auto* integer = std::get_if<std::int64_t>(&m.value);
    all.facts.push_back({"meta." + m.key,
                         number    ? std::optional(*number)
                         : integer ? std::optional(double(*integer))
                                   : std::nullopt,
                         meta_value_text(m.value)});
  }
  for (const std::string& tag : e.notes.tags()) facts.word("tag", tag);
  for (const NoteEntry& note : e.notes.notes()) facts.word("note", note.text);
  const std::string toml = text_of_experiment(e.folder);
  all.text = searched_text(e, toml);
  if (settings && !toml.empty()) try {
      add_settings(toml, facts);
      all.settings = true;
    } catch (const std::exception&) {  // of a version that this one cannot read
    }
  return all;
}

std::string run_listing_text(const RunEntry& r) {
  const RunResult result = r.result.value_or(RunResult{});
  const auto known = [](const auto& value) { return value ? ListingJson(*value) : ListingJson(nullptr); };
  const auto text = [](const std::string& words) {
    return words.empty() ? ListingJson(nullptr) : ListingJson(words);
  };
  ListingJson j{{"run_id", r.run_id},
                {"started_utc", r.started_utc},
                {"name", r.name},
                {"lab", r.lab},
                {"scheme", r.scheme},
                {"seed", known(r.seed)},
                {"outcome", r.outcome},
                {"layers", r.layers},
                {"reason", r.reason},
                {"bytes", r.bytes},
                {"part", result.part ? ListingJson(result.part->name) : ListingJson(nullptr)},
                {"size_mm", result.part ? ListingJson(result.part->size_mm) : ListingJson(nullptr)},
                {"tolerance_um", known(result.tolerance_um)},
                {"overspill_percent", known(result.overspill_percent)},
                {"audit", text(result.audit)}};
  for (const auto& [key, um] : kErrors)
    j[std::string(key)] = result.error ? ListingJson((*result.error).*um) : ListingJson(nullptr);
  for (const OutlineMetric& m : kOutlineMetrics)
    if (m.value != &OutlineStats::overspill) {
      const double v = result.outline ? (*result.outline).*m.value * m.factor : kNotMeasured;
      j[std::string(m.name)] = std::isfinite(v) ? ListingJson(v) : ListingJson(nullptr);
    }
  j["within"] = known(r.result ? within_tolerance(result) : std::nullopt);
  j["verdict"] = text(r.result ? verdict_words(result, lab_words(r.lab)) : "");
  j["host"] = text(r.meta.host);
  j["meta"] = ListingJson::object();
  for (const MetaEntry& m : r.meta.values) std::visit([&](const auto& v) { j["meta"][m.key] = v; }, m.value);
  j["tags"] = r.notes.tags();
  j["notes"] = ListingJson::array();
  for (const NoteEntry& n : r.notes.notes())
    j["notes"].push_back(
        {{"time_utc", n.time_utc}, {"author", n.author}, {"host", n.host}, {"text", n.text}});
  return j.dump(-1, ' ', false, ListingJson::error_handler_t::replace);
}

}  // namespace firn::runs
