#include "report/run/settings_table.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string_view>

#include "report/draw/svg.h"

namespace firn::report {
namespace {

constexpr std::size_t kShownSettings = 12;  // rows: as many as are read at a glance

// Settings that a reader asks for first.
bool says_what_was_printed(const DifferingParameter& p) {
  constexpr std::string_view kFirst[] = {"lab.", "part.", "control.scheme"};
  return std::ranges::any_of(kFirst, [&](std::string_view start) { return p.key.starts_with(start); });
}

std::string table_of(std::span<const DifferingParameter> parameters, const std::vector<std::string>& names) {
  std::string s = "<div class=\"scroll\"><table><thead>\n<tr><th>setting</th>";
  for (const std::string& n : names) s += "<th>" + escape_html(n) + "</th>";
  s += "</tr>\n</thead><tbody>\n";
  for (const DifferingParameter& p : parameters) {
    s += "<tr><td><code>" + escape_html(p.key) + "</code>" +
         (p.unit.empty() ? "" : " [" + escape_html(p.unit) + "]") + "</td>";
    for (const std::string& v : p.values) s += "<td>" + escape_html(v) + "</td>";
    s += "</tr>\n";
  }
  return s + "</tbody></table></div>\n";
}

}  // namespace

std::string settings_table(const std::vector<DifferingParameter>& parameters,
                           const std::vector<std::string>& names) {
  if (parameters.size() <= kShownSettings) return table_of(parameters, names);
  std::vector<DifferingParameter> all = parameters;
  std::stable_partition(all.begin(), all.end(), says_what_was_printed);  // clang 14 has none of std::ranges
  const std::span<const DifferingParameter> rows = all;
  return table_of(rows.first(kShownSettings), names) + "<details><summary>" +
         std::to_string(rows.size() - kShownSettings) + " more settings that differ</summary>\n" +
         table_of(rows.subspan(kShownSettings), names) + "</details>\n";
}

}  // namespace firn::report
