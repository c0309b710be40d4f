#include "config/study.h"

#include <algorithm>
#include <set>
#include <sstream>

#define TOML_SHARED_LIB 1
#include <toml++/toml.h>

#include "config/error.h"
#include "config/include.h"
#include "config/study_design.h"
#include "config/study_labs.h"
#include "config/study_values.h"
#include "config/text_limits.h"
#include "files/nearest.h"
#include "files/run_paths.h"

namespace firn {
namespace {

constexpr std::size_t kMaxRuns = 1000;

class StudyReader : private StudyValues {
 public:
  explicit StudyReader(const std::string& file) : StudyValues(file), design_(file) {}

  Study read(const toml::table& table) {
    refuse_experiment(table);
    for (const auto& [key, node] : table) {
      const std::string k(key.str());
      const int line = int(key.source().begin.line);
      if (k == "name")
        study_.name = name_of(node, k, line);
      else if (k == "experiment")
        study_.experiment = text_of(node, k, line);
      else if (k == "set")
        study_.overrides = overrides_of(node, k, line);
      else if (k == "seeds")
        seeds(node, line);
      else if (k == "metrics")
        study_.metrics = metrics_of(node, line);
      else if (k == "baseline")
        baseline(node, line);
      else if (k == "judged")
        judged(node, line);
      else if (k == "margin")
        margin(node, line);
      else if (k == "worlds")
        study_.worlds.file = text_of(node, k, line);
      else if (k == "labs")
        study_.worlds.use = use_of(node, line);
      else if (k == "scheme")
        entries(node, k, line, schemes_);
      else if (k == "part")
        entries(node, k, line, study_.parts);
      else if (DesignReader::knows(k))
        design_.read(k, node, line);
      else
        unknown(k, line,
                {"name", "experiment", "set", "seeds", "metrics", "baseline", "judged", "margin", "worlds",
                 "labs", "scheme", "part", "vary", "zip", "sample", "prior"});
    }
    if (std::ranges::any_of(schemes_, [](const StudyEntry& s) { return !s.runs.empty(); })) recorded(table);
    if (!study_.worlds.file.empty())
      of_worlds(table);
    else if (table.contains("labs"))
      fail(0, "labs", "has no meaning without worlds = \"FILE.toml\", which declares them");
    else if (study_.seeds.empty())
      fail(0, "seeds", "is missing: a count, as in seeds = 100, or a list");
    if (study_.parts.empty()) study_.parts.push_back({"part", {}, 0});
    combine();
    finish();
    return study_;
  }

 private:
  // The sections of an experiment are tables, those of a study lists of tables, but for its design.
  void refuse_experiment(const toml::table& table) const {
    if (table.contains("seeds") || table.contains("scheme")) return;
    for (const auto& [key, node] : table)
      if (const std::string k(key.str()); k == "include" || (node.is_table() && !DesignReader::knows(k)))
        fail(int(key.source().begin.line), k,
             "is of an experiment, and this should be a study: firn print prints an experiment; a study "
             "names it, as in "
             "experiment = \"FILE.toml\"");
  }

  // Schemes that are runs on record: the n-th runs of all stand where seeds do.
  void recorded(const toml::table& table) {
    for (const auto& [key, node] : table) {
      const std::string k(key.str());
      if (k != "name" && k != "metrics" && k != "baseline" && k != "scheme")
        fail(int(key.source().begin.line), k,
             "has no meaning for schemes with runs, which are printed already");
    }
    const std::size_t count = schemes_.front().runs.size();
    for (const StudyEntry& s : schemes_) {
      if (s.runs.empty()) fail(s.line, "scheme", s.name + " has no runs, another scheme has");
      if (!s.overrides.empty())
        fail(s.line, "scheme.set", "has no meaning for runs, which are printed already");
      if (s.runs.size() != count)
        fail(s.line, "scheme.runs",
             s.name + " has " + std::to_string(s.runs.size()) + ", " + schemes_.front().name + " has " +
                 std::to_string(count) + ": the n-th runs of all schemes are compared with each other");
    }
    for (std::size_t n = 1; n <= count; ++n) study_.seeds.push_back(n);
  }

