#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "config/fields.h"
#include "config/own_programs.h"
#include "core/control/python_scheme.h"
#include "files/nearest.h"

namespace firn {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;  // clang 14 does not deduce aggregates

std::string number_text(double value) {
  if (value == 0.0) return "0.0";
  std::array<char, 40> buffer;
  std::string text(buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string schedule_text(const std::vector<AlphaStep>& steps) {
  if (steps.size() == 1 && steps[0].from_layer == 1) return number_text(steps[0].alpha);
  std::string out = "[";
  for (const AlphaStep& s : steps)
    out += (out.size() > 1 ? ", " : "") + std::string("{from_layer = ") + std::to_string(s.from_layer) +
           ", alpha = " + number_text(s.alpha) + "}";
  return out + "]";
}

std::string list_text(const std::vector<double>& numbers) {
  std::string out = "[";
  for (double v : numbers) out += (out.size() > 1 ? ", " : "") + number_text(v);
  return out + "]";
}

std::string broken_schedule(const std::vector<AlphaStep>& steps, const Limits& limits) {
  if (steps.empty() || steps[0].from_layer != 1) return "must begin with from_layer = 1";
  for (std::size_t n = 1; n < steps.size(); ++n)
    if (steps[n].from_layer <= steps[n - 1].from_layer) return "must have ascending from_layer";
  for (const AlphaStep& s : steps)
    if (!limits.holds(s.alpha)) return "must have every alpha in " + text(limits);
  return "";
}

// Control characters and lengths are limited as those of any text.
std::string broken_characters(const std::string& text) {
  if (text.size() > 4096) return "must be at most 4096 bytes long";
  for (unsigned char c : text)
    if (c < 0x20 || c == 0x7f) return "must not contain control characters";
  return "";
}

std::string broken_python_scheme(const std::string& text) try {
  control::parse_python_scheme(text);
  return broken_characters(text);
} catch (const std::invalid_argument& error) {
  return error.what();
}

std::string broken_text(const std::string& text, const Limits& limits) {
  if (const std::string_view name = own_source(text); limits.or_own && !name.empty())
    return is_own_name(name) ? "" : std::string("must name a program after own: ") + kOwnNameForm;
  if (limits.or_python && control::is_python_scheme(text)) return broken_python_scheme(text);
  if (!limits.choices.empty()) {
    if (std::find(limits.choices.begin(), limits.choices.end(), text) != limits.choices.end()) return "";
    const std::string near = nearest(text, limits.choices);
    return near.empty() ? "must be" : "(did you mean \"" + near + "\"?) must be";
  }
  return broken_characters(text);
}

}  // namespace

std::string value_text(const Field& field) {
  return std::visit(
      Overloaded{
          [](const double* v) { return number_text(*v); }, [](const std::string* v) { return quoted(*v); },
          [](const std::vector<AlphaStep>* v) { return schedule_text(*v); },
          [](const std::vector<double>* v) { return list_text(*v); },
          [&](const WordMember& v) { return quoted(std::string(field.limits.choices[v.get(v.member)])); },
          [](const auto* v) { return std::to_string(*v); }},
      field.value);
}

std::string limits_text(const Field& field) {
  const Limits& l = field.limits;
  if (!l.choices.empty()) {
    std::string out = "one of ";
    for (std::string_view c : l.choices) out += (c == l.choices.front() ? "" : ", ") + std::string(c);
    if (l.or_own) out += ", own:NAME of a program of your own";
    return l.or_python ? out + ", " + std::string(control::kPythonSchemeForm) : out;
  }
  return text(l);
}

std::string broken_word(const Field& field, const std::string& word) {
  if (field.only_if_given && word.empty()) return {};  // it was not given
  const std::string problem = broken_text(word, field.limits);
  return problem.ends_with("must be") ? problem + " " + limits_text(field) : problem;
}

std::string broken_limit(const Field& field) {
  const std::string unit = field.unit.empty() ? "" : " " + std::string(field.unit);
  const auto interval = [&](double v) {
    if (field.limits.holds(v)) return std::string();
    Range beside_zero = field.limits;
    beside_zero.or_zero = false;
    return (field.limits.or_zero ? "must be 0 or lie in " : "must lie in ") + text(beside_zero) + unit;
  };
  return std::visit(
      Overloaded{[&](const std::string* v) { return broken_word(field, *v); },
                 [&](const std::vector<AlphaStep>* v) { return broken_schedule(*v, field.limits); },
                 [](const WordMember&) { return std::string(); },
                 [&](const std::vector<double>* v) {
                   const bool ok =
                       std::all_of(v->begin(), v->end(), [&](double x) { return field.limits.holds(x); });
                   return ok ? std::string() : "every entry must lie in " + limits_text(field) + unit;
                 },
                 [&](const auto* v) { return interval(double(*v)); }},
      field.value);
}

std::string_view type_text(const Field& field) {
  return std::visit(
      Overloaded{[](const double*) { return "number"; }, [](const std::string*) { return "text"; },
                 [](const std::vector<AlphaStep>*) { return "number or schedule"; },
                 [](const std::vector<double>*) { return "list of numbers"; },
                 [](const WordMember&) { return "text"; }, [](const auto*) { return "integer"; }},
      field.value);
}

}  // namespace firn
