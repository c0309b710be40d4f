#include "report/study/study_profile.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "report/draw/charts.h"
#include "report/draw/svg.h"
#include "report/study/form.h"

namespace firn::report {
namespace {

std::string quoted(const std::string& text) {
  std::string s = "\"";
  for (const char c : text) s += c == '"' ? std::string("\"\"") : std::string(1, c);
  return s + "\"";
}

std::vector<ProfileRow> of_part(const std::vector<ProfileRow>& rows, std::size_t part) {
  std::vector<ProfileRow> out;
  for (const ProfileRow& r : rows)
    if (r.part == part) out.push_back(r);
  return out;
}

}  // namespace

std::vector<ProfileRow> profile_rows(const StudyTable& t) {
  std::vector<ProfileRow> rows;
  for (std::size_t part = 0; part < t.parts.size(); ++part)
    for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
      std::map<double, std::vector<double>> at;
      for (std::size_t seed = 0; seed < t.seeds.size(); ++seed)
        for (const StudyProfilePoint& p : t.run(arm, part, seed).profile)
          if (std::isfinite(p.y)) at[p.x].push_back(p.y);
      for (const auto& [x, y] : at) {
        const auto [least, largest] = std::minmax_element(y.begin(), y.end());
        rows.push_back({arm, part, x, y.size(), statistics::mean(y), statistics::bootstrap_interval(y),
                        *least, *largest});
      }
    }
  return rows;
}

std::string profile_csv(const StudyTable& t, const std::vector<ProfileRow>& rows) {
  std::string s =
      "scheme,part," + t.profile.x_name + ",seeds,mean_" + t.profile.y_name + ",low,high,least,largest\n";
  for (const ProfileRow& r : rows) {
    s += quoted(t.arms[r.arm]) + "," + quoted(t.parts[r.part]) + form(",%.6g,%zu,%.6g", r.x, r.seeds, r.mean);
    s += std::isfinite(r.interval.low) ? form(",%.6g,%.6g", r.interval.low, r.interval.high)
                                       : std::string(",,");
    s += form(",%.6g,%.6g\n", r.least, r.largest);
  }
  return s;
}

std::string profile_text(const StudyTable& t, const std::vector<ProfileRow>& rows) {
  std::string s;
  for (std::size_t part = 0; part < t.parts.size(); ++part) {
    const std::vector<ProfileRow> here = of_part(rows, part);
    if (here.empty()) continue;
    s += "\n" + t.profile.y_name + " against " + t.profile.x_name +
         (t.parts[part].empty() ? "" : ", " + t.parts[part]) +
         ": mean [95 % interval] largest of all seeds (n: of so many, the others had stopped)\n" +
         form("%9s", t.profile.x_name.c_str());
    for (const std::string& arm : t.arms) s += form("   %-29s", std::string(shortened(arm, 29)).c_str());
    s += "\n";
    std::map<double, std::vector<std::string>> lines;
    for (const ProfileRow& r : here) {
      std::vector<std::string>& line = lines[r.x];
      line.resize(t.arms.size(), "-");
      const std::string of = r.seeds < t.seeds.size() ? form(" (%zu)", r.seeds) : "";
      line[r.arm] = std::isfinite(r.interval.low)
                        ? form("%.1f [%.1f, %.1f] %.1f", r.mean, r.interval.low, r.interval.high, r.largest)
                        : form("%.1f", r.mean);
      line[r.arm] += of;
    }
    for (const auto& [x, line] : lines) {
      s += form("%9.2f", x);
      for (const std::string& cell : line) s += form("   %-29s", cell.c_str());
      s += "\n";
    }
  }
  return s;
}

std::string profile_section(const StudyTable& t, const std::vector<ProfileRow>& rows) {
  if (rows.empty()) return "";
  std::string s =
      "<h2>" + escape_html(t.profile.title) +
      "</h2>\n<p class=\"soft\">Mean over the seeds, with its 95 % interval where there are several; "
      "profile.csv has the figures and the largest of all seeds.</p>\n<div class=\"row\">\n";
  for (std::size_t part = 0; part < t.parts.size(); ++part) {
    std::vector<Series> lines;
    for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
      Series line;
      line.label = t.arms[arm];
      line.style = int(arm);
      line.marks = true;
      for (const ProfileRow& r : rows) {
        if (r.part != part || r.arm != arm) continue;
        line.x.push_back(r.x);
        line.y.push_back(r.mean);
        line.low.push_back(r.interval.low);
        line.high.push_back(r.interval.high);
      }
      if (!line.x.empty()) lines.push_back(std::move(line));
    }
    if (lines.empty()) continue;
    double least = INFINITY, largest = 0.0;
    for (const Series& l : lines)
      for (const double v : l.y) {
        least = std::min(least, v);
        largest = std::max(largest, v);
      }
    ChartOptions o;
    o.title = t.profile.title;
    o.x_name = t.profile.x_name;
    o.y_name = t.profile.y_name;
    o.from_zero = true;
    s += "<figure><figcaption><b>" + escape_html(t.parts[part]) + "</b></figcaption>\n" +
         line_chart(lines, o) + "</figure>\n";
    if (!(largest > 4.0 * least)) continue;  // small values need another axis
    o.from_zero = false;
    o.logarithmic = true;
    s += "<figure><figcaption>the same, logarithmic</figcaption>\n" + line_chart(lines, o) + "</figure>\n";
  }
  return s + "</div>\n";
}

}  // namespace firn::report
