#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

#define TOML_SHARED_LIB 1
#include <toml++/toml.h>

#include "config/checks.h"
#include "config/error.h"
#include "config/fields.h"
#include "config/find_key.h"
#include "config/include.h"
#include "config/labs.h"
#include "config/meta_reader.h"
#include "config/reader.h"
#include "config/text_limits.h"
#include "core/control/python_scheme.h"
#include "files/nearest.h"

namespace firn {
namespace {

const std::string kSet = "--set";  // used as a file name
constexpr std::string_view kMeta = "meta.";
// Keys that only earlier versions had. A recorded experiment may have them; a written one may not.
constexpr std::array<std::string_view, 2> kRetiredKeys{
    "ice.curves",         // "ramped" or "fitted": the rule by which paths were planned
    "laser_point.poll_s"  // nothing read it
};

toml::table parse_text(std::string_view text, const std::string& file) {
  check_text(text, file);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& e) {
    throw ConfigError(
        file, int(e.source().begin.line), "",
        "column " + std::to_string(e.source().begin.column) + ": " + std::string(e.description()));
  }
}

std::string shown(const toml::node& node) {
  std::ostringstream out;
  node.visit([&](const auto& n) {
    if constexpr (toml::is_table<decltype(n)>)
      out << "{...}";
    else if constexpr (toml::is_array<decltype(n)>)
      out << "[...]";
    else
      out << n;
  });
  std::string text = out.str();
  if (const auto number =
          node.value_exact<double>()) {  // the library writes 17 digits: 1.0000000000000001e+300
    std::array<char, 40> buffer;
    const std::string_view digits(
        buffer.data(), std::size_t(std::to_chars(buffer.data(), buffer.data() + buffer.size(), *number).ptr -
                                   buffer.data()));
    if (text.size() > 15 && digits.size() < text.size()) text = digits;
  }
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

std::optional<MetaValue> meta_value_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return integer->get();
  if (const auto* number = node.as_floating_point()) return number->get();
  if (const auto* boolean = node.as_boolean()) return boolean->get();
  if (const auto* date = node.as_date()) {
    const toml::date d = date->get();
    const auto digits = [](unsigned value, std::size_t count) {
      const std::string text = std::to_string(value);
      return std::string(count - std::min(count, text.size()), '0') + text;
    };
    return digits(d.year, 4) + "-" + digits(d.month, 2) + "-" + digits(d.day, 2);
  }
  return std::nullopt;
}

MetaNode meta_node(const toml::node& node) {
  MetaNode m;
  m.value = meta_value_of(node);
  m.is_table = node.is_table();
  m.is_list = node.is_array();
  if (m.is_table)
    for (const auto& [key, member] : *node.as_table()) {
      m.members.push_back(meta_node(member));
      m.members.back().key = key.str();
      m.members.back().line = int(key.source().begin.line);
    }
  if (m.is_list)
    for (const toml::node& member : *node.as_array()) m.members.push_back(meta_node(member));
  return m;
}

// A word needs no quotes on a command line, neither a text like 007 nor the value of an unknown key: the
// error then reports the key.
toml::table assignment_of(const std::string& assignment, const std::vector<Field>& table) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError(kSet, 0, "",
                      "'" + assignment.substr(0, 100) + "': must read KEY=VALUE, as in " +
                          std::string(table.front().key) + "=" + value_text(table.front()));
  for (unsigned char c : assignment)
    if (c < 0x20 || c == 0x7f) throw ConfigError(kSet, 0, "", "must not contain control characters");
  const std::string key = assignment.substr(0, equals), value = assignment.substr(equals + 1);
  const auto as_word = [&] {
    std::string quoted;
    for (char c : value) quoted += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return parse_text(key + "=\"" + quoted + "\"", kSet);
  };
  const bool text = std::any_of(table.begin(), table.end(),
                                [&](const Field& f) { return f.key == key && type_text(f) == "text"; });
  if (text && !value.starts_with('"') && !value.starts_with('\'')) return as_word();
  try {
    return parse_text(assignment, kSet);
  } catch (const ConfigError&) {
    return as_word();
  }
}

class Reader {
 public:
  /// @param mistakes gets every mistake; null: the first one is thrown
  /// @param recorded dump() wrote the texts, perhaps in an earlier version
  /// @param meta receives [meta] and its declarations; null: there is no such section
  explicit Reader(std::vector<Field> table, std::vector<ConfigError>* mistakes = nullptr,
                  bool recorded = false, MetaReader* meta = nullptr)
      : fields_(std::move(table)), mistakes_(mistakes), recorded_(recorded), meta_(meta) {
    for (const Field& f : fields_) keys_.push_back(f.key);
  }

