#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/options/enumerators.h"
#include "files/json.h"
#include "studies/reproduce/reproduce.h"

namespace firn {
namespace {

static_assert(std::size(kVerdicts) == kTableSize<Verdict>);
static_assert(std::size(kRowKinds) == kTableSize<RowKind>);

using Json = nlohmann::ordered_json;

Json json_of(const RowValue& value) {
  if (const auto* number = std::get_if<double>(&value))
    return std::isfinite(*number) ? Json(*number) : Json(nullptr);
  const std::string& words = std::get<std::string>(value);
  return words.empty() ? Json(nullptr) : Json(words);
}

Json words_of(std::string_view words) { return words.empty() ? Json(nullptr) : Json(words); }

Json json_of(const VerdictCounts& c) {
  Json counts = {{"rows", c.rows}};
  for (const Verdict v : kVerdicts) counts[std::string(name(v))] = c.of[std::size_t(v)];
  Json kinds = Json::object();
  for (const RowKind k : kRowKinds) kinds[std::string(name(k))] = c.reproduced_of[std::size_t(k)];
  counts["reproduced kinds"] = kinds;
  counts["fit"] = c.fitted;
  counts["unexpected"] = c.unexpected;
  return counts;
}

Json json_of(const ReproduceRow& row) {
  return {{"id", row.id},
          {"what", row.what},
          {"unit", row.unit},
          {"printed", json_of(row.printed.value)},
          {"printed_place", words_of(row.printed.place)},
          {"printed_quote", words_of(row.printed.quote)},
          {"derived", json_of(row.derived.value)},
          {"derived_by", words_of(row.derived.by)},
          {"derived_how", words_of(row.derived.how)},
          {"ours", json_of(row.ours)},
          {"decimals", row.decimals},
          {"tolerance", words_of(row.tolerance)},
          {"fit", words_of(row.fit)},
          {"kind", name(row.kind())},
          {"verdict", name(row.verdict())},
          {"reason", words_of(row.reason())},
          {"unexpected", row.fails()}};
}

// Columns of terminal cells; counts code points, not bytes.
std::size_t width(const std::string& text) {
  std::size_t n = 0;
  for (unsigned char c : text) n += (c & 0xC0) != 0x80;
  return n;
}

std::string in_brackets(std::string text, const std::string& source) {
  return source.empty() ? text : text + " (" + source + ")";
}

std::string aligned(const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::size_t> widths(lines.empty() ? 0 : lines[0].size(), 0);
  for (const auto& line : lines)
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], width(line[c]));
  std::string table;
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c)
      table += line[c] + (c + 1 < line.size() ? std::string(widths[c] - width(line[c]) + 2, ' ') : "");
    table += "\n";
  }
  return table;
}

std::string reasons(const std::vector<PartResult>& results, Verdict verdict) {
  std::vector<std::pair<std::string, std::string>> by_reason;  // in the order of the rows
  for (const PartResult& part : results)
    for (const ReproduceRow& row : part.rows) {
      if (row.verdict() != verdict) continue;
      const std::string why(row.fails() ? "UNEXPECTED" : row.reason());
      const auto known = std::ranges::find(by_reason, why, &std::pair<std::string, std::string>::first);
      if (known == by_reason.end())
        by_reason.emplace_back(why, row.id);
      else
        known->second += ", " + row.id;
    }
  std::string text;
  for (const auto& [why, ids] : by_reason) text += "  " + why + ": " + ids + "\n";
  return text.empty() ? text : "\n" + std::string(name(verdict)) + ":\n" + text;
}

}  // namespace

VerdictCounts count_verdicts(const std::vector<PartResult>& results, std::string_view paper) {
  VerdictCounts counts;
  for (const PartResult& part : results) {
    if (!paper.empty() && paper != part.part.paper) continue;
    for (const ReproduceRow& row : part.rows) {
      ++counts.rows;
      ++counts.of[std::size_t(row.verdict())];
      if (row.verdict() == Verdict::kReproduced) ++counts.reproduced_of[std::size_t(row.kind())];
      counts.fitted += !row.fit.empty();
      counts.unexpected += row.fails();
    }
  }
  return counts;
}

bool all_pass(const std::vector<PartResult>& results) {
  return std::ranges::all_of(results, [](const PartResult& part) {
    return part.error.empty() && std::ranges::none_of(part.rows, &ReproduceRow::fails);
  });
}

std::string reproduce_table(const std::vector<PartResult>& results) {
  std::vector<std::vector<std::string>> lines{{"id", "what", "printed", "derived", "ours",
                                               "tolerance, or threshold of a wording", "kind", "verdict"}},
      beside;
  std::string errors;
  for (const PartResult& part : results) {
    for (const ReproduceRow& row : part.rows)
      lines.push_back({row.id, row.what,
                       in_brackets(text_of(row.printed.value, row.decimals, row.unit), row.printed.place),
                       in_brackets(text_of(row.derived.value, row.decimals, row.unit), row.derived.by),
                       text_of(row.ours, row.decimals, row.unit), row.tolerance.empty() ? "-" : row.tolerance,
                       std::string(name(row.kind())),
                       std::string(name(row.verdict())) + (row.fit.empty() ? "" : ", FIT") +
                           (row.fails() ? ", UNEXPECTED" : "")});
    for (const BesideRow& row : part.beside)
      beside.push_back({"  " + row.id, row.what, text_of(row.value, row.decimals, row.unit)});
    if (!part.error.empty())
      errors += fmt::format("{}.{} could not be computed: {}\n", part.part.paper, part.part.name, part.error);
  }
  const VerdictCounts counts = count_verdicts(results);
  std::string text = aligned(lines) + reasons(results, Verdict::kNotIdentifiable) +
                     reasons(results, Verdict::kNotReproduced);
  if (!beside.empty()) text += "\nbeside the papers, no verdict:\n" + aligned(beside);
  text += fmt::format("\n{} rows:", counts.rows);
  for (const Verdict v : kVerdicts)
    text += fmt::format("{} {} {}", v == kVerdicts[0] ? "" : ",", counts.of[std::size_t(v)], name(v));
  return text + fmt::format("; {} are FIT, {} unexpected\n", counts.fitted, counts.unexpected) +
         "of the reproduced: " + kinds_in_words(counts) + "\n" + errors;
}

std::string kinds_in_words(const VerdictCounts& counts) {
  std::string text;
  for (const RowKind k : kRowKinds)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts.reproduced_of[std::size_t(k)], name(k));
  return text;
}

std::string reproduce_json(const std::vector<PartResult>& results) {
  Json rows = Json::array(), beside = Json::array(), errors = Json::array(), counts = Json::object();
  for (const PartResult& part : results) {
    for (const ReproduceRow& row : part.rows) rows.push_back(json_of(row));
    for (const BesideRow& row : part.beside)
      beside.push_back(
          {{"id", row.id}, {"what", row.what}, {"unit", row.unit}, {"ours", json_of(row.value)}});
    if (!part.error.empty())
      errors.push_back(
          {{"part", fmt::format("{}.{}", part.part.paper, part.part.name)}, {"error", part.error}});
    counts[part.part.paper] = json_of(count_verdicts(results, part.part.paper));
  }
  counts["all"] = json_of(count_verdicts(results));
  return Json{{"counts", counts}, {"rows", rows}, {"beside", beside}, {"errors", errors}}.dump(2);
}

}  // namespace firn
