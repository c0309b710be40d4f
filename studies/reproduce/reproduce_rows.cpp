#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "studies/reproduce/reproduce.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const RowValue& value) {
  if (const auto* number = std::get_if<double>(&value))
    return std::isfinite(*number) ? Json(*number) : Json(nullptr);
  const std::string& words = std::get<std::string>(value);
  return words.empty() ? Json(nullptr) : Json(words);
}

std::string verdict_of(const ReproduceRow& row) { return !row.pass ? "shown" : *row.pass ? "pass" : "FAIL"; }

// Columns of terminal cells; counts code points, not bytes.
std::size_t width(const std::string& text) {
  std::size_t n = 0;
  for (unsigned char c : text) n += (c & 0xC0) != 0x80;
  return n;
}

}  // namespace

std::string text_of(const RowValue& value, int decimals, const std::string& unit) {
  if (const auto* words = std::get_if<std::string>(&value)) return words->empty() ? "-" : *words;
  const double number = std::get<double>(value);
  std::string digits = std::isfinite(number) ? fmt::format("{:.{}f}", number, decimals) : "none";
  if (number != 0.0 && digits.find_first_of("123456789") == std::string::npos)
    digits = fmt::format("{:.1e}", number);
  return unit.empty() ? digits : digits + " " + unit;
}

std::string tolerance_of(const ReproduceRow& row) {
  const auto* bound = std::get_if<double>(&row.tolerance);
  return bound ? "+- " + fmt::format("{:g}", *bound) + (row.unit.empty() ? "" : " " + row.unit)
               : text_of(row.tolerance, row.decimals, "");
}

std::string_view name(RowKind kind) {
  switch (kind) {
    case RowKind::kComputed:
      return "computed";
    case RowKind::kFit:
      return "fit";
    case RowKind::kProperty:
      return "property";
    case RowKind::kMeasured:
      return "measured";
  }
  return "computed";
}

ReproduceRow row_near(std::string id, std::string what, std::string unit, double paper, double ours,
                      double tolerance, RowKind kind) {
  return {std::move(id), std::move(what),
          kind,          std::move(unit),
          paper,         ours,
          tolerance,     std::abs(ours - paper) <= tolerance};
}

ReproduceRow row_at_most(std::string id, std::string what, std::string unit, RowValue paper, double ours,
                         double bound, RowKind kind) {
  std::string limit = fmt::format("<= {:g}", bound) + (unit.empty() ? "" : " " + unit);
  return {std::move(id), std::move(what),  kind,         std::move(unit), std::move(paper),
          ours,          std::move(limit), ours <= bound};
}

ReproduceRow row_holds(std::string id, std::string what, std::string paper, std::string ours, bool holds,
                       RowKind kind) {
  return {std::move(id), std::move(what), kind, "", std::move(paper), std::move(ours), "must hold", holds};
}

ReproduceRow row_informative(std::string id, std::string what, std::string unit, RowValue paper,
                             RowValue ours, RowKind kind) {
  return {std::move(id),    std::move(what), kind,          std::move(unit),
          std::move(paper), std::move(ours), std::string(), std::nullopt};
}

bool all_pass(const std::vector<PartResult>& results) {
  for (const PartResult& part : results)
    for (const ReproduceRow& row : part.rows)
      if (row.pass && !*row.pass) return false;
  return true;
}

std::string reproduce_table(const std::vector<PartResult>& results) {
  std::vector<std::vector<std::string>> lines{{"id", "what", "kind", "paper", "ours", "tolerance", ""}};
  for (const PartResult& part : results)
    for (const ReproduceRow& row : part.rows)
      lines.push_back({row.id, row.what, std::string(name(row.kind)),
                       text_of(row.paper, row.decimals, row.unit), text_of(row.ours, row.decimals, row.unit),
                       tolerance_of(row), verdict_of(row)});
  std::vector<std::size_t> widths(lines[0].size(), 0);
  for (const auto& line : lines)
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], width(line[c]));
  std::string table;
  for (const auto& line : lines) {
    std::string row;
    for (std::size_t c = 0; c < line.size(); ++c)
      row += line[c] + (c + 1 < line.size() ? std::string(widths[c] - width(line[c]) + 2, ' ') : "");
    table += row + "\n";
  }
  return table;
}

std::string reproduce_json(const std::vector<PartResult>& results) {
  Json rows = Json::array();
  for (const PartResult& part : results)
    for (const ReproduceRow& row : part.rows)
      rows.push_back({{"id", row.id},
                      {"what", row.what},
                      {"kind", name(row.kind)},
                      {"unit", row.unit},
                      {"paper", json_of(row.paper)},
                      {"ours", json_of(row.ours)},
                      {"tolerance", json_of(row.tolerance)},
                      {"pass", row.pass ? Json(*row.pass) : Json(nullptr)}});
  return rows.dump(2);
}

}  // namespace firn
