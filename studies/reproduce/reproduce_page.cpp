#include <fmt/format.h>

#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/report_page.h"
#include "runtime/build_info.h"
#include "studies/reproduce/reproduce.h"

namespace firn {
namespace {

using report::escape_html;

std::string cell(const std::string& text, const std::string& below) {
  std::string s = "<td>" + escape_html(text);
  if (!below.empty()) s += "<br><span class=\"soft\">" + escape_html(below) + "</span>";
  return s + "</td>";
}

std::string printed_cell(const ReproduceRow& row) {
  std::string source = row.printed.place;
  if (!row.printed.quote.empty())
    source += ": \"" + row.printed.quote + "\"";
  else if (!source.empty())
    source += ", read off";
  return cell(text_of(row.printed.value, row.decimals, row.unit), source);
}

std::string derived_cell(const ReproduceRow& row) {
  return cell(text_of(row.derived.value, row.decimals, row.unit),
              row.derived.by.empty() ? "" : row.derived.by + ": " + row.derived.how);
}

const char* style_of(const ReproduceRow& row) {
  if (row.fails()) return "bad";
  return row.verdict() == Verdict::kReproduced || row.verdict() == Verdict::kDerived ? "good" : "soft";
}

std::string verdict_cell(const ReproduceRow& row) {
  std::string s = fmt::format("<td class=\"{}\">{}", style_of(row), name(row.verdict()));
  if (!row.fit.empty()) s += "<br><b>FIT</b>: " + escape_html(row.fit);
  if (row.fails()) s += "<br><b>unexpected</b>";
  if (!row.reason().empty()) s += "<br>" + escape_html(std::string(row.reason()));
  return s + "</td>";
}

std::string table(const std::vector<ReproduceRow>& rows) {
  std::string s =
      "<div class=\"scroll\"><table class=\"text\"><thead><tr><th>id</th><th>what</th><th>printed</th>"
      "<th>derived</th><th>ours</th><th>tolerance, or threshold of a "
      "wording</th><th>kind</th><th>verdict</th></tr></thead><tbody>\n";
  for (const ReproduceRow& row : rows)
    s += "<tr><td><code>" + escape_html(row.id) + "</code></td>" + cell(row.what, "") + printed_cell(row) +
         derived_cell(row) + cell(text_of(row.ours, row.decimals, row.unit), "") +
         cell(row.tolerance.empty() ? "-" : row.tolerance, "") + cell(std::string(name(row.kind())), "") +
         verdict_cell(row) + "</tr>\n";
  return s + "</tbody></table></div>\n";
}

std::string beside_table(const std::vector<BesideRow>& rows) {
  std::string s =
      "<p class=\"soft\">Beside the paper, which prints none of these:</p>\n<div class=\"scroll\"><table "
      "class=\"text\"><tbody>\n";
  for (const BesideRow& row : rows)
    s += "<tr><td><code>" + escape_html(row.id) + "</code></td>" + cell(row.what, "") +
         cell(text_of(row.value, row.decimals, row.unit), "") + "</tr>\n";
  return s + "</tbody></table></div>\n";
}

}  // namespace

std::string reproduce_page(const std::vector<PartResult>& results) {
  const VerdictCounts counts = count_verdicts(results);
  std::string of;
  for (const Verdict v : kVerdicts) of += fmt::format(", {} {}", counts.of[std::size_t(v)], name(v));
  std::string s =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"><title>firn reproduce</title><style>" +
      std::string(report::kReportStyle) +
      fmt::format(
          "</style></head><body>\n<h1>The papers beside Firn</h1>\n<p class=\"soft\">{} rows{}; {} are "
          "FIT, {} unexpected. Of the reproduced: {}. firn {}</p>\n",
          counts.rows, of, counts.fitted, counts.unexpected, kinds_in_words(counts),
          escape_html(build_commit().substr(0, 12))) +
      "<p><b>Reproduced</b>: ours agrees with the printed value. <b>Derived</b>: the paper prints no value, "
      "or "
      "a wrong one, and ours agrees with the one derived from its equations by the list of errata or by "
      "Firn. "
      "<b>Not identifiable</b>: the value depends on data that the paper does not print. <b>FIT</b>: "
      "parameters "
      "of the set-up were fitted to the paper's printed results, so a match tests the fit.</p>\n"
      "<p>A <b>wording</b> is judged by a threshold of Firn's own, which stands beside it. <b>Arithmetic</b> "
      "follows from the paper's own equations or from a file's format, so agreement checks the evaluation "
      "alone.</p>\n";
  for (const PartResult& result : results) {
    s += "<h2>" + escape_html(result.part.paper) + ": " + escape_html(result.part.what) + "</h2>\n";
    for (const std::string& note : result.notes) s += "<p>" + escape_html(note) + "</p>\n";
    if (!result.error.empty())
      s += "<p class=\"bad\">could not be computed: " + escape_html(result.error) + "</p>\n";
    if (!result.rows.empty()) s += table(result.rows);
    if (!result.beside.empty()) s += beside_table(result.beside);
    if (result.pictures.empty()) continue;
    s += "<div class=\"row\" style=\"margin-top:14px\">\n";
    for (const ReproducePicture& picture : result.pictures)
      s += "<figure><figcaption>" + escape_html(picture.caption) + "</figcaption>\n" + picture.svg +
           "</figure>\n";
    s += "</div>\n";
  }
  return s + "</body></html>\n";
}

}  // namespace firn
