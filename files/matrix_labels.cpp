#include "files/matrix_labels.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/options/number.h"

namespace firn {
namespace {

constexpr std::size_t kFewestCounted = 3;  // 0, 1 may be two drops as well

using Texts = std::vector<std::string>;

/// 0, 1, 2, ... or, as R has it, 1, 2, 3, ..., without decimals.
bool counts(const Texts& texts, std::size_t fewest) {
  if (texts.size() < fewest || (texts.front() != "0" && (texts.front() != "1" || fewest > 1))) return false;
  const std::size_t first = texts.front() == "0" ? 0 : 1;
  for (std::size_t n = 0; n < texts.size(); ++n)
    if (texts[n] != std::to_string(first + n)) return false;
  return true;
}

/// Numbers that ascend in equal steps: positions of the cells.
bool ascends_evenly(const Texts& texts) {
  if (texts.size() < kFewestCounted) return false;
  std::vector<double> values;
  for (const std::string& text : texts) {
    const auto value = whole_number<double>(text);
    if (!value) return false;
    values.push_back(*value);
  }
  for (std::size_t n = 1; n < values.size(); ++n) {
    const double step = values[n] - values[n - 1], first = values[1] - values[0];
    if (!(step > 0.0) || std::abs(step - first) > 1e-6 * first) return false;
  }
  return true;
}

}  // namespace

LabelledEdges labelled_edges(const SeparatedValues& table, const std::vector<SeparatedRow>& rows,
                             MatrixLabels labels) {
  if (labels != MatrixLabels::kDetect)
    return {labels == MatrixLabels::kRow || labels == MatrixLabels::kBoth,
            labels == MatrixLabels::kColumn || labels == MatrixLabels::kBoth,
            {}};
  if (rows.empty()) return {};
  // "0.0l2" is a number with a mistake.
  const auto is_word = [&](const std::string& text) {
    return !table.is_value(text) &&
           std::string_view("+-.0123456789").find(text.front()) == std::string_view::npos;
  };
  const Texts& top = rows.front().fields;
  const Texts after_corner(top.begin() + 1, top.end());
  Texts side, below_corner;
  for (const SeparatedRow& row : rows) side.push_back(row.fields.front());
  below_corner.assign(side.begin() + 1, side.end());
  const bool empty_corner = top.front().empty();
  const auto all_words = [&](const Texts& texts) {
    return !texts.empty() && std::ranges::all_of(texts, is_word);
  };
  const auto numbers_cells = [](const Texts& texts) { return counts(texts, 1) || ascends_evenly(texts); };
  LabelledEdges edges;
  if (all_words(after_corner)) {
    edges.row = true;
    edges.column = empty_corner || all_words(below_corner);
    if (!edges.column && counts(below_corner, kFewestCounted))
      table.fail(rows.front().line,
                 "the first row names the columns, and the first column counts 0, 1, 2, ...: is it the "
                 "numbers of the "
                 "rows (--labels both) or values (--labels row)?");
  } else if (all_words(below_corner)) {
    edges.column = true;
    edges.row = is_word(top.front()) != is_word(below_corner.front());
  } else if (is_word(top.front()) || (empty_corner && counts(after_corner, 1) && counts(below_corner, 1))) {
    edges.row = edges.column = true;
  } else if (empty_corner && numbers_cells(after_corner) && numbers_cells(below_corner)) {
    table.fail(
        rows.front().line,
        "the corner is empty, and the first row and column ascend in equal steps: are they places of the "
        "cells (--labels both) or values beside a missing one (--labels none)?");
  } else if (counts(top, kFewestCounted) || counts(side, kFewestCounted)) {
    const std::string edge = counts(top, kFewestCounted) ? "row" : "column";
    table.fail(rows.front().line,
               "the first " + edge +
                   " counts 0, 1, 2, ...: is it numbers of cells, as pandas writes them, (--labels " + edge +
                   ") or values of the matrix (--labels none)?");
  }
  if (edges.row || edges.column)
    edges.assumption = std::string("the first ") +
                       (edges.row && edges.column ? "row and column name"
                        : edges.row               ? "row names"
                                                  : "column names") +
                       " the cells: left out (--labels none reads them)";
  return edges;
}

}  // namespace firn
