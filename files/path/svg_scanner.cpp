#include "files/path/svg_scanner.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>

#include "core/options/number.h"
#include "files/path/svg_shapes.h"

namespace firn::svg {

void Scanner::fail(const std::string& problem) const {
  std::string shown(rest_.substr(0, 20));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  throw SyntaxError(
      fmt::format("character {}: {}, not '{}'", all_.size() - rest_.size() + 1, problem, shown));
}

void Scanner::skip_blanks() {
  while (!rest_.empty() && std::string_view(" \t\r\n\f").find(rest_.front()) != std::string_view::npos)
    rest_.remove_prefix(1);
}

void Scanner::skip_separator() {
  skip_blanks();
  if (take(',')) skip_blanks();
}

bool Scanner::take(char c) {
  if (rest_.empty() || rest_.front() != c) return false;
  rest_.remove_prefix(1);
  return true;
}

bool Scanner::empty() {
  skip_blanks();
  return rest_.empty();
}

bool Scanner::at_number() {
  skip_blanks();
  return !rest_.empty() && std::string_view("+-.0123456789").find(rest_.front()) != std::string_view::npos;
}

double Scanner::number() {
  skip_blanks();
  const auto value = take_number<double>(rest_);
  if (!value) fail("a finite number is needed");
  return *value;
}

double Scanner::next() {
  const double value = number();
  skip_separator();
  return value;
}

Point2 Scanner::point() {
  const double x = next();
  return {x, next()};
}

bool Scanner::flag() {
  skip_blanks();
  const bool set = take('1');
  if (!set && !take('0')) fail("a flag, 0 or 1, is needed");
  skip_separator();
  return set;
}

std::string_view Scanner::word() {
  skip_blanks();
  return take_while([](unsigned char c) { return std::isalnum(c) != 0; });
}

std::string_view Scanner::unit() {
  return take_while([](unsigned char c) { return std::isalpha(c) != 0; });
}

char Scanner::letter() {
  skip_blanks();
  const char c = rest_.empty() ? '\0' : rest_.front();
  if (!rest_.empty()) rest_.remove_prefix(1);
  return c;
}

}  // namespace firn::svg
