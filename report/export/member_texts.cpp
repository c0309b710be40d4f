#include "report/export/member_texts.h"

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "files/trimmed.h"
#include "lcmtypes/schema.h"

namespace firn::tables {
namespace {

struct Texts {
  std::map<std::string, std::string, std::less<>> types;    // "grid_t"
  std::map<std::string, std::string, std::less<>> members;  // "grid_t.nx": the whole comment
  std::map<std::string, std::string, std::less<>> enums;    // "PlanDecision": its values
};

void append(std::string& to, std::string_view words) { to += (to.empty() ? "" : " ") + std::string(words); }

// "enum Name {kA = 0, kB = 1} of core/x.h": the values belong to the name wherever it is used.
void keep_enum(std::string_view comment, Texts& texts) {
  for (const std::string_view word : {"enum ", "bits "}) {
    const std::size_t at = comment.find(word), open = comment.find('{', at), close = comment.find('}', open);
    if (at == comment.npos || close == comment.npos) continue;
    const std::string_view name = trimmed(comment.substr(at + word.size(), open - at - word.size()));
    texts.enums.emplace(name, comment.substr(open + 1, close - open - 1));
  }
}

Texts read_texts() {
  Texts texts;
  std::string_view rest = lcm_type_texts();
  std::string type, member, above;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::size_t slashes = line.find("//");
    const std::string_view code = trimmed(line.substr(0, std::min(slashes, line.size())));
    const std::string_view comment =
        slashes == line.npos ? std::string_view() : trimmed(line.substr(slashes + 2));
    if (code.starts_with("struct ")) {
      type = trimmed(code.substr(7, code.find('{') - 7));
      texts.types[type] = std::exchange(above, "");
      member.clear();
    } else if (code.starts_with("}")) {
      type.clear();
    } else if (type.empty()) {
      if (!comment.empty()) append(above, comment);
    } else if (!code.empty()) {
      const std::size_t space = code.find(' ');
      const std::string_view name = trimmed(code.substr(std::min(space, code.size())));
      member = type + "." + std::string(name.substr(0, name.find_first_of("[;")));
      texts.members[member] = comment;
    } else if (!member.empty()) {
      append(texts.members[member], comment);
    }
  }
  for (const auto& [name, comment] : texts.members) keep_enum(comment, texts);
  return texts;
}

const Texts& texts() {
  static const Texts all = read_texts();
  return all;
}

bool is_range(std::string_view clause) {
  return (clause.starts_with('[') || clause.starts_with('(')) && clause.find(',') != clause.npos;
}

bool is_clause(std::string_view clause) {
  for (const char* begin : {"[", "(", "= ", "< ", "<= ", "enum ", "bits ", "."})
    if (clause.starts_with(begin)) return true;
  return false;
}

}  // namespace

MemberText member_text(std::string_view type, std::string_view member) {
  MemberText found;
  const auto it = texts().members.find(std::string(type) + "." + std::string(member));
  if (it == texts().members.end()) return found;
  std::string_view rest = it->second;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string_view clause = trimmed(rest.substr(0, end));
    if (!is_clause(clause)) {  // clauses come first
      found.text = trimmed(rest);
      break;
    }
    if (is_range(clause) && found.range.empty()) found.range = clause;
    if (clause.starts_with("enum ") || clause.starts_with("bits ")) {
      const std::string_view name = trimmed(clause.substr(5, clause.find_first_of("{", 5) - 5));
      if (const auto values = texts().enums.find(name); values != texts().enums.end())
        found.values = values->second;
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return found;
}

std::string type_text(std::string_view type) {
  const auto it = texts().types.find(type);
  return it == texts().types.end() ? "" : it->second;
}

std::string unit_of(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 24> kUnits{{
      {"_mm3_s", "mm^3/s"}, {"_mm_s3", "mm/s^3"}, {"_mm_s2", "mm/s^2"}, {"_mm_s", "mm/s"},   {"_mm3", "mm^3"},
      {"_mm2", "mm^2"},     {"_mm", "mm"},        {"_um", "um"},        {"_us", "us"},       {"_ns", "ns"},
      {"_ms", "ms"},        {"_s", "s"},          {"_hz", "Hz"},        {"_rad_s", "rad/s"}, {"_rad", "rad"},
      {"_deg_s", "deg/s"},  {"_deg", "deg"},      {"_degc", "degC"},    {"_c", "degC"},      {"_w", "W"},
      {"_v", "V"},          {"_pct", "%"},        {"_bytes", "byte"},   {"_pa", "Pa"},
  }};
  std::string_view best, unit = "1";
  for (const auto& [ending, means] : kUnits)
    if (name.ends_with(ending) && ending.size() > best.size()) {
      best = ending;
      unit = means;
    }
  return std::string(unit);
}

}  // namespace firn::tables
