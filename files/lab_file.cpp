#include "files/lab_file.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "files/trimmed.h"

namespace firn {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string without_comment(const std::string& line) {
  bool quoted = false;
  for (std::size_t n = 0; n < line.size(); ++n) {
    if (line[n] == '"') quoted = !quoted;
    if (line[n] == '#' && !quoted) return line.substr(0, n);
  }
  return line;
}

std::string section_of(const std::string& line) {
  const std::string bare = without_comment(line);
  const std::string_view t = trimmed(bare);
  return t.size() > 2 && t.front() == '[' && t.back() == ']' && t[1] != '['
             ? std::string(trimmed(t.substr(1, t.size() - 2)))
             : "";
}

std::string key_of(const std::string& line) {
  const std::string t = without_comment(line);
  const auto equals = t.find('=');
  return equals == std::string::npos ? "" : std::string(trimmed(std::string_view(t).substr(0, equals)));
}

void put(std::vector<std::string>& lines, const LabKey& k) {
  const std::string row = k.key + " = " + k.value + (k.comment.empty() ? "" : "  # " + k.comment);
  const auto begin = std::find_if(lines.begin(), lines.end(),
                                  [&](const std::string& l) { return section_of(l) == k.section; });
  if (begin == lines.end()) {
    lines.insert(lines.end(), {"", "[" + k.section + "]", row});
    return;
  }
  auto end =
      std::find_if(begin + 1, lines.end(), [](const std::string& l) { return !section_of(l).empty(); });
  const auto at = std::find_if(begin + 1, end, [&](const std::string& l) { return key_of(l) == k.key; });
  if (at != end) {
    auto last = at;  // of an array
    for (int open = 0; last != end; ++last) {
      const std::string text = without_comment(*last);
      open += int(std::count(text.begin(), text.end(), '[') - std::count(text.begin(), text.end(), ']'));
      if (open <= 0) break;
    }
    *at = row;
    if (last != end) lines.erase(at + 1, last + 1);
    return;
  }
  while (end != begin + 1 && (trimmed(*(end - 1)).empty() || trimmed(*(end - 1)).front() == '#')) --end;
  lines.insert(end, row);
}

}  // namespace

std::string with_keys(const std::string& toml_text, const std::vector<LabKey>& keys) {
  std::vector<std::string> lines = lines_of(toml_text);
  for (const LabKey& k : keys) put(lines, k);
  std::string out;
  for (const std::string& l : lines) out += l + "\n";
  return out;
}

std::string changed_lines(const std::string& before, const std::string& after) {
  const std::vector<std::string> a = lines_of(before), b = lines_of(after);
  // common[i][j]: number of common lines, in order, of a from i and b from j.
  std::vector<std::vector<int>> common(a.size() + 1, std::vector<int>(b.size() + 1, 0));
  for (std::size_t i = a.size(); i-- > 0;)
    for (std::size_t j = b.size(); j-- > 0;)
      common[i][j] = a[i] == b[j] ? common[i + 1][j + 1] + 1 : std::max(common[i + 1][j], common[i][j + 1]);
  std::string out;
  for (std::size_t i = 0, j = 0; i < a.size() || j < b.size();) {
    if (i < a.size() && j < b.size() && a[i] == b[j]) {
      ++i;
      ++j;
    } else if (i < a.size() && (j == b.size() || common[i + 1][j] >= common[i][j + 1]))
      out += "- " + a[i++] + "\n";
    else
      out += "+ " + b[j++] + "\n";
  }
  return out;
}

}  // namespace firn