  /// @throws ConfigError for a machine's file where a lab's is wanted, and the other way round
  void check_kind_of_file(const toml::table& table, const std::string& file) const {
    const auto knows = [&](std::string_view key) { return std::ranges::find(keys_, key) != keys_.end(); };
    const auto refuse = [&](const std::string& section, const std::string& problem) {
      const int line = int(table.get(section)->source().begin.line);
      throw ConfigError(file, line, section, "[" + section + "]: " + problem);
    };
    if (knows("machine.kind") && table.contains("lab")) {
      std::string named;
      for (const auto& [section, node] : table)
        if (const auto machine = table[section.str()]["machine"].value<std::string>())
          named = "; its machine is " +
                  (std::filesystem::path(file).parent_path() / *machine).lexically_normal().generic_string();
      refuse("lab", "this is the file of a lab, and a machine's is wanted" + named);
    }
    if (knows("lab.kind") && table.contains("machine"))
      refuse("machine", "this is the file of a machine, and a lab's or an experiment's is wanted");
  }

  void read(const toml::table& table, const std::string& file, const std::string& prefix = "") {
    for (const auto& [key, node] : table) {
      const std::string full = prefix + std::string(key.str());
      if (full == "include" && file != kSet) continue;
      const int line = int(key.source().begin.line);
      tell([&, &value = node] { read_key(full, value, file, line); });
    }
  }

  void override_with(const std::vector<std::string>& assignments) {
    for (const std::string& assignment : assignments)
      tell([&] {
        try {
          if (meta_ && assignment.starts_with(kMeta))
            override_meta(assignment);
          else
            read(assignment_of(assignment, fields_), kSet);
        } catch (const ConfigError& e) {
          if (meta_ && assignment.starts_with(kMeta)) throw;
          throw ConfigError(kSet, 0, e.key, e.problem);  // a line number would mislead
        }
      });
  }

  /// Makes the paths that `file` gives relative to `home`.
  void paths_from(const std::string& file, const std::filesystem::path& home) {
    const std::filesystem::path own = std::filesystem::path(file).parent_path();
    if (own == home) return;
    for (Field& f : fields_) {
      const auto origin = origins_.find(f.key);
      if (origin == origins_.end() || origin->second.file != file) continue;
      const auto move = [&](std::string& path) {
        if (path.empty() || std::filesystem::path(path).is_absolute()) return;
        path = (own / path).lexically_normal().lexically_proximate(home.lexically_normal()).generic_string();
      };
      if (f.limits.is_path) move(*std::get<std::string*>(f.value));
      if (!f.limits.or_python) continue;
      std::string& text = *std::get<std::string*>(f.value);
      if (!control::is_python_scheme(text)) continue;
      control::PythonScheme scheme = control::parse_python_scheme(text);
      move(scheme.file);
      text = to_text(scheme);
    }
  }

  const Origins& origins() const { return origins_; }
  const std::vector<Field>& fields() const { return fields_; }

 private:
  template <class Read>
  void tell(Read read) const try {
    read();
  } catch (const ConfigError& e) {
    if (!mistakes_) throw;
    mistakes_->push_back(e.file == kSet ? ConfigError(kSet, 0, e.key, e.problem) : e);
  }

