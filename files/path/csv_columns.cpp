#include "files/path/csv_columns.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <string>
#include <utility>

namespace firn {
namespace {

using Quantity = CsvColumn::Quantity;

constexpr std::array<std::pair<std::string_view, double>, 5> kLengths{
    {{"mm", 1.0}, {"um", 1e-3}, {"cm", 10.0}, {"m", 1000.0}, {"in", 25.4}}};

std::string_view csv_trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '"'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

template <class Use>
void for_each_cell(std::string_view text, char separator, Use&& use) {
  for (std::size_t from = 0; from != text.npos;) {
    const std::size_t end = text.find(separator, from);
    use(csv_trimmed(text.substr(from, end == text.npos ? end : end - from)));
    from = end == text.npos ? end : end + 1;
  }
}

/// "x_mm", "X [mm]" and "x (mm)" as "x" and "mm".
std::pair<std::string, std::string> name_and_unit(std::string_view cell) {
  std::string name, unit;
  bool in_unit = false;
  for (const char c : cell) {
    if (c == ']' || c == ')') continue;
    if (!in_unit && (c == '_' || c == '[' || c == '(' || c == ' ')) {
      in_unit = true;
      continue;
    }
    if (c == '[' || c == '(' || c == ' ') continue;
    const char low = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    (in_unit ? unit : name) += low == '/' ? '_' : low;
  }
  return {name, unit};
}

std::optional<double> length_scale(std::string_view unit) {
  for (const auto& [known, scale] : kLengths)
    if (unit == known) return scale;
  return std::nullopt;
}

std::optional<CsvColumn> column(std::string_view cell) {
  const auto [name, unit] = name_and_unit(cell);
  const auto with = [&](Quantity quantity, std::optional<double> scale) -> std::optional<CsvColumn> {
    if (!scale) return std::nullopt;
    return CsvColumn{quantity, cell, *scale};
  };
  if (name == "x") return with(Quantity::kX, length_scale(unit));
  if (name == "y") return with(Quantity::kY, length_scale(unit));
  if (name == "z") return with(Quantity::kZ, length_scale(unit));
  if (name == "yaw") {
    if (unit == "deg") return with(Quantity::kYaw, 1.0);
    if (unit == "rad") return with(Quantity::kYaw, 180.0 / std::numbers::pi);
  }
  if (name == "speed" && unit.size() > 2) {
    const std::size_t per = unit.rfind('_');
    if (per == unit.npos) return std::nullopt;
    const auto scale = length_scale(std::string_view(unit).substr(0, per));
    if (scale && unit.substr(per) == "_s") return with(Quantity::kSpeed, scale);
    if (scale && unit.substr(per) == "_min") return with(Quantity::kSpeed, *scale / 60.0);
  }
  return std::nullopt;
}

}  // namespace

char csv_separator(std::string_view text) {
  for (const char c : {',', ';', '\t'})
    if (text.find(c) != text.npos) return c;
  return ',';
}

std::optional<std::vector<CsvColumn>> csv_columns(std::string_view text, char separator) {
  std::vector<CsvColumn> columns;
  bool known = true;
  for_each_cell(text, separator, [&](std::string_view cell) {
    const std::optional<CsvColumn> next = column(cell);
    known = known && next && std::none_of(columns.begin(), columns.end(), [&](const CsvColumn& c) {
              return c.quantity == next->quantity;
            });
    if (known) columns.push_back(*next);
  });
  const auto has = [&](Quantity q) {
    return std::any_of(columns.begin(), columns.end(), [&](const CsvColumn& c) { return c.quantity == q; });
  };
  if (!known || !has(Quantity::kX) || !has(Quantity::kY)) return std::nullopt;
  return columns;
}

bool csv_numbers(std::string_view text, char separator) {
  bool all = true;
  for_each_cell(text, separator, [&](std::string_view cell) {
    double value = 0.0;
    const char* const end = cell.data() + cell.size();
    const auto [last, error] = std::from_chars(cell.data(), end, value);
    all = all && error == std::errc() && last == end;
  });
  return all;
}

}  // namespace firn
