#include "config/field_texts.h"

#include <algorithm>

#include "config/error.h"
#include "config/field_rules.h"

namespace firn {
namespace {

// A long list in several lines, since a line is read up to a limit (config/text_limits.h).
std::string in_lines(const Field& f) {
  constexpr std::size_t kOneLine = 1900, kLine = 100;
  const std::string text = value_text(f);
  if (text.size() <= kOneLine || !std::holds_alternative<std::vector<double>*>(f.value)) return text;
  std::string out;
  std::size_t from = 0;
  for (std::size_t comma; (comma = text.find(", ", from + kLine)) != std::string::npos; from = comma + 2)
    out += text.substr(from, comma + 1 - from) + "\n  ";
  return out + text.substr(from);
}

}  // namespace

std::string fields_toml(const std::vector<Field>& fields) {
  std::string out;
  std::string_view section;
  for (const Field& f : fields) {
    if (f.section() != section) {
      section = f.section();
      out += (out.empty() ? "[" : "\n[") + std::string(section) + "]\n";
    }
    out += std::string(f.name()) + " = " + in_lines(f) + "\n";
  }
  return out;
}

namespace {

/// Escapes the text of a table cell: '|' would end the cell.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

/// A row of the tables: keys; their default in each section, with its unit unless the name carries it
/// (pitch_x_mm); allowed values and meaning.
struct Row {
  std::string keys;
  std::vector<std::string> defaults;
  std::string rest;

  std::string default_text() const {
    std::string out;
    for (const std::string& d : defaults) out += (out.empty() ? "" : "; ") + d;
    return std::ranges::count(defaults, defaults[0]) == std::ssize(defaults) ? defaults[0] : out;
  }
};
Row row_of(const Field& f) {
  std::string ending = "_";
  for (const char c : f.unit)
    if (c != '^') ending += c == '/' ? '_' : c;
  const bool named = f.unit.empty() || f.name().ends_with(ending);
  return {std::string(f.name()),
          {cell(value_text(f)) + (named ? "" : " " + std::string(f.unit))},
          cell(limits_text(f)) + "|" + cell(f.meaning)};
}

struct Section {
  std::string heading;
  std::vector<Row> rows;
};
bool same_but_for_defaults(const Section& a, const Section& b) {
  return std::ranges::equal(a.rows, b.rows,
                            [](const Row& x, const Row& y) { return x.keys == y.keys && x.rest == y.rest; });
}

bool same_of_another_axis(const Field& a, const Field& b) {
  return a.section() == b.section() && value_text(a) == value_text(b) && limits_text(a) == limits_text(b) &&
         a.unit == b.unit && (a.meaning == b.meaning || b.meaning.starts_with("the same along "));
}

}  // namespace

std::string fields_markdown(const std::vector<Field>& fields) {
  std::vector<Section> sections;
  const Field* last = nullptr;  // the first field of the last row
  for (const Field& f : fields) {
    const std::string heading = "[" + std::string(f.section()) + "]";
    if (sections.empty() || sections.back().heading != heading) sections.push_back({heading, {}});
    if (last && same_of_another_axis(*last, f)) {
      sections.back().rows.back().keys += ", " + std::string(f.name());
      continue;
    }
    sections.back().rows.push_back(row_of(f));
    last = &f;
  }
  std::vector<Section> tables;
  for (const Section& s : sections) {
    if (tables.empty() || !same_but_for_defaults(tables.back(), s)) {
      tables.push_back(s);
      continue;
    }
    tables.back().heading += ", " + s.heading;
    for (std::size_t n = 0; n < s.rows.size(); ++n)
      tables.back().rows[n].defaults.push_back(s.rows[n].defaults[0]);
  }
  std::string out;
  for (const Section& s : tables) {
    out += "\n## " + s.heading + "\n\n|key|default|allowed|meaning|\n|-|-|-|-|\n";
    for (const Row& r : s.rows) out += "|" + r.keys + "|" + r.default_text() + "|" + r.rest + "|\n";
  }
  return out;
}

void FieldRules::require(bool ok, const std::string& key, const std::string& problem) const {
  if (ok) return;
  const auto field = std::find_if(table_.begin(), table_.end(), [&](const Field& f) { return f.key == key; });
  const auto origin = origins_.find(key);
  throw ConfigError(file_, origin == origins_.end() ? 0 : origin->second.line, key,
                    key + " = " + value_text(*field) + ": " + problem);
}

}  // namespace firn