  void override_meta(const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos)
      throw ConfigError("--meta", 0, "meta",
                        "'" + assignment.substr(kMeta.size(), 100) + "': must read KEY=VALUE");
    const std::string key = assignment.substr(kMeta.size(), equals - kMeta.size());
    std::string word = assignment.substr(equals + 1);
    const bool in_quotes = word.starts_with('"') || word.starts_with('\'');
    if (!is_meta_key(key)) return meta_->override_with(key, MetaNode{}, word);  // names it
    const toml::table written = assignment_of(assignment, fields_);
    const toml::node& value = *written["meta"][key].node();
    if (in_quotes && value.is_string()) word = value.as_string()->get();
    meta_->override_with(key, meta_node(value), word);
  }

  void read_key(const std::string& full, const toml::node& node, const std::string& file, int line) {
    if (meta_ && MetaReader::reads(full)) return meta_->read(full, meta_node(node), file, line);
    const auto field =
        std::find_if(fields_.begin(), fields_.end(), [&](const Field& f) { return f.key == full; });
    if (field != fields_.end()) return assign(*field, node, file, line);
    if (recorded_ && file != kSet && std::ranges::find(kRetiredKeys, full) != kRetiredKeys.end()) return;
    if (!is_section(full)) unknown(full, file, line);
    if (!node.is_table())
      throw ConfigError(file, line, full, full + " = " + shown(node) + ": is a section of keys, not a value");
    read(*node.as_table(), file, full + ".");
  }

  bool is_section(const std::string& key) const {
    return std::any_of(keys_.begin(), keys_.end(),
                       [&](std::string_view k) { return k.starts_with(key + "."); });
  }

  [[noreturn]] void unknown(const std::string& key, const std::string& file, int line) const {
    constexpr std::string_view kOfStudies[] = {"baseline", "experiment", "metrics", "prior", "sample",
                                               "scheme",   "seeds",      "vary",    "zip"};
    if (file != kSet && std::ranges::find(kOfStudies, key) != std::end(kOfStudies))
      throw ConfigError(
          file, line, key,
          key + ": is of a study, and this should be an experiment: firn compare prints studies");
    std::string near = likeliest_key(fields_, key);
    if (near.empty()) {  // no word is known, but the letters may be
      std::vector<std::string_view> known = keys_;
      for (const Field& f : fields_)
        if (known.back() != f.section()) known.push_back(f.section());
      near = nearest(key, known);
    }
    std::string shown_key = key.substr(0, 100);
    throw ConfigError(
        file, line, key,
        shown_key + ": unknown key" + (near.empty() ? "" : "; the nearest known one is " + near));
  }

  void assign(Field& field, const toml::node& node, const std::string& file, int line) {
    const std::string key(field.key);
    const auto fail = [&](const std::string& problem) {
      throw ConfigError(file, line, key, key + " = " + shown(node) + ": " + problem);
    };
    std::string word;
    const auto taken = [&](auto& target) {
      if constexpr (std::is_pointer_v<std::remove_reference_t<decltype(target)>>)
        return take(node, *target);
      else
        return take(node, word);
    };
    if (!std::visit(taken, field.value))
      fail("must be " +
           std::string(type_text(field) == "integer" ? "an "
                       : type_text(field) == "text"  ? ""
                                                     : "a ") +
           std::string(type_text(field)) + (field.unit.empty() ? "" : " [" + std::string(field.unit) + "]") +
           wanted(field));
    if (const auto* w = std::get_if<WordMember>(&field.value)) {
      if (const std::string problem = broken_word(field, word); !problem.empty()) fail(problem);
      const auto& words = field.limits.choices;
      w->set(w->member, std::size_t(std::find(words.begin(), words.end(), word) - words.begin()));
    }
    if (const std::string problem = broken_limit(field); !problem.empty()) fail(problem);
    origins_[key] = {file, file == kSet ? 0 : line};
  }

  static std::string wanted(const Field& field) {
    const std::string limits = limits_text(field);
    return limits.empty() ? "" : limits.starts_with("one of") ? ", " + limits : " in " + limits;
  }

  static bool take(const toml::node& node, double& out) {
    if (!node.is_number()) return false;
    // toml++ has no value<double>() of an integer that a double does not hold; as_integer has, rounded: such
    // a number is beyond every limit.
    out = node.is_integer() ? double(node.as_integer()->get()) : node.as_floating_point()->get();
    if (out == 0.0) out = 0.0;  // one zero: equal experiments have equal dumps
    return true;
  }
  static bool take(const toml::node& node, std::int64_t& out) {
    if (!node.is_integer()) return false;
    out = node.as_integer()->get();
    return true;
  }
  static bool take(const toml::node& node, std::int32_t& out) {
    std::int64_t wide = 0;
    if (!take(node, wide)) return false;
    // Saturated values lie outside every field's limits, so that the message names the limit.
    out = std::int32_t(std::clamp<std::int64_t>(wide, INT32_MIN, INT32_MAX));
    return true;
  }
  static bool take(const toml::node& node, std::uint64_t& out) {
    std::int64_t wide = 0;
    if (!take(node, wide)) return false;
    out = wide < 0 ? UINT64_MAX : std::uint64_t(wide);
    return true;
  }
  static bool take(const toml::node& node, std::string& out) {
    if (!node.is_string()) return false;
    out = node.as_string()->get();
    return true;
  }
  static bool take(const toml::node& node, std::vector<double>& out) {
    const toml::array* numbers = node.as_array();
    if (!numbers || numbers->size() > 4000) return false;
    out.clear();
    for (const toml::node& entry : *numbers)
      if (!take(entry, out.emplace_back())) return false;
    return true;
  }
  static bool take(const toml::node& node, std::vector<AlphaStep>& out) {
    if (double alpha = 0.0; take(node, alpha)) {
      out = {{1, alpha}};
      return true;
    }
    const toml::array* steps = node.as_array();
    if (!steps || steps->size() > 1000) return false;
    out.clear();
    for (const toml::node& entry : *steps) {
      const toml::table* step = entry.as_table();
      AlphaStep s;
      if (!step || step->size() != 2 || !step->contains("from_layer") || !step->contains("alpha"))
        return false;
      if (!take(*step->get("from_layer"), s.from_layer) || !take(*step->get("alpha"), s.alpha)) return false;
      out.push_back(s);
    }
    return true;
  }

  std::vector<Field> fields_;
  std::vector<std::string_view> keys_;
  std::vector<ConfigError>* mistakes_;
  bool recorded_;
  MetaReader* meta_;
  Origins origins_;
};

