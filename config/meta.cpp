#include "config/meta.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "config/devices.h"
#include "config/error.h"
#include "config/meta_reader.h"
#include "core/options/number.h"

namespace firn {
namespace {

const std::string kMetaOption = "--meta";
constexpr std::array<std::string_view, 6> kKnownMeta{"operator",  "project", "sample",
                                                     "substrate", "ink",     "batch"};
constexpr std::array<std::string_view, 5> kMetaTypes{"text", "number", "integer", "boolean", "date"};

std::string meta_in_quotes(const std::string& text) {
  std::string out = "\"";
  for (char c : text) out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + '"';
}

std::string meta_shown(const MetaValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text ? meta_in_quotes(*text) : meta_value_text(value);
}

bool is_date(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  const auto year = whole_number<int>(text.substr(0, 4), 1, 9999),
             month = whole_number<int>(text.substr(5, 2), 1, 12);
  if (!year || !month ||
      !std::ranges::all_of(text, [](char c) { return c == '-' || (c >= '0' && c <= '9'); }))
    return false;
  constexpr std::array kDays{31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool leap = (*year % 4 == 0 && *year % 100 != 0) || *year % 400 == 0;
  const int days = kDays[std::size_t(*month - 1)] + (*month == 2 && leap ? 1 : 0);
  return whole_number<int>(text.substr(8, 2), 1, days).has_value();
}

// "must ..." of a text, or empty.
std::string broken_meta_text(const std::string& text) {
  if (text.empty()) return "must not be empty";
  if (text.size() > kMaxMetaTextBytes)
    return "must have at most " + std::to_string(kMaxMetaTextBytes) + " bytes";
  for (unsigned char c : text)
    if (c < 0x20 || c == 0x7f) return "must not have control characters";
  return "";
}

bool is_plain_in_name(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '_' ||
         c == '-';
}

void check_meta_key(const std::string& section, const std::string& key, const std::string& file, int line) {
  if (!is_meta_key(key))
    throw ConfigError(file, line, section + "." + key.substr(0, 100),
                      section + "." + key.substr(0, 100) + ": a key has 1 to " +
                          std::to_string(kMaxMetaKeyBytes) +
                          " letters a to z, digits and '_', and begins with a letter");
}

}  // namespace

std::vector<std::string_view> known_meta_keys() { return {kKnownMeta.begin(), kKnownMeta.end()}; }

bool is_meta_key(std::string_view key) {
  return !key.empty() && key.size() <= kMaxMetaKeyBytes && key[0] >= 'a' && key[0] <= 'z' &&
         std::ranges::all_of(
             key, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; });
}

std::string meta_value_text(const MetaValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* boolean = std::get_if<bool>(&value)) return *boolean ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  std::array<char, 40> buffer;
  return {buffer.data(),
          std::to_chars(buffer.data(), buffer.data() + buffer.size(), std::get<double>(value)).ptr};
}

std::string meta_toml(const Meta& meta) {
  if (meta.empty()) return "";
  std::string text = "[meta]\n";
  for (const MetaEntry& e : meta) {
    std::string value = meta_shown(e.value);
    if (std::holds_alternative<double>(e.value) && value.find_first_of(".en") == value.npos) value += ".0";
    text += e.key + " = " + value + "\n";
  }
  return text;
}

void MetaReader::read(std::string_view section, const MetaNode& node, const std::string& file, int line) {
  const std::string name(section);
  if (!node.is_table) throw ConfigError(file, line, name, name + ": is a section of keys, not a value");
  for (const MetaNode& member : node.members) {
    check_meta_key(name, member.key, file, member.line);
    if (section == "lab.use") {
      limit(member, file);
      continue;
    }
    if (section == "lab.meta") {
      declare(member.key, member, file, member.line);
      continue;
    }
    if (!member.value)
      throw ConfigError(file, member.line, "meta." + member.key,
                        "meta." + member.key + ": must be a text, a number, true, false or a date");
    given_[member.key] = {*member.value, std::nullopt, file, member.line};
  }
  if (given_.size() > kMaxMetaKeys)
    throw ConfigError(file, line, name, name + ": has more than " + std::to_string(kMaxMetaKeys) + " keys");
}

