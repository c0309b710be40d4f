#include "core/control/python_scheme.h"

#include <algorithm>
#include <stdexcept>

namespace firn::control {
namespace {

constexpr std::string_view kPrefix = "python:", kSuffix = ".py";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

bool is_identifier(std::string_view name) {
  return !name.empty() && is_letter(name.front()) &&
         std::ranges::all_of(name, [](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

[[noreturn]] void refuse(const std::string& problem) {
  throw std::invalid_argument("must read " + std::string(kPythonSchemeForm) + " or " +
                              std::string(kPythonSchemeForm) + "(NAME=VALUE, …): " + problem);
}

}  // namespace

std::string PythonScheme::file_name() const { return file.substr(file.rfind('/') + 1); }

PythonScheme parse_python_scheme(std::string_view text) {
  if (!text.starts_with(kPrefix)) refuse("it does not begin with python:");
  text.remove_prefix(kPrefix.size());
  PythonScheme s;
  if (const std::size_t open = text.find('('); open != std::string_view::npos) {
    if (!text.ends_with(')')) refuse("the arguments have no closing parenthesis");
    s.arguments = text.substr(open + 1, text.size() - open - 2);
    text = text.substr(0, open);
  }
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) refuse("no class is named");
  s.file = text.substr(0, colon);
  s.class_name = text.substr(colon + 1);
  if (!is_identifier(s.class_name)) refuse("'" + s.class_name + "' is no name of a class");
  const std::string name = s.file_name();
  if (!name.ends_with(kSuffix)) refuse("'" + s.file + "' does not end with .py");
  if (!is_identifier(std::string_view(name).substr(0, name.size() - kSuffix.size())))
    refuse("'" + name + "' is no name of a Python module: letters, digits and _ only");
  return s;
}

std::string to_text(const PythonScheme& s) {
  return std::string(kPrefix) + s.file + ":" + s.class_name +
         (s.arguments.empty() ? "" : "(" + s.arguments + ")");
}

}  // namespace firn::control