// Refuses keys that only another kind of lab, another scheme or other physics have: these would be lost in
// silence. (lab.kind = "inkjet" is allowed: this is the default.)
void check_kind(const Reader& reader, const Experiment& e) {
  const std::string& kind = e.lab.kind;
  for (const Field& f : reader.fields())
    if (const auto origin = reader.origins().find(std::string(f.key));
        origin != reader.origins().end() && f.key != "lab.kind" && !belongs(f, e))
      throw ConfigError(
          origin->second.file, origin->second.line, std::string(f.key),
          std::string(f.key) + " = " + value_text(f) +
              (!belongs(f, kind)   ? ": lab.kind = \"" + kind + "\" has no such key"
               : !f.nature.empty() ? ": is of plant.model = \"" + std::string(f.nature) + "\""
                                   : ": is of control.scheme = \"" + std::string(f.scheme) + "\""));
}

}  // namespace

Origins read_fields(std::vector<Field> table, const std::string& toml_text, const std::string& file_name,
                    const std::vector<std::string>& overrides) {
  const toml::table parsed = parse_text(toml_text, file_name);
  if (const toml::node* include = parsed.get("include"))
    throw ConfigError(file_name, int(include->source().begin.line), "include",
                      "include: only experiments may include a file");
  Reader reader(std::move(table));
  reader.check_kind_of_file(parsed, file_name);
  reader.read(parsed, file_name);
  reader.override_with(overrides);
  return reader.origins();
}

std::string lab_kind_in(const std::string& toml_text) {
  std::string kind;
  try {
    kind = parse_text(toml_text, "")["lab"]["kind"].value_or("");
  } catch (const ConfigError&) {
  }
  const auto named = [&](const LabKind* lab) { return lab->name == kind; };
  return std::ranges::any_of(lab_kinds(), named) ? kind : std::string(lab_kinds().front()->name);
}

std::string include_of(const std::string& toml_text, const std::string& file_name) {
  const toml::table table = parse_text(toml_text, file_name);
  const toml::node* include = table.get("include");
  if (!include) return "";
  if (!include->is_string() || include->as_string()->get().empty())
    throw ConfigError(
        file_name, int(include->source().begin.line), "include",
        "include = " + shown(*include) + ": must be the path of a TOML file, relative to this one");
  return include->as_string()->get();
}

