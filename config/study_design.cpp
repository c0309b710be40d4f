#include "config/study_design.h"

#define TOML_SHARED_LIB 1
#include <toml++/toml.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "config/error.h"
#include "core/options/range.h"
#include "core/statistics/space_filling.h"

namespace firn {
namespace {

constexpr std::size_t kMaxKeys = 6;      // of [vary] and of [zip]
constexpr std::size_t kMaxPriors = 100;  // keys

struct Entry {
  std::string key;
  const toml::node* node;
  int line;
};

// A table of these keys is a range; any other one holds keys with a common beginning.
bool is_range(const toml::table& table) { return table.contains("from") || table.contains("mean"); }

// The keys of a section with their values, whether written "a.b" = … or a.b = ….
void collect(const toml::table& table, const std::string& prefix, std::vector<Entry>& out) {
  for (const auto& [key, node] : table) {
    const std::string full = prefix + std::string(key.str());
    const toml::table* inner = node.as_table();
    if (inner && !is_range(*inner))
      collect(*inner, full + ".", out);
    else
      out.push_back({full, &node, int(key.source().begin.line)});
  }
}

std::vector<Entry> entries_of(const toml::table& table) {
  std::vector<Entry> entries;
  collect(table, "", entries);
  return entries;
}

}  // namespace

bool DesignReader::knows(std::string_view section) {
  return std::ranges::find(kSections, section) != std::end(kSections);
}

void DesignReader::fail(int line, const std::string& key, const std::string& problem) const {
  throw ConfigError(file_, line, key, key + ": " + problem);
}

void DesignReader::read(const std::string& section, const toml::node& node, int line) {
  const toml::table* table = node.as_table();
  if (!table) fail(line, section, "must be a section, [" + section + "], of keys and their values");
  if (section == "vary") return vary(*table);
  if (section == "zip") return zip(*table, line);
  if (section == "sample") return sample(*table, line);
  prior(*table);
}

void DesignReader::Level::add(const std::string& key, const std::string& value) {
  std::string plain = value;
  std::erase_if(plain, [](char c) { return c == '"' || c == '\''; });
  name += (name.empty() ? "" : " ") + key.substr(key.rfind('.') + 1) + "=" + plain;
  overrides.push_back(key + "=" + value);
}

namespace {

// The values of a list as they are written; none if it is no list of numbers and texts.
std::vector<std::string> values_of(const toml::node& node) {
  std::vector<std::string> values;
  const toml::array* list = node.as_array();
  if (!list || list->size() > kMaxArms) return {};
  for (const toml::node& entry : *list) {
    if (!entry.is_value()) return {};
    std::ostringstream text;
    if (entry.is_floating_point())  // the library writes 17 digits: 0.20000000000000001
      text << shortest_text(entry.as_floating_point()->get());
    else
      entry.visit([&](const auto& n) { text << n; });
    values.push_back(text.str());
  }
  return values;
}

const char* const kList = " must be a list of 1 to 64 numbers and texts";

}  // namespace

void DesignReader::vary(const toml::table& table) {
  const std::vector<Entry> entries = entries_of(table);
  if (entries.size() > kMaxKeys) fail(entries[kMaxKeys].line, "vary", "varies more than 6 keys");
  for (const Entry& e : entries) {
    Factor factor{{e.key}, {}, e.line};
    for (const std::string& value : values_of(*e.node)) factor.levels.emplace_back().add(e.key, value);
    if (factor.levels.empty()) fail(e.line, "vary", e.key + kList);
    factors_.push_back(std::move(factor));
  }
}

void DesignReader::zip(const toml::table& table, int line) {
  Factor factor{{}, {}, line};
  for (const Entry& e : entries_of(table)) {
    const std::vector<std::string> values = values_of(*e.node);
    if (values.empty()) fail(e.line, "zip", e.key + kList);
    if (factor.keys.empty()) factor.levels.resize(values.size());
    if (values.size() != factor.levels.size())
      fail(e.line, "zip",
           e.key + " has " + std::to_string(values.size()) + " values, " + factor.keys.front() + " has " +
               std::to_string(factor.levels.size()) + ": the n-th values of all keys belong together");
    factor.keys.push_back(e.key);
    if (factor.keys.size() > kMaxKeys) fail(e.line, "zip", "varies more than 6 keys");
    for (std::size_t n = 0; n < values.size(); ++n) factor.levels[n].add(e.key, values[n]);
  }
  if (factor.keys.empty()) fail(line, "zip", "names no key");
  factors_.push_back(std::move(factor));
}

void DesignReader::sample(const toml::table& table, int line) {
  SampleDesign design;
  Factor factor{{}, {}, line};
  for (const Entry& e : entries_of(table)) {
    const auto whole = e.node->value_exact<std::int64_t>();
    if (e.key == "design") {
      const auto word = e.node->value<std::string>();
      if (word != "latin" && word != "sobol")
        fail(e.line, "sample.design", "must be \"latin\" (hypercube) or \"sobol\"");
      design.kind = word == "sobol" ? SampleDesign::Kind::kSobol : SampleDesign::Kind::kLatin;
    } else if (e.key == "points") {
      if (!whole || *whole < 1 || *whole > std::int64_t(kMaxArms))
        fail(e.line, "sample.points", "must be an integer in [1, 64]");
      design.points = int(*whole);
    } else if (e.key == "seed") {
      if (!whole || *whole < 0) fail(e.line, "sample.seed", "must be an integer of 0 or more");
      design.seed = std::uint64_t(*whole);
    } else {
      design.ranges.push_back(range_of("sample", e.key, *e.node, e.line));
      factor.keys.push_back(e.key);
    }
  }
  if (design.points == 0) fail(line, "sample.points", "is missing: how many settings are drawn");
  if (design.ranges.empty() || design.ranges.size() > std::size_t(statistics::kMaxDesignAxes))
    fail(line, "sample", "must name 1 to 6 keys with their ranges, as in \"control.smf.kp\" = [0.1, 2.0]");
  std::set<std::vector<std::string>> seen;
  for (const std::vector<std::string>& setting : design.settings()) {
    if (!seen.insert(setting).second) continue;  // of integers some points are equal
    Level& level = factor.levels.emplace_back();
    for (const std::string& assignment : setting) {
      const std::size_t equals = assignment.find('=');
      level.add(assignment.substr(0, equals), assignment.substr(equals + 1));
    }
  }
  factors_.push_back(std::move(factor));
}

void DesignReader::prior(const toml::table& table) {
  for (const Entry& e : entries_of(table)) {
    if (!e.key.starts_with("plant.") || e.key == "plant.seed")
      fail(e.line, "prior", e.key + ": a seed draws the simulated lab, keys of plant.* but its seed");
    priors_.push_back(range_of("prior", e.key, *e.node, e.line));
    if (priors_.size() > kMaxPriors) fail(e.line, "prior", "draws more than 100 keys");
  }
}

KeyRange DesignReader::range_of(const std::string& section, const std::string& key, const toml::node& node,
                                int line) const {
  KeyRange r;
  r.key = key;
  r.line = line;
  const auto wrong = [&](const std::string& problem) { fail(line, section, key + " " + problem); };
  const auto number = [&](const toml::node* n) {
    const auto value = n ? n->value<double>() : std::nullopt;
    if (!value || !(std::abs(*value) < 1e300))
      wrong("must be a range: [LOW, HIGH], {from = LOW, to = HIGH, scale = \"log\"}" +
            std::string(section == "prior" ? ", or {mean = M, std = S}" : ""));
    return *value;
  };
  const toml::node *low = nullptr, *high = nullptr;
  if (const toml::array* pair = node.as_array(); pair && pair->size() == 2) {
    low = pair->get(0);
    high = pair->get(1);
  } else if (const toml::table* t = node.as_table()) {
    const bool normal = t->contains("mean");
    for (const auto& [name, value] : *t)
      if (const std::string n(name.str());
          normal ? n != "mean" && n != "std" : n != "from" && n != "to" && n != "scale")
        wrong("has '" + n.substr(0, 60) + "', which a range has not");
    if (normal && section != "prior") wrong("is no range: only a lab is drawn from a normal distribution");
    low = t->get(normal ? "mean" : "from");
    high = t->get(normal ? "std" : "to");
    const toml::node* scale = t->get("scale");
    const auto word = scale ? scale->value<std::string>() : std::string("linear");
    if (word != "linear" && word != "log") wrong("must have the scale \"linear\" or \"log\"");
    r.law = normal          ? KeyRange::Law::kNormal
            : word == "log" ? KeyRange::Law::kLogUniform
                            : KeyRange::Law::kUniform;
  }
  r.low = number(low);
  r.high = number(high);
  r.whole = r.law == KeyRange::Law::kUniform && low->is_integer() && high->is_integer();
  if (r.law == KeyRange::Law::kNormal) {
    if (r.high < 0.0) wrong("has a negative standard deviation");
  } else if (r.low > r.high) {
    wrong("ends below its beginning");
  } else if (r.law == KeyRange::Law::kLogUniform && r.low <= 0.0) {
    wrong("has a logarithmic scale and must lie above 0");
  }
  return r;
}

std::vector<StudyEntry> DesignReader::combined(std::vector<StudyEntry> arms) const {
  std::set<std::string> seen;
  for (const Factor& factor : factors_) {
    for (const std::string& key : factor.keys)
      if (!seen.insert(key).second) fail(factor.line, key, "is varied twice");
    if (arms.size() * factor.levels.size() > kMaxArms)
      fail(factor.line, "vary", "gives more than 64 combinations");
    std::vector<StudyEntry> wider;
    for (const StudyEntry& arm : arms)
      for (const Level& level : factor.levels) {
        StudyEntry e = arm;
        e.name += (e.name.empty() ? "" : " ") + level.name;
        e.overrides.insert(e.overrides.end(), level.overrides.begin(), level.overrides.end());
        wider.push_back(std::move(e));
      }
    arms = std::move(wider);
  }
  return arms;
}

}  // namespace firn
