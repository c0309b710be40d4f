#include "config/worlds.h"

#include <algorithm>
#include <set>

#define TOML_SHARED_LIB 1
#include <toml++/toml.h>

#include "config/error.h"
#include "config/include.h"
#include "config/study_design.h"
#include "config/study_values.h"
#include "config/text_limits.h"

namespace firn {
namespace {

constexpr std::int64_t kMaxLabs = 100'000;  // of a kind, as many as a study has seeds
constexpr std::size_t kMaxWorlds = 64, kMaxGoals = 20;

using Priors = std::array<std::vector<KeyRange>, 2>;

class WorldReader : private StudyValues {
 public:
  explicit WorldReader(const std::string& file) : StudyValues(file) {}

  WorldList read(const toml::table& table) {
    list_.file = file();
    for (const auto& [key, node] : table) {
      const std::string k(key.str());
      const int line = int(key.source().begin.line);
      if (k == "name")
        list_.name = name_of(node, k, line);
      else if (k == "experiment")
        list_.experiment = text_of(node, k, line);
      else if (k == "set")
        list_.overrides = overrides_of(node, k, line);
      else if (k == "metrics")
        list_.metrics = metrics_of(node, line);
      else if (k == "seeds")
        seeds(node, line);
      else if (k == "goal")
        each(node, k, line, kMaxGoals, [&](const toml::table& t, int at) { goal(t, at); });
      else if (k == "world")
        each(node, k, line, kMaxWorlds, [&](const toml::table& t, int at) { world(t, at); });
      else if (const auto use = std::ranges::find(kLabSetWords, k); use != kLabSetWords.end())
        common_[std::size_t(use - kLabSetWords.begin())] = priors(node, k, line);
      else
        unknown(k, line,
                {"name", "experiment", "set", "metrics", "seeds", "goal", "world", "tuning", "held_out"});
    }
    finish();
    return list_;
  }

 private:
  template <class F>
  void each(const toml::node& node, const std::string& kind, int line, std::size_t most, const F& f) const {
    const toml::array* all = node.as_array();
    if (!all || !all->is_array_of_tables() || all->size() > most)
      fail(line, kind, "must be written as [[" + kind + "]], at most " + std::to_string(most) + " times");
    for (const toml::node& entry : *all) f(*entry.as_table(), int(entry.source().begin.line));
  }

  std::vector<KeyRange> priors(const toml::node& node, const std::string& key, int line) const {
    if (!node.is_table()) fail(line, key, "must be a section of keys of plant.* and their ranges");
    DesignReader reader(file());
    reader.read("prior", node, line);
    return reader.priors();
  }

  void seeds(const toml::node& node, int line) {
    const toml::table* table = node.as_table();
    if (!table)
      fail(line, "seeds", "must be a section with tuning = [FIRST, LAST] and held_out = [FIRST, LAST]");
    for (const auto& [key, value] : *table) {
      const std::string k(key.str());
      const int at = int(key.source().begin.line);
      const auto use = std::ranges::find(kLabSetWords, k);
      if (use == kLabSetWords.end()) unknown("seeds." + k, at, {kLabSetWords.begin(), kLabSetWords.end()});
      const toml::array* ends = value.as_array();
      const bool pair = ends && ends->size() == 2 && ends->get(0)->is_integer() && ends->get(1)->is_integer();
      const std::int64_t first = pair ? ends->get(0)->as_integer()->get() : -1,
                         last = pair ? ends->get(1)->as_integer()->get() : -1;
      if (first < 0 || last < first || last - first >= kMaxLabs)
        fail(at, "seeds." + k,
             "must be the first and the last seed, [FIRST, LAST], at most 100000 of 0 or more");
      for (std::int64_t s = first; s <= last; ++s)
        list_.seeds[std::size_t(use - kLabSetWords.begin())].push_back(std::uint64_t(s));
    }
  }

  void goal(const toml::table& table, int line) {
    DeclaredGoal g;
    for (const auto& [key, value] : table) {
      const std::string k(key.str());
      const int at = int(key.source().begin.line);
      if (k == "name")
        g.name = name_of(value, "goal.name", at);
      else if (k == "metric")
        g.metric = name_of(value, "goal.metric", at);
      else if (k == "says")
        g.says = text_of(value, "goal.says", at);
      else
        unknown("goal." + k, at, {"name", "metric", "says"});
    }
    if (g.name.empty() || g.says.empty()) fail(line, "goal", "has no name, or says nothing");
    list_.goals.push_back(std::move(g));
  }

