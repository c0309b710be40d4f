#include "files/separated_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/options/number.h"
#include "files/lowercase.h"
#include "files/trimmed.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kLookedAtLines = 32;  // enough to tell separators from decimal commas

bool is_missing(std::string_view s) {
  static constexpr std::string_view kMissing[] = {"",     "nan",  "-nan", "na", "n/a",
                                                  "#n/a", "null", "none", "-",  "--"};
  return s.size() < 5 && std::ranges::find(kMissing, lowercase(s)) != std::end(kMissing);
}

bool is_comment(std::string_view trimmed_line) {
  return trimmed_line.starts_with('#') || trimmed_line.starts_with('%');
}

/// Calls use(field, quoted) for each field of a line. Returns false if a quote has no end.
template <class Use>
bool for_each_field(std::string_view text, char separator, Use&& use) {
  if (separator == ' ') text = trimmed(text);
  std::string unquoted;
  for (std::size_t from = 0;;) {
    bool quotes = false, open = false;
    std::size_t end = from;
    for (; end < text.size() && (open || text[end] != separator); ++end)
      if (text[end] == '"') {
        quotes = true;
        open = !open;
      }
    if (open) return false;
    std::string_view field = trimmed(text.substr(from, end - from));
    if (quotes) {
      unquoted.clear();
      bool inside = false;
      for (std::size_t i = 0; i < field.size(); ++i) {
        if (field[i] != '"')
          unquoted += field[i];
        else if (inside && i + 1 < field.size() && field[i + 1] == '"')
          unquoted += field[++i];
        else
          inside = !inside;
      }
      field = trimmed(unquoted);
    }
    use(field);
    if (end >= text.size()) return true;
    from = end + 1;
    while (separator == ' ' && from < text.size() && text[from] == ' ') ++from;
  }
}

/// "1,5" and "15", not "1," and ",5": numbers between blanks in a file with decimal commas.
bool is_between_blanks(std::string_view field) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (field.empty() || !digit(field.back())) return false;
  if (field.front() == '+' || field.front() == '-') field.remove_prefix(1);
  if (field.empty() || !digit(field.front())) return false;
  std::string text(field);
  std::ranges::replace(text, ',', '.');
  return whole_number<double>(text).has_value();
}

bool all_between_blanks(std::string_view line) {
  std::size_t fields = 0;
  bool all = true;
  for_each_field(line, ' ', [&](std::string_view field) {
    ++fields;
    all = all && is_between_blanks(field);
  });
  return all && fields > 1;
}

bool holds(std::string_view line, char separator) {
  bool open = false;
  for (const char c : line) {
    if (c == '"') open = !open;
    if (c == separator && !open) return true;
  }
  return false;
}

char separator_of(const std::vector<std::string_view>& lines) {
  const auto in_all = [&](char c) {
    return !lines.empty() && std::ranges::all_of(lines, [&](std::string_view l) { return holds(l, c); });
  };
  const auto in_some = [&](char c) {
    return std::ranges::any_of(lines, [&](std::string_view l) { return holds(l, c); });
  };
  for (const char c : {'\t', ';'})
    if (in_all(c)) return c;
  // Behind the first line, which may name columns.
  const std::size_t first = lines.size() > 1 ? 1 : 0;
  const bool name_line = !lines.empty() && holds(lines[0], ' ') && !holds(lines[0], ',');
  if (!lines.empty() && (name_line || all_between_blanks(lines[0])) &&
      std::all_of(lines.begin() + std::ptrdiff_t(first), lines.end(), all_between_blanks))
    return ' ';
  for (const char c : {',', '\t', ';'})
    if (in_all(c)) return c;
  for (const char c : {'\t', ';', ',', ' '})
    if (in_some(c)) return c;
  return ',';
}

}  // namespace

SeparatedValues::SeparatedValues(std::istream& in, const std::string& name, std::size_t longest_bytes)
    : lines_(in, name, longest_bytes), name_(name) {
  look_ahead();
}

void SeparatedValues::fail(std::int64_t line, const std::string& problem) const {
  throw UsageError(name_ + ":" + std::to_string(line) + ": " + problem);
}

