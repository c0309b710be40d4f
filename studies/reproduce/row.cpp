#include "studies/reproduce/row.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace firn {
namespace {

double number_of(const RowValue& value) {
  const auto* number = std::get_if<double>(&value);
  return number ? *number : std::numeric_limits<double>::quiet_NaN();
}

std::string with_unit(std::string bound, const std::string& unit) {
  return unit.empty() ? bound : bound + " " + unit;
}

// "6.2 6.2 6.6 6.3", "[1 0.33 0]", "4.5×10^{-9}", "300 x 300 x 200"
bool lists_numbers(const RowValue& value) {
  const auto* words = std::get_if<std::string>(&value);
  return !words || words->find_first_not_of("0123456789.+- []^{}x\u00d7") == std::string::npos;
}

}  // namespace

bool is_none(const RowValue& value) {
  const auto* words = std::get_if<std::string>(&value);
  return words && words->empty();
}

std::string_view name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kReproduced:
      return "reproduced";
    case Verdict::kDerived:
      return "derived";
    case Verdict::kNotIdentifiable:
      return "not identifiable";
    case Verdict::kNotReproduced:
      return "not reproduced";
  }
  return "not reproduced";
}

std::string_view name(RowKind kind) {
  switch (kind) {
    case RowKind::kNumber:
      return "number";
    case RowKind::kFittedNumber:
      return "number with fit";
    case RowKind::kWording:
      return "wording";
    case RowKind::kArithmetic:
      return "arithmetic";
  }
  return "number";
}

ReproduceRow::ReproduceRow(std::string row_id, std::string row_what, std::string row_unit, RowValue value,
                           int row_decimals)
    : id(std::move(row_id)),
      what(std::move(row_what)),
      unit(std::move(row_unit)),
      ours(std::move(value)),
      decimals(row_decimals) {}

ReproduceRow& ReproduceRow::prints(RowValue value, std::string place, std::string quote) {
  printed = {std::move(value), std::move(place), std::move(quote)};
  return *this;
}

ReproduceRow& ReproduceRow::derives(RowValue value, std::string by, std::string how) {
  derived = {std::move(value), std::move(by), std::move(how)};
  return *this;
}

ReproduceRow& ReproduceRow::compare(bool with_printed, bool result, std::string words) {
  (with_printed ? compared_with_printed : compared_with_derived) = true;
  agrees = agrees && result;
  tolerance += (tolerance.empty() ? "" : "; ") + words;
  return *this;
}

ReproduceRow& ReproduceRow::within(double bound) {
  return compare(true, std::abs(number_of(ours) - number_of(printed.value)) <= bound,
                 with_unit(fmt::format("+- {:g}", bound), unit));
}

ReproduceRow& ReproduceRow::within_derived(double bound) {
  return compare(false, std::abs(number_of(ours) - number_of(derived.value)) <= bound,
                 with_unit(fmt::format("{}+- {:g}", compared_with_printed ? "derived " : "", bound), unit));
}

ReproduceRow& ReproduceRow::also_derived(bool agreement, std::string criterion) {
  return compare(false, agreement, "derived " + criterion);
}

ReproduceRow& ReproduceRow::at_most(double bound) {
  return compare(!is_none(printed.value), number_of(ours) <= bound,
                 with_unit(fmt::format("<= {:g}", bound), unit));
}

ReproduceRow& ReproduceRow::holds(bool statement, std::string criterion) {
  return compare(!is_none(printed.value), statement, std::move(criterion));
}

ReproduceRow& ReproduceRow::fitted(std::string parameters) {
  fit = std::move(parameters);
  return *this;
}

ReproduceRow& ReproduceRow::arithmetic() {
  is_arithmetic = true;
  return *this;
}

ReproduceRow& ReproduceRow::not_identifiable(std::string why) {
  unidentifiable_for = std::move(why);
  return *this;
}

ReproduceRow& ReproduceRow::not_judged(std::string why) {
  compared_with_printed = compared_with_derived = false;
  agrees = true;
  tolerance.clear();
  return not_identifiable(std::move(why));
}

ReproduceRow& ReproduceRow::not_reproduced(std::string why) {
  missed_for = std::move(why);
  return *this;
}

Verdict ReproduceRow::verdict() const {
  if (!agrees) return Verdict::kNotReproduced;
  if (!unidentifiable_for.empty()) return Verdict::kNotIdentifiable;
  if (compared_with_printed) return Verdict::kReproduced;
  return compared_with_derived ? Verdict::kDerived : Verdict::kNotReproduced;
}

RowKind ReproduceRow::kind() const {
  if (is_arithmetic) return RowKind::kArithmetic;
  if (!lists_numbers(is_none(printed.value) ? derived.value : printed.value)) return RowKind::kWording;
  return fit.empty() ? RowKind::kNumber : RowKind::kFittedNumber;
}

bool ReproduceRow::fails() const { return verdict() == Verdict::kNotReproduced && missed_for.empty(); }

std::string_view ReproduceRow::reason() const {
  switch (verdict()) {
    case Verdict::kNotIdentifiable:
      return unidentifiable_for;
    case Verdict::kNotReproduced:
      return missed_for;
    default:
      return {};
  }
}

std::string text_of(const RowValue& value, int decimals, const std::string& unit) {
  if (const auto* words = std::get_if<std::string>(&value)) return words->empty() ? "-" : *words;
  const double number = std::get<double>(value);
  std::string digits = std::isfinite(number) ? fmt::format("{:.{}f}", number, decimals) : "none";
  if (number != 0.0 && digits.find_first_of("123456789") == std::string::npos)
    digits = fmt::format("{:.1e}", number);
  return unit.empty() ? digits : digits + " " + unit;
}

}  // namespace firn