namespace {

// [hosts] has names of the user's own: they become fields.
void name_hosts(const std::vector<toml::table>& tables, const std::vector<std::string>& overrides,
                Experiment& e) {
  constexpr std::string_view kSection = "hosts.";
  for (const toml::table& table : tables)
    if (const toml::table* const hosts = table["hosts"].as_table())
      for (const auto& [name, _] : *hosts) e.hosts.address.try_emplace(std::string(name.str()));
  for (const std::string& assignment : overrides)
    if (assignment.starts_with(kSection))
      e.hosts.address.try_emplace(assignment.substr(kSection.size(), assignment.find('=') - kSection.size()));
}

// So do the programs of the lab's own: every [nodes.NAME] with a command.
void name_own_programs(const std::vector<toml::table>& tables, const std::vector<std::string>& overrides,
                       Experiment& e) {
  constexpr std::string_view kSection = "nodes.", kKey = ".command";
  for (const toml::table& table : tables)
    if (const toml::table* const nodes = table["nodes"].as_table())
      for (const auto& [name, node] : *nodes)
        if (const toml::table* const keys = node.as_table(); keys && keys->contains("command"))
          e.own_programs.try_emplace(std::string(name.str()));
  for (const std::string& assignment : overrides) {
    const std::string key = assignment.substr(0, assignment.find('='));
    if (key.starts_with(kSection) && key.ends_with(kKey) && key.size() > kSection.size() + kKey.size())
      e.own_programs.try_emplace(key.substr(kSection.size(), key.size() - kSection.size() - kKey.size()));
  }
}

Experiment parse_onto(Experiment experiment,
                      const std::vector<std::pair<std::string, std::string>>& named_texts,
                      const std::vector<std::string>& overrides, std::vector<ConfigError>* mistakes = nullptr,
                      bool recorded = false, bool whole = true, MetaReader* told_meta = nullptr) {
  std::vector<toml::table> tables;
  for (const auto& [file, text] : named_texts) tables.push_back(parse_text(text, file));
  name_hosts(tables, overrides, experiment);
  name_own_programs(tables, overrides, experiment);
  MetaReader own_meta;
  MetaReader& meta = told_meta ? *told_meta : own_meta;
  Reader reader(firn::fields(experiment), mistakes, recorded, &meta);
  bool first = true;
  for (std::size_t n = 0; n < tables.size(); ++n) {
    const std::string& file = named_texts[n].first;
    const toml::table& table = tables[n];
    if (const toml::node* include = table.get("include"); include && first)
      throw ConfigError(
          file, int(include->source().begin.line), "include",
          "include = " + shown(*include) + ": the included text was not handed in before this one");
    first = false;
    reader.check_kind_of_file(table, file);
    reader.read(table, file);
    reader.paths_from(file, std::filesystem::path(named_texts.back().first).parent_path());
  }
  reader.override_with(overrides);
  const std::string file = named_texts.empty() ? "(defaults)" : named_texts.back().first;
  const auto check_meta = [&] {
    meta.finish();
    const auto named = reader.origins().find("run.name");
    const Origin place = named == reader.origins().end() ? Origin{file, 0} : named->second;
    experiment.run.name = meta.expand(experiment.run.name, place.file, place.line);
  };
  if (!mistakes) {
    check_meta();
    check_kind(reader, experiment);
    check_experiment(experiment, reader.origins(), file, whole);
    return experiment;
  }
  // The rules between keys are not asked about values that are no good in themselves.
  if (mistakes->empty()) try {
      check_meta();
      check_kind(reader, experiment);
      check_experiment(experiment, reader.origins(), file, whole, mistakes);
    } catch (const ConfigError& e) {
      mistakes->push_back(e);
    }
  return experiment;
}

}  // namespace

Experiment parse_experiment(const std::vector<std::pair<std::string, std::string>>& named_texts,
                            const std::vector<std::string>& overrides) {
  return parse_onto({}, named_texts, overrides);
}

Experiment parse_experiment(const std::vector<std::pair<std::string, std::string>>& named_texts,
                            const std::vector<std::string>& overrides, LabUse use) {
  return parse_onto({}, named_texts, overrides, nullptr, false, use == LabUse::kWhole);
}

PrintMeta parse_meta(const std::vector<std::pair<std::string, std::string>>& named_texts,
                     const std::vector<std::string>& overrides) {
  MetaReader meta;
  parse_onto({}, named_texts, overrides, nullptr, false, true, &meta);
  return meta.finish();
}

std::vector<ConfigError> mistakes_of(const std::vector<std::pair<std::string, std::string>>& named_texts,
                                     const std::vector<std::string>& overrides) {
  std::vector<ConfigError> mistakes;
  try {
    parse_onto({}, named_texts, overrides, &mistakes);
  } catch (const ConfigError& e) {  // a text that is no TOML
    mistakes.push_back(e);
  }
  // A file is read section by section in the order of their names.
  for (auto from = mistakes.begin(); from != mistakes.end();) {
    const auto to =
        std::find_if(from, mistakes.end(), [&](const ConfigError& e) { return e.file != from->file; });
    std::stable_sort(from, to, [](const ConfigError& a, const ConfigError& b) { return a.line < b.line; });
    from = to;
  }
  return mistakes;
}

Experiment parse_experiment(const std::string& toml_text, const std::string& file_name) {
  return parse_onto({}, {{file_name, toml_text}}, {}, nullptr, true);
}

Experiment parse_recorded_experiment(const std::string& toml_text, const std::string& file_name,
                                     const std::vector<std::string>& overrides) {
  // Every node of a print is made from the same text, one after the other.
  struct Last {
    std::string text;
    std::optional<Experiment> experiment;
  };
  thread_local Last last;
  if (overrides.empty() && last.experiment && last.text == toml_text) return *last.experiment;
  // It was checked as it was to be used when it was recorded.
  Experiment e = parse_onto({}, {{file_name, toml_text}}, overrides, nullptr, true, false);
  if (overrides.empty()) last = {toml_text, e};
  return e;
}

}  // namespace firn
