#include "plant/twins/vplus/lexer.h"

#include <array>
#include <stdexcept>

#include "core/options/number.h"
#include "plant/twins/vplus/value.h"

namespace firn::plant::vplus {
namespace {

constexpr std::array<std::string_view, 20> kSigns{"==", "<>", "<=", "=<", ">=", "=>", "<", ">", "=", "+",
                                                  "-",  "*",  "/",  "(",  ")",  "[",  "]", ",", ":", ";"};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_name_part(char c) { return is_letter(c) || is_digit(c) || c == '.' || c == '_'; }

std::size_t length_of_number(std::string_view s) {
  std::size_t n = 0;
  while (n < s.size() && (is_digit(s[n]) || s[n] == '.')) ++n;
  if (n < s.size() && s[n] == 'E') {
    std::size_t e = n + 1;
    if (e < s.size() && (s[e] == '+' || s[e] == '-')) ++e;
    const std::size_t digits = e;
    while (e < s.size() && is_digit(s[e])) ++e;
    if (e > digits) n = e;
  }
  return n;
}

Token number_token(std::string_view& line) {
  Token t{Token::Kind::kNumber, {}, 0.0F};
  if (line[0] == '^') {
    std::size_t n = 2;
    while (n < line.size() && (is_digit(line[n]) || (line[n] >= 'A' && line[n] <= 'F'))) ++n;
    t.text = line.substr(0, n);
    const auto value =
        n > 2 && line[1] == 'H' ? whole_hex_number<std::uint32_t>(line.substr(2, n - 2)) : std::nullopt;
    if (!value || *value > 0xFFFFFF) throw std::invalid_argument("no number of 24 bits: " + t.text);
    t.number = float(*value);
    line.remove_prefix(n);
    return t;
  }
  const std::size_t n = length_of_number(line);
  t.text = line.substr(0, n);
  const auto value = whole_number<float>(t.text);
  if (!value) throw std::invalid_argument("no number: " + t.text);
  t.number = *value;
  line.remove_prefix(n);
  return t;
}

Token next_token(std::string_view& line) {
  const char c = line[0];
  if (c == '"') {
    const std::size_t end = line.find('"', 1);
    if (end == std::string_view::npos) throw std::invalid_argument("a string does not end");
    Token t{Token::Kind::kText, std::string(line.substr(1, end - 1)), 0.0F};
    if (t.text.size() > kMaxString) throw std::invalid_argument("a string has more than 128 characters");
    line.remove_prefix(end + 1);
    return t;
  }
  if (is_digit(c) || c == '^' || (c == '.' && line.size() > 1 && is_digit(line[1])))
    return number_token(line);
  if (is_letter(c) || ((c == '$' || c == '#') && line.size() > 1 && is_letter(line[1]))) {
    std::size_t n = 1;
    while (n < line.size() && is_name_part(line[n])) ++n;
    Token t{Token::Kind::kName, std::string(line.substr(0, n)), 0.0F};
    line.remove_prefix(n);
    return t;
  }
  for (const std::string_view sign : kSigns)
    if (line.starts_with(sign)) {
      line.remove_prefix(sign.size());
      return {Token::Kind::kSign, std::string(sign), 0.0F};
    }
  throw std::invalid_argument(std::string("unknown character '") + c + "'");
}

}  // namespace

std::vector<Token> tokens_of(std::string_view line) {
  std::vector<Token> tokens;
  while (!line.empty()) {
    if (line[0] == ' ' || line[0] == '\t' || line[0] == '\r') {
      line.remove_prefix(1);
      continue;
    }
    if (line[0] == ';') break;
    tokens.push_back(next_token(line));
  }
  tokens.emplace_back();
  return tokens;
}

}  // namespace firn::plant::vplus