void MetaReader::limit(const MetaNode& member, const std::string& file) {
  constexpr std::string_view kHours = "_h";
  constexpr double kMaxPercent = 100.0, kMaxLimit = 1e12;
  const std::string full = "lab.use." + member.key;
  const auto refuse = [&](const std::string& problem) {
    throw ConfigError(file, member.line, full, full + ": " + problem);
  };
  const bool of_instrument =
      member.key.ends_with(kHours) &&
      port_defaults(member.key.substr(0, member.key.size() - kHours.size())).has_value();
  if (!of_instrument && member.key != "batch_mm3" && member.key != "warn_percent")
    refuse("unknown; there are batch_mm3, warn_percent, and NODE_h of each instrument, such as lamp_h");
  double value = 0.0;
  if (member.value) {
    if (const auto* integer = std::get_if<std::int64_t>(&*member.value)) value = double(*integer);
    if (const auto* number = std::get_if<double>(&*member.value)) value = *number;
  }
  const double most = member.key == "warn_percent" ? kMaxPercent : kMaxLimit;
  if (!(value > 0.0 && value <= most)) refuse("must be a number above 0, at most " + meta_value_text(most));
  if (member.key == "warn_percent")
    warn_percent_ = value;
  else
    limits_[member.key] = value;
}

void MetaReader::declare(const std::string& key, const MetaNode& node, const std::string& file, int line) {
  const std::string full = "lab.meta." + key;
  const auto refuse = [&](const std::string& member, const std::string& problem) {
    throw ConfigError(file, line, full, full + (member.empty() ? "" : "." + member) + ": " + problem);
  };
  if (!node.is_table) refuse("", "must be a table, such as {type = \"text\", required = true}");
  Rule rule;
  rule.file = file;
  rule.line = line;
  for (const MetaNode& m : node.members) {
    const auto* text = m.value ? std::get_if<std::string>(&*m.value) : nullptr;
    const auto* boolean = m.value ? std::get_if<bool>(&*m.value) : nullptr;
    if (m.key == "type") {
      const auto at = std::ranges::find(kMetaTypes, text ? std::string_view(*text) : std::string_view());
      if (at == kMetaTypes.end()) refuse(m.key, "must be one of text, number, integer, boolean, date");
      rule.type = Type(at - kMetaTypes.begin());
    } else if (m.key == "required") {
      if (!boolean) refuse(m.key, "must be true or false");
      rule.required = *boolean;
    } else if (m.key == "meaning") {
      if (!text) refuse(m.key, "must be a text");
      rule.meaning = *text;
    } else if (m.key == "one_of") {
      const auto is_text = [](const MetaNode& word) {
        return word.value && std::holds_alternative<std::string>(*word.value);
      };
      if (!m.is_list || m.members.empty() || !std::ranges::all_of(m.members, is_text))
        refuse(m.key, "must be a list of texts");
      for (const MetaNode& word : m.members) rule.words.push_back(std::get<std::string>(*word.value));
    } else {
      refuse(m.key, "unknown; a declaration has type, required, one_of and meaning");
    }
  }
  if (!rule.words.empty() && rule.type != Type::kText) refuse("one_of", "is of texts, and type is another");
  rules_[key] = std::move(rule);
}

void MetaReader::override_with(const std::string& key, const MetaNode& written, const std::string& word) {
  check_meta_key("meta", key, kMetaOption, 0);
  given_[key] = {written.value.value_or(MetaValue(word)), word, kMetaOption, 0};
  if (given_.size() > kMaxMetaKeys)
    throw ConfigError(kMetaOption, 0, "meta",
                      "meta: has more than " + std::to_string(kMaxMetaKeys) + " keys");
}

