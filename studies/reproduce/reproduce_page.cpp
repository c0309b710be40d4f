#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/report_page.h"
#include "runtime/build_info.h"
#include "studies/reproduce/reproduce.h"

namespace firn {
namespace {

using replay::escape_html;

std::string cell(const RowValue& value, const ReproduceRow& row) {
  return escape_html(text_of(value, row.decimals, row.unit));
}

std::string verdict(const ReproduceRow& row) {
  if (!row.pass) return "<td class=\"soft\" style=\"white-space:nowrap\">shown</td>";
  return *row.pass ? "<td class=\"good\" style=\"white-space:nowrap\">pass</td>"
                   : "<td class=\"bad\" style=\"white-space:nowrap\">FAIL</td>";
}

std::string table(const std::vector<ReproduceRow>& rows) {
  std::string s =
      "<div class=\"scroll\"><table "
      "class=\"text\"><thead><tr><th>id</th><th>what</th><th>kind</th><th>paper</th>"
      "<th>ours</th><th>tolerance</th><th></th></tr></thead><tbody>\n";
  for (const ReproduceRow& row : rows)
    s += "<tr><td><code>" + escape_html(row.id) + "</code></td><td>" + escape_html(row.what) +
         "</td><td style=\"white-space:nowrap\">" + std::string(name(row.kind)) + "</td><td>" +
         cell(row.paper, row) + "</td><td>" + cell(row.ours, row) + "</td><td>" +
         escape_html(tolerance_of(row)) + "</td>" + verdict(row) + "</tr>\n";
  return s + "</tbody></table></div>\n";
}

}  // namespace

std::string reproduce_page(const std::vector<PartResult>& results) {
  int pass = 0, fail = 0, shown = 0;
  for (const PartResult& part : results)
    for (const ReproduceRow& row : part.rows) ++(!row.pass ? shown : *row.pass ? pass : fail);
  std::string s =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"><title>firn reproduce</title><style>" +
      std::string(replay::kReportStyle) +
      "</style></head><body>\n<h1>The papers beside Firn</h1>\n<p class=\"soft\">" + std::to_string(pass) +
      " rows pass, " + std::to_string(fail) + " fail, " + std::to_string(shown) +
      " are shown without a verdict. firn " + escape_html(build_commit().substr(0, 12)) +
      "</p>\n<p>Kinds: <b>computed</b> follows from "
      "the paper's equations or data; <b>fit</b> is of a set-up that the paper does not print, so a match "
      "tests the fit; "
      "<b>property</b> must hold for any input; <b>measured</b> is the paper's own measurement.</p>\n";
  for (const PartResult& result : results) {
    s += "<h2>" + escape_html(result.part.paper) + ": " + escape_html(result.part.what) + "</h2>\n";
    for (const std::string& note : result.notes) s += "<p>" + escape_html(note) + "</p>\n";
    s += table(result.rows);
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