  LabSet use_of(const toml::node& node, int line) const {
    const std::string word = text_of(node, "labs", line);
    const auto found = std::ranges::find(kLabSetWords, word);
    if (found == kLabSetWords.end()) fail(line, "labs", "must be one of tuning, held_out");
    return LabSet(found - kLabSetWords.begin());
  }

  // The declaration has these already, so that no study of it differs in them.
  void of_worlds(const toml::table& table) const {
    if (!table.contains("labs")) fail(0, "labs", "is missing: \"tuning\" or \"held_out\" labs of the worlds");
    for (const char* key : {"experiment", "part", "prior", "metrics"})
      if (table.contains(key))
        fail(int(table.get(key)->source().begin.line), key, "is declared by the file of worlds");
    if (const toml::node* list = table.get("seeds"); list && !list->is_integer())
      fail(int(list->source().begin.line), "seeds", "must be a count of the declared labs, from the first");
  }

  void baseline(const toml::node& node, int line) {
    study_.baseline = text_of(node, "baseline", line);
    baseline_line_ = line;
  }

  void judged(const toml::node& node, int line) {
    study_.judged = text_of(node, "judged", line);
    judged_line_ = line;
  }

  void margin(const toml::node& node, int line) {
    const auto value = node.value<double>();
    if (!value || !(*value > 1.0 && *value <= 10.0))
      fail(line, "margin", "must be a factor above 1, at most 10");
    study_.margin = *value;
  }

  std::vector<std::string> runs_of(const toml::node& node, int line) const {
    const toml::array* list = node.as_array();
    if (!list || list->empty() || list->size() > kMaxRuns)
      fail(line, "scheme.runs", "must be a list of 1 to " + std::to_string(kMaxRuns) + " run folders");
    std::vector<std::string> out;
    for (const toml::node& entry : *list) out.push_back(text_of(entry, "scheme.runs", line));
    return out;
  }

  void seeds(const toml::node& node, int line) {
    const std::string limits = "must be a count from 1 to " + std::to_string(kMaxSeeds) +
                               ", or a list of different seeds of 0 or more";
    if (node.is_integer()) {
      const std::int64_t count = node.as_integer()->get();
      if (count < 1 || count > std::int64_t(kMaxSeeds)) fail(line, "seeds", limits);
      for (std::int64_t s = 1; s <= count; ++s) study_.seeds.push_back(std::uint64_t(s));
      return;
    }
    const toml::array* list = node.as_array();
    if (!list || list->empty() || list->size() > kMaxSeeds) fail(line, "seeds", limits);
    for (const toml::node& entry : *list) {
      if (!entry.is_integer() || entry.as_integer()->get() < 0) fail(line, "seeds", limits);
      study_.seeds.push_back(std::uint64_t(entry.as_integer()->get()));
    }
    if (std::set(study_.seeds.begin(), study_.seeds.end()).size() != study_.seeds.size())
      fail(line, "seeds", limits);
  }

  void entries(const toml::node& node, const std::string& kind, int line, std::vector<StudyEntry>& out) {
    const toml::array* list = node.as_array();
    if (!list || !list->is_array_of_tables())
      fail(line, kind, "must be written as [[" + kind + "]] with name and set");
    for (const toml::node& entry : *list) {
      StudyEntry e;
      e.line = int(entry.source().begin.line);
      for (const auto& [key, value] : *entry.as_table()) {
        const std::string k(key.str());
        const int at = int(key.source().begin.line);
        if (k == "name")
          e.name = name_of(value, kind + ".name", at);
        else if (k == "set")
          e.overrides = overrides_of(value, kind + ".set", at);
        else if (k == "runs" && kind == "scheme")
          e.runs = runs_of(value, at);
        else
          unknown(kind + "." + k, at, {"name", "set", "runs"});
      }
      if (e.name.empty()) fail(e.line, kind, "has no name");
      out.push_back(std::move(e));
    }
  }

  void combine() {
    if (schemes_.empty()) {
      if (!design_.varies()) fail(0, "scheme", "is missing: name at least one [[scheme]], or [vary] a key");
      schemes_.push_back({"", {}, 0});
    }
    study_.arms = design_.combined(schemes_);
    study_.priors = design_.priors();
    study_.file = file();
  }