MetaValue MetaReader::checked(const std::string& key, const Given& g) const {
  const auto refuse = [&](const std::string& problem) -> MetaValue {
    throw ConfigError(g.file, g.line, "meta." + key,
                      "meta." + key + " = " + meta_shown(g.value) + ": " + problem);
  };
  const auto found = rules_.find(key);
  const bool known = std::ranges::find(kKnownMeta, key) != kKnownMeta.end();
  MetaValue value = g.value;
  if (found != rules_.end() || known) {
    const Rule rule = found != rules_.end() ? found->second : Rule{};
    const std::string declared =
        found != rules_.end() ? ", as " + rule.file + ":" + std::to_string(rule.line) + " declares" : "";
    const auto* integer = std::get_if<std::int64_t>(&g.value);
    const auto* text = std::get_if<std::string>(&g.value);
    switch (rule.type) {
      case Type::kText:
        if (g.word) value = *g.word;
        if (!std::holds_alternative<std::string>(value))
          return refuse("must be a text, in quotes" + declared);
        if (!rule.words.empty() &&
            std::ranges::find(rule.words, std::get<std::string>(value)) == rule.words.end()) {
          std::string all;
          for (const std::string& w : rule.words) all += (all.empty() ? "" : ", ") + w;
          return refuse("must be one of " + all + declared);
        }
        break;
      case Type::kNumber:
        if (integer) value = double(*integer);
        if (!std::holds_alternative<double>(value)) return refuse("must be a number" + declared);
        break;
      case Type::kInteger:
        if (!integer) return refuse("must be an integer" + declared);
        break;
      case Type::kBoolean:
        if (!std::holds_alternative<bool>(g.value)) return refuse("must be true or false" + declared);
        break;
      case Type::kDate:
        if (!text || !is_date(*text)) return refuse("must be a date, such as 2026-11-30" + declared);
        break;
    }
  }
  if (const auto* number = std::get_if<double>(&value); number && !std::isfinite(*number))
    return refuse("must be finite");
  if (const auto* text = std::get_if<std::string>(&value))
    if (const std::string problem = broken_meta_text(*text); !problem.empty()) return refuse(problem);
  return value;
}

PrintMeta MetaReader::finish() const {
  PrintMeta meta;
  for (const auto& [key, given] : given_) meta.values.push_back({key, checked(key, given)});
  for (const auto& [key, rule] : rules_)
    if (rule.required && !given_.contains(key))
      meta.missing.push_back({key, rule.meaning, rule.file, rule.line});
  for (const auto& [key, limit] : limits_) meta.use.limits.push_back({key, limit});
  meta.use.warn_percent = warn_percent_;
  return meta;
}

std::string MetaReader::expand(const std::string& name, const std::string& file, int line) const {
  constexpr std::string_view kBegin = "{meta.";
  const auto refuse = [&](const std::string& problem) {
    throw ConfigError(file, line, "run.name", "run.name = " + meta_in_quotes(name) + ": " + problem);
  };
  std::string out;
  for (std::size_t at = 0; at < name.size();) {
    if (name.compare(at, kBegin.size(), kBegin) != 0) {
      out += name[at++];
      continue;
    }
    const std::size_t end = name.find('}', at);
    if (end == name.npos) refuse("'{meta.' without its '}'");
    const std::string key = name.substr(at + kBegin.size(), end - at - kBegin.size());
    const auto given = given_.find(key);
    if (given == given_.end()) refuse("meta." + key + " is not set; --meta " + key + "=VALUE sets it");
    const std::string value = meta_value_text(checked(key, given->second));
    const auto odd = std::ranges::find_if_not(value, is_plain_in_name);
    if (odd != value.end())
      refuse("meta." + key + " = " + meta_in_quotes(value) +
             " cannot be part of a folder's name: letters, digits, '.', '_' and '-' can");
    out += value;
    at = end + 1;
  }
  return out;
}

void require_meta(const PrintMeta& meta) {
  if (meta.missing.empty()) return;
  const MissingMeta& first = meta.missing.front();
  std::string all;
  for (const MissingMeta& m : meta.missing)
    all += (all.empty() ? "" : ", ") + m.key + (m.meaning.empty() ? "" : " (" + m.meaning + ")");
  throw ConfigError(first.file, first.line, "meta." + first.key,
                    "the lab requires " + all + ", and the experiment has none: --meta " + first.key +
                        "=VALUE, or [meta] of the experiment, gives it");
}

}  // namespace firn
