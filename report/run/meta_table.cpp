#include "report/run/meta_table.h"

#include <algorithm>
#include <set>

#include "report/draw/svg.h"
#include "runs/folder/verdict.h"

namespace firn::report {
namespace {

// Keys that every lab knows come first, in their own order.
std::vector<std::string> meta_keys(const std::vector<ReportRun>& runs) {
  std::set<std::string> own;
  for (const ReportRun& r : runs)
    for (const MetaEntry& e : r.data.meta.values) own.insert(e.key);
  std::vector<std::string> keys;
  for (const std::string_view known : known_meta_keys())
    if (own.erase(std::string(known)) > 0) keys.emplace_back(known);
  keys.insert(keys.end(), own.begin(), own.end());
  return keys;
}

std::string tag_words(const runs::RunNotes& notes) {
  std::string text;
  for (const std::string& tag : notes.tags()) text += (text.empty() ? "" : ", ") + tag;
  return text;
}

std::string used_words(const ReportRun& r) {
  const auto& result = r.data.result;
  return result && result->use ? runs::use_words(*result->use, r.data.words) : "";
}

std::string note_list(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  std::string s;
  for (std::size_t n = 0; n < runs.size(); ++n)
    for (const runs::NoteEntry& note : runs[n].data.notes.notes()) {
      const std::string who = note.author + (note.time_utc.empty() ? "" : ", " + note.time_utc);
      s += "<li>" + (runs.size() > 1 ? "<b>" + escape_html(names[n]) + "</b>: " : std::string()) +
           escape_html(note.text) +
           (who.empty() ? "" : " <span class=\"soft\">" + escape_html(who) + "</span>") + "</li>\n";
    }
  for (std::size_t n = 0; n < runs.size(); ++n)
    for (const runs::NoteEntry& seen : runs[n].data.notes.acknowledged())
      s += "<li>" + (runs.size() > 1 ? "<b>" + escape_html(names[n]) + "</b>: " : std::string()) +
           "alarm at " + escape_html(seen.text) + " <span class=\"soft\">acknowledged by " +
           escape_html(seen.author) + ", " + escape_html(seen.time_utc) + "</span></li>\n";
  return s.empty() ? "" : "<h3>Notes</h3>\n<ul>\n" + s + "</ul>\n";
}

}  // namespace

std::string meta_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  const std::vector<std::string> keys = meta_keys(runs);
  const bool tagged =
      std::ranges::any_of(runs, [](const ReportRun& r) { return !r.data.notes.tags().empty(); });
  const bool used = std::ranges::any_of(runs, [](const ReportRun& r) { return !used_words(r).empty(); });
  const std::string notes = note_list(runs, names);
  if (keys.empty() && !tagged && !used && notes.empty()) return "";
  std::string s = "<h2>What was printed</h2>\n";
  if (!keys.empty() || tagged || used) {
    std::vector<std::string> head{""};
    for (const std::string& n : names) head.push_back(escape_html(n));
    s +=
        "<div class=\"scroll\"><table class=\"text\"><thead>\n" + table_row(head, "th") + "</thead><tbody>\n";
    for (const std::string& key : keys) {
      std::vector<std::string> cells{escape_html(key)};
      for (const ReportRun& r : runs) cells.push_back(escape_html(runs::meta_text(r.data.meta.values, key)));
      s += table_row(cells);
    }
    if (tagged) {
      std::vector<std::string> cells{"tags"};
      for (const ReportRun& r : runs) cells.push_back(escape_html(tag_words(r.data.notes)));
      s += table_row(cells);
    }
    if (used) {
      std::vector<std::string> cells{"used"};
      for (const ReportRun& r : runs) cells.push_back(escape_html(used_words(r)));
      s += table_row(cells);
    }
    s += "</tbody></table></div>\n";
  }
  return s + notes;
}

}  // namespace firn::report