void SeparatedValues::look_ahead() {
  std::size_t rows = 0;
  char named = '\0';
  std::string_view text;
  while (rows < kLookedAtLines && lines_.next(text)) {
    const std::string_view line = trimmed(text);
    const std::string low = lines_.number() == 1 ? lowercase(line.substr(0, 7)) : std::string();
    const std::size_t sep = low.starts_with("\"sep=") ? 5 : low.starts_with("sep=") ? 4 : 0;
    if (sep > 0) {  // a separator that is blank itself was trimmed off
      named = line.size() > sep && line[sep] != '"' ? line[sep] : '\t';
      continue;
    }
    if (is_comment(line)) {
      if (rows == 0) comment_ = line.substr(std::min(line.find_first_not_of("#% "), line.size()));
      continue;
    }
    rows += !line.empty();
    ahead_.push_back({lines_.number(), std::string(text)});
  }
  std::vector<std::string_view> sample;
  for (const Line& line : ahead_)
    if (!trimmed(line.text).empty()) sample.push_back(trimmed(line.text));
  separator_ = named != '\0' ? named : separator_of(sample);
}

bool SeparatedValues::next(SeparatedRow& row) {
  Line kept;
  std::string_view text;
  if (!ahead_.empty()) {
    kept = std::move(ahead_.front());
    ahead_.pop_front();
    text = kept.text;
    row.line = kept.number;
  } else {
    do {
      if (!lines_.next(text)) return false;
    } while (is_comment(trimmed(text.substr(0, text.find_first_of("#%") + 1))));
    row.line = lines_.number();
  }
  split(text, row.fields, row.line);
  return true;
}

void SeparatedValues::split(std::string_view text, std::vector<std::string>& fields,
                            std::int64_t line) const {
  std::size_t count = 0;
  const bool ended = for_each_field(text, separator_, [&](std::string_view field) {
    // "X [mm]" between blanks is one name
    const bool unit = separator_ == ' ' && count > 0 && (field.starts_with('[') || field.starts_with('('));
    if (unit) {
      fields[count - 1].append(" ").append(field);
      return;
    }
    if (count == fields.size()) fields.emplace_back();
    fields[count++].assign(field);
  });
  if (!ended) fail(line, "a quote without end");
  if (count == 1 && fields[0].empty()) count = 0;
  fields.resize(count);
}

std::optional<SeparatedValues::Number> SeparatedValues::parsed(std::string_view field) const {
  if (separator_ != ',' && field.find(',') != field.npos) {
    if (field.find('.') != field.npos) return {};
    std::string text(field);
    text[text.find(',')] = '.';
    if (const auto value = whole_number<double>(text)) return Number{*value, ','};
    return {};
  }
  if (const auto value = whole_number<double>(field))
    return Number{*value, field.find('.') != field.npos ? '.' : '\0'};
  if (is_missing(field)) return Number{std::numeric_limits<double>::quiet_NaN(), '\0'};
  return {};
}

bool SeparatedValues::is_value(std::string_view field) const {
  if (parsed(field)) return true;
  if (field.starts_with('-') || field.starts_with('+')) field.remove_prefix(1);
  const std::string word = lowercase(field.substr(0, 10));
  return word == "inf" || word == "infinity";
}

double SeparatedValues::number(const SeparatedRow& row, std::size_t field, std::string_view column) {
  if (field >= row.fields.size()) return std::numeric_limits<double>::quiet_NaN();  // a short row
  const std::string& text = row.fields[field];
  const auto number = parsed(text);
  const auto problem = [&](const char* what) {
    fail(row.line, shown_text(column, 60) + " = " + shown_text(text) + ": " + what);
  };
  if (!number && text.find(',') != text.npos && text.find('.') != text.npos)
    problem("has a point and a comma; numbers are read without separators of thousands");
  if (!number) problem("is not a finite number");
  if (number->mark == '.' && point_line_ == 0) point_line_ = row.line;
  if (number->mark == ',' && comma_line_ == 0) comma_line_ = row.line;
  if (point_line_ != 0 && comma_line_ != 0)
    fail(row.line, shown_text(column, 60) + " = " + shown_text(text) + ": line " +
                       std::to_string(point_line_) + " has a decimal point, line " +
                       std::to_string(comma_line_) + " a decimal comma");
  return number->value;
}

double SeparatedValues::finite_number(const SeparatedRow& row, std::size_t field, std::string_view column) {
  const double value = number(row, field, column);
  if (std::isnan(value))
    fail(row.line, shown_text(column, 60) + " = " +
                       (field < row.fields.size() ? shown_text(row.fields[field]) : std::string()) +
                       ": is not a finite number");
  return value;
}

std::vector<std::string> SeparatedValues::commented_names() const {
  std::vector<std::string> names;
  if (comment_.empty()) return names;
  const std::string_view one[] = {comment_};
  for_each_field(comment_, separator_of({one[0]}),
                 [&](std::string_view field) { names.emplace_back(field); });
  return names;
}

}  // namespace firn