  void world(const toml::table& table, int line) {
    DeclaredWorld w;
    w.line = line;
    for (const auto& [key, value] : table) {
      const std::string k(key.str());
      const int at = int(key.source().begin.line);
      if (k == "name")
        w.name = name_of(value, "world.name", at);
      else if (k == "source")
        w.source = text_of(value, "world.source", at);
      else if (k == "set")
        w.overrides = overrides_of(value, "world.set", at);
      else if (k == "unseen" && value.is_boolean())
        w.unseen = value.as_boolean()->get();
      else if (k == "unseen")
        fail(at, "world.unseen", "must be true or false");
      else if (const auto use = std::ranges::find(kLabSetWords, k); use != kLabSetWords.end())
        w.priors[std::size_t(use - kLabSetWords.begin())] = priors(value, "world." + k, at);
      else
        unknown("world." + k, at, {"name", "source", "set", "unseen", "tuning", "held_out"});
    }
    if (w.name.empty()) fail(line, "world", "has no name");
    if (w.source.empty())
      fail(line, "world.source", "is missing: where the physics of " + w.name + " comes from");
    list_.worlds.push_back(std::move(w));
  }

  void finish() {
    if (list_.worlds.empty()) fail(0, "world", "is missing: declare at least one [[world]]");
    if (list_.metrics.empty()) fail(0, "metrics", "is missing: the primary metric first");
    std::set<std::string> names;
    for (DeclaredWorld& w : list_.worlds) {
      if (!names.insert(w.name).second) fail(w.line, "world", "the name '" + w.name + "' is given twice");
      for (const LabSet use : {LabSet::kTuning, LabSet::kHeldOut}) check(w, use);
      different(w);
    }
    const auto& [tuning, held_out] = list_.seeds;
    if (held_out.empty()) fail(0, "seeds.held_out", "is missing: seeds that draw the labs to judge in");
    for (const std::uint64_t seed : held_out)
      if (std::ranges::binary_search(tuning, seed))
        fail(0, "seeds", "seed " + std::to_string(seed) + " is of tuning and of held_out");
    for (const DeclaredGoal& g : list_.goals)
      if (!g.metric.empty() && std::ranges::find(list_.metrics, g.metric) == list_.metrics.end())
        fail(0, "goal.metric", g.metric + " is not one of the metrics");
  }

  /// Joins the priors of all worlds to a world's own.
  void check(DeclaredWorld& w, LabSet use) {
    std::vector<KeyRange>& own = w.priors[std::size_t(use)];
    const std::string word(kLabSetWords[std::size_t(use)]);
    if (use == LabSet::kTuning && w.unseen) {
      if (!own.empty()) fail(w.line, "world.tuning", w.name + " is unseen: nothing is tuned in it");
      return;
    }
    if (own.empty())
      fail(w.line, "world." + word, w.name + " has no such section, from which its labs are drawn");
    if (use == LabSet::kTuning && list_.seeds[0].empty())
      fail(w.line, "seeds.tuning", "is missing: seeds that draw the labs to tune in");
    for (const KeyRange& all : common_[std::size_t(use)])
      if (std::ranges::find(own, all.key, &KeyRange::key) == own.end()) own.push_back(all);
  }

  /// A scheme that is judged in labs like those it was tuned in shows no more than its tuning.
  void different(const DeclaredWorld& w) const {
    for (const KeyRange& a : w.priors[0]) {
      const auto b = std::ranges::find(w.priors[1], a.key, &KeyRange::key);
      if (b != w.priors[1].end() && a.low == b->low && a.high == b->high && a.law == b->law)
        fail(b->line, "world.held_out",
             w.name + " draws " + a.key + " from the range that it has for tuning");
    }
  }

  WorldList list_;
  Priors common_;
};

}  // namespace

WorldList parse_worlds(std::string_view text, const std::string& file) {
  check_text(text, file);
  try {
    return WorldReader(file).read(toml::parse(text, file));
  } catch (const toml::parse_error& e) {
    throw ConfigError(
        file, int(e.source().begin.line), "",
        "column " + std::to_string(e.source().begin.column) + ": " + std::string(e.description()));
  }
}

WorldList load_worlds(const std::filesystem::path& path) {
  WorldList list = parse_worlds(read_config_text(path), path.string());
  if (list.name.empty()) list.name = path.stem().string();
  return list;
}

}  // namespace firn
