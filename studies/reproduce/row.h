// ReproduceRow holds one figure of a paper: the printed value, the derived one where the paper prints none or
// a wrong one, and the value computed here, with the verdict of their comparison.
#pragma once

#include <string>
#include <string_view>
#include <variant>

namespace firn {

/// Holds a number, in the row's unit, or words; empty words = none.
using RowValue = std::variant<std::string, double>;

bool is_none(const RowValue& value);

/// Holds a value that the paper prints.
struct Printed {
  RowValue value;
  std::string place;  ///< page and table, figure or section: "p. 1064, Fig. 11"
  std::string
      quote;  ///< the paper's own words with the value in them; empty = read off the figure of `place`
};

/// Holds a value that the paper does not print, or prints wrong.
struct Derived {
  RowValue value;
  std::string by;   ///< "errata": the list of corrections to the papers; "Firn"
  std::string how;  ///< from which equations or printed numbers
};

enum class Verdict {
  kReproduced,       ///< ours agrees with the printed value
  kDerived,          ///< ours agrees with the derived value; the paper prints none to compare with
  kNotIdentifiable,  ///< the value depends on data that the paper does not print
  kNotReproduced,    ///< ours differs
};
inline constexpr Verdict kVerdicts[] = {Verdict::kReproduced, Verdict::kDerived, Verdict::kNotIdentifiable,
                                        Verdict::kNotReproduced};
std::string_view name(Verdict verdict);

/// Kinds of rows, by what agreement with one means.
enum class RowKind {
  kNumber,        ///< a number of the paper against one of a print, a plant, a motion or a measurement
  kFittedNumber,  ///< the same, where parameters were fitted to the paper's printed results
  kWording,       ///< words of the paper, judged by a threshold of Firn's own (ReproduceRow::tolerance)
  kArithmetic,    ///< follows from the paper's own equations or a file's format: a check of the evaluation
};
inline constexpr RowKind kRowKinds[] = {RowKind::kNumber, RowKind::kFittedNumber, RowKind::kWording,
                                        RowKind::kArithmetic};
std::string_view name(RowKind kind);

/// A row is written as one expression: what it is, what the paper prints or what is derived, the comparison.
///     ReproduceRow("lu.x.mean", "mean error", "um", ours).prints(44.1, "p. 1064, Fig. 11",
///     "...").within(1.0)
/// NaN agrees with nothing.
struct ReproduceRow {
  std::string id;  ///< <paper>.<part>.<name>, lower case, digits, '.' and '-'
  std::string what;
  std::string unit;  ///< of the numbers in printed, derived and ours
  RowValue ours;
  int decimals = 2;  ///< of the table; JSON carries the full numbers
  Printed printed;
  Derived derived;
  std::string tolerance;  ///< bound of the comparison in words, Firn's own for a wording; empty = none
  std::string fit;        ///< parameters that were fitted to the paper's printed results; empty = none
  std::string unidentifiable_for, missed_for;  ///< reasons; empty = not so
  bool compared_with_printed = false, compared_with_derived = false, agrees = true;
  bool is_arithmetic = false;

  ReproduceRow() = default;
  ReproduceRow(std::string row_id, std::string row_what, std::string row_unit, RowValue value,
               int row_decimals = 2);

  ReproduceRow& prints(RowValue value, std::string place, std::string quote = "");
  ReproduceRow& derives(RowValue value, std::string by, std::string how);

  /// |ours - printed| <= bound
  ReproduceRow& within(double bound);
  /// |ours - derived| <= bound
  ReproduceRow& within_derived(double bound);
  /// Words and vectors: ours agrees with the derived value too.
  ReproduceRow& also_derived(bool agreement, std::string criterion);
  /// ours <= bound, which is the printed statement, or the derived one where nothing is printed
  ReproduceRow& at_most(double bound);
  /// The statement, printed or else derived, holds by `criterion`.
  ReproduceRow& holds(bool statement, std::string criterion);

  /// Marks a match that tests the fit and not the paper. @param parameters fitted to printed results
  ReproduceRow& fitted(std::string parameters);
  /// Marks a value that the paper's equations or a file's format give without a print or a plant.
  ReproduceRow& arithmetic();
  /// A bound, if there is one, still has to hold.
  ReproduceRow& not_identifiable(std::string why);
  /// Takes the comparison back, as for a print cut short by --quick.
  ReproduceRow& not_judged(std::string why);
  /// A disagreement is known, and why.
  ReproduceRow& not_reproduced(std::string why);

  Verdict verdict() const;
  /// Returns the kind of the printed value, or of the derived one where nothing is printed. A list of numbers
  /// is a number.
  RowKind kind() const;
  /// Returns true for a disagreement that no reason is given for.
  bool fails() const;
  /// Returns the reason of a verdict that has one.
  std::string_view reason() const;

 private:
  ReproduceRow& compare(bool with_printed, bool result, std::string words);
};

/// Holds a number of ours that no paper prints: no row, no verdict.
struct BesideRow {
  std::string id, what, unit;
  RowValue value;
  int decimals = 2;
};

/// Returns a value as the table and the page show it: a number with its unit ("-": none).
std::string text_of(const RowValue& value, int decimals, const std::string& unit);

}  // namespace firn
