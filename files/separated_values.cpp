#include "files/separated_values.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "files/lowercase.h"
#include "files/trimmed.h"
#include "files/usage_error.h"

namespace firn {
namespace {

bool is_missing(std::string_view s) {
  static constexpr std::string_view kMissing[] = {"", "nan", "na", "n/a", "null", "none", "-"};
  return std::ranges::find(kMissing, lowercase(s)) != std::end(kMissing);
}

}  // namespace

SeparatedValues::SeparatedValues(std::string_view text, const std::string& name) : name_(name) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  std::size_t line = 0;
  while (!text.empty()) {
    ++line;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = trimmed(text.substr(0, end));
    if (row.starts_with('#') || row.empty()) {
      text.remove_prefix(std::min(end + 1, text.size()));
      continue;
    }
    row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (row.ends_with('\r')) row.remove_suffix(1);
    if (rows_.empty()) {
      const auto count = [&](char c) { return std::ranges::count(row, c); };
      separator_ = count('\t') > 0 ? '\t' : count(';') > 0 ? ';' : ',';
    }
    SeparatedRow& out = rows_.emplace_back();
    out.line = line;
    std::string field;
    bool quoted = false;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const char c = row[i];
      if (c == '"') {
        if (quoted && i + 1 < row.size() && row[i + 1] == '"')
          field += row[++i];
        else
          quoted = !quoted;
      } else if (c == separator_ && !quoted) {
        out.fields.emplace_back(trimmed(field));
        field.clear();
      } else {
        field += c;
      }
    }
    if (quoted) throw UsageError(name_ + ": line " + std::to_string(line) + ": a quote without end");
    out.fields.emplace_back(trimmed(field));
  }
}

std::optional<double> SeparatedValues::parsed(std::string_view field) const {
  if (is_missing(field)) return std::numeric_limits<double>::quiet_NaN();
  std::string text(field.starts_with('+') ? field.substr(1) : field);
  if (separator_ != ',') std::ranges::replace(text, ',', '.');
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return {};
  return value;
}

double SeparatedValues::number(const SeparatedRow& row, std::size_t field) const {
  if (field >= row.fields.size()) return std::numeric_limits<double>::quiet_NaN();  // a short row
  if (const auto value = parsed(row.fields[field])) return *value;
  throw UsageError(name_ + ": line " + std::to_string(row.line) + ": '" + row.fields[field].substr(0, 40) +
                   "' is not a number");
}

bool SeparatedValues::has_header() const {
  return !rows_.empty() &&
         std::ranges::any_of(rows_.front().fields, [&](const std::string& f) { return !parsed(f); });
}

}  // namespace firn