  void finish() {
    unique(study_.arms, "scheme");
    unique(study_.parts, "part");
    if (study_.arms.size() > kMaxArms) fail(0, "scheme", "more than 64 schemes");
    if (study_.parts.size() > kMaxParts) fail(0, "part", "more than 64 parts");
    if (study_.arms.size() * study_.parts.size() * study_.seeds.size() > kMaxPrints)
      fail(0, "seeds", "asks for more than " + std::to_string(kMaxPrints) + " prints");
    of_arms("baseline", study_.baseline, baseline_line_);
    of_arms("judged", study_.judged, judged_line_);
    if (!study_.judged.empty() && study_.baseline.empty())
      fail(judged_line_, "judged", "needs a baseline, to which all ratios are");
  }

  void of_arms(const std::string& key, const std::string& name, int line) const {
    const auto& arms = study_.arms;
    if (name.empty() || std::ranges::find(arms, name, &StudyEntry::name) != arms.end()) return;
    std::string known;
    for (const StudyEntry& a : arms) known += (known.empty() ? "" : ", ") + a.name;
    fail(line, key, "'" + name.substr(0, 100) + "' is not one of " + known);
  }

  void unique(const std::vector<StudyEntry>& entries, const std::string& kind) const {
    std::set<std::string> seen;
    for (const StudyEntry& e : entries)
      if (!seen.insert(e.name).second) fail(e.line, kind, "the name '" + e.name + "' is given twice");
  }

  Study study_;
  std::vector<StudyEntry> schemes_;
  DesignReader design_;
  int baseline_line_ = 0, judged_line_ = 0;
};

}  // namespace

Study parse_study(std::string_view text, const std::string& file) {
  check_text(text, file);
  try {
    return StudyReader(file).read(toml::parse(text, file));
  } catch (const toml::parse_error& e) {
    throw ConfigError(
        file, int(e.source().begin.line), "",
        "column " + std::to_string(e.source().begin.column) + ": " + std::string(e.description()));
  }
}

Study load_study(const std::filesystem::path& path) {
  Study s = parse_study(read_config_text(path), path.string());
  if (s.name.empty()) s.name = path.stem().string();
  if (!s.worlds.file.empty()) take_worlds(s, path.parent_path());
  return s;
}

std::filesystem::path study_experiment_file(const Study& study, const std::filesystem::path& folder) {
  const auto file = (folder / study.experiment).lexically_normal();
  return std::filesystem::is_directory(file) ? RunPaths(file).experiment_path() : file;
}

std::vector<std::pair<std::string, std::string>> study_texts(const Study& study,
                                                             const std::filesystem::path& folder) {
  if (study.experiment.empty() && study.lab.empty()) return {};
  if (study.experiment.empty()) return read_with_includes(study.lab);
  auto texts = read_with_includes(study_experiment_file(study, folder));
  if (study.lab.empty()) return texts;
  if (texts.size() < 2)
    throw ConfigError(texts.back().first, 0, "include",
                      "includes no lab, so that " + study.lab.string() + " replaces none");
  auto with_lab = read_with_includes(study.lab);
  with_lab.push_back(std::move(texts.back()));
  return with_lab;
}

std::vector<Experiment> study_experiments(const Study& study, const std::filesystem::path& folder) {
  const auto texts = study_texts(study, folder);
  std::vector<Experiment> out;
  for (const StudyEntry& arm : study.arms)
    for (const StudyEntry& part : study.parts) {
      std::vector<std::string> overrides = study.overrides;
      overrides.insert(overrides.end(), part.overrides.begin(), part.overrides.end());
      overrides.insert(overrides.end(), arm.overrides.begin(), arm.overrides.end());
      try {
        out.push_back(parse_experiment(texts, overrides));
      } catch (const ConfigError& e) {
        throw ConfigError(e.file, e.line, e.key,
                          "scheme '" + arm.name + "' on part '" + part.name + "': " + e.problem);
      }
    }
  return out;
}

}  // namespace firn
