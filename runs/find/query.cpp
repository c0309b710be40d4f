#include "runs/find/query.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/options/number.h"

namespace firn::runs {
namespace {

struct Token {
  enum class Kind { kEnd, kWord, kText, kOperator, kOpen, kClose };
  Kind kind = Kind::kEnd;
  std::string text;
  std::size_t column = 1;
};

constexpr std::array<std::pair<std::string_view, Query::Operator>, 8> kOperators{{
    {"!=", Query::Operator::kUnequal},
    {"<=", Query::Operator::kAtMost},
    {">=", Query::Operator::kAtLeast},
    {"!~", Query::Operator::kLacks},
    {"=", Query::Operator::kEqual},
    {"<", Query::Operator::kLess},
    {">", Query::Operator::kGreater},
    {"~", Query::Operator::kContains},
}};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A word may have whatever a path, a date or a number has.
bool in_word(char c) {
  return is_letter(c) || is_digit(c) || std::string_view("_.:+-/@%").find(c) != std::string_view::npos ||
         static_cast<unsigned char>(c) >= 0x80;
}

class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { advance(); }

  const Token& now() const { return now_; }
  Token take() {
    Token t = now_;
    advance();
    return t;
  }
  bool is_word(std::string_view word) const { return now_.kind == Token::Kind::kWord && now_.text == word; }
  [[noreturn]] void fail(std::size_t column, const std::string& problem) const {
    throw QueryError(text_, column, problem);
  }
  [[noreturn]] void fail(const std::string& problem) const { fail(now_.column, problem); }

 private:
  void advance() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) ++at_;
    now_ = {Token::Kind::kEnd, "", at_ + 1};
    if (at_ == text_.size()) return;
    const char c = text_[at_];
    if (c == '(' || c == ')') {
      now_.kind = c == '(' ? Token::Kind::kOpen : Token::Kind::kClose;
      now_.text = text_[at_++];
    } else if (c == '"' || c == '\'') {
      read_text(c);
    } else if (in_word(c)) {
      now_.kind = Token::Kind::kWord;
      while (at_ < text_.size() && in_word(text_[at_])) now_.text += text_[at_++];
    } else {
      for (const auto& [sign, op] : kOperators)
        if (text_.substr(at_).starts_with(sign)) {
          now_.kind = Token::Kind::kOperator;
          now_.text = sign;
          at_ += sign.size();
          return;
        }
      fail(at_ + 1, std::string("'") + c + "' is no part of a condition; a text with it stands in quotes");
    }
  }
  void read_text(char quote) {
    const std::size_t begin = at_++;
    now_.kind = Token::Kind::kText;
    while (at_ < text_.size() && text_[at_] != quote) {
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
      now_.text += text_[at_++];
    }
    if (at_ >= text_.size()) fail(begin + 1, "a text in quotes that has no end");
    ++at_;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  Token now_;
};

class QueryParser {
 public:
  explicit QueryParser(std::string_view text) : tokens_(text) {}

  Query whole() {
    if (tokens_.now().kind == Token::Kind::kEnd) return {};
    Query q = condition(0);
    if (tokens_.now().kind == Token::Kind::kClose) tokens_.fail("a ')' without its '('");
    if (tokens_.now().kind != Token::Kind::kEnd)
      tokens_.fail("'and' or 'or' is wanted before '" + tokens_.now().text + "'");
    return q;
  }

 private:
  Query condition(std::size_t depth) {
    return chain(Query::Kind::kOr, "or", [&] { return term(depth); });
  }
  Query term(std::size_t depth) {
    return chain(Query::Kind::kAnd, "and", [&] { return factor(depth); });
  }
  template <class Next>
  Query chain(Query::Kind kind, std::string_view word, Next next) {
    Query first = next();
    if (!tokens_.is_word(word)) return first;
    Query q;
    q.kind = kind;
    q.column = first.column;
    q.parts.push_back(std::move(first));
    while (tokens_.is_word(word)) {
      tokens_.take();
      q.parts.push_back(next());
    }
    return q;
  }

  Query factor(std::size_t depth) {
    Query q;
    q.column = tokens_.now().column;
    if (depth > kMaxQueryDepth) tokens_.fail("more than " + std::to_string(kMaxQueryDepth) + " levels");
    if (tokens_.is_word("not")) {
      tokens_.take();
      q.kind = Query::Kind::kNot;
      q.parts.push_back(factor(depth + 1));
      return q;
    }
    if (tokens_.now().kind == Token::Kind::kOpen) {
      tokens_.take();
      q = condition(depth + 1);
      if (tokens_.now().kind != Token::Kind::kClose) tokens_.fail("a ')' is wanted");
      tokens_.take();
      return q;
    }
    if (tokens_.is_word("has")) {
      tokens_.take();
      q.kind = Query::Kind::kHas;
      q.key = key();
      return q;
    }
    if (tokens_.is_word("and") || tokens_.is_word("or"))
      tokens_.fail("a condition is wanted before '" + tokens_.now().text + "'");
    if (tokens_.now().kind != Token::Kind::kWord && tokens_.now().kind != Token::Kind::kText)
      tokens_.fail(tokens_.now().kind == Token::Kind::kEnd
                       ? "the end, and a condition is wanted, such as rms_um < 2"
                       : "a condition is wanted, such as rms_um < 2, and '" + tokens_.now().text +
                             "' begins none");
    const Token first = tokens_.take();
    if (tokens_.now().kind != Token::Kind::kOperator) {
      q.kind = Query::Kind::kMentions;
      q.text = first.text;
      return q;
    }
    if (first.kind != Token::Kind::kWord || !is_key(first.text))
      tokens_.fail(first.column,
                   "a key is wanted before '" + tokens_.now().text + "', such as rms_um or meta.ink");
    q.kind = Query::Kind::kCompare;
    q.key = first.text;
    const std::string sign = tokens_.take().text;
    q.op =
        std::ranges::find(kOperators, std::string_view(sign), [](const auto& o) { return o.first; })->second;
    take_value(sign, q);
    return q;
  }

  static bool is_key(std::string_view text) {
    return is_letter(text.front()) && std::ranges::all_of(text, [](char c) {
             return is_letter(c) || is_digit(c) || c == '_' || c == '.';
           });
  }
  std::string key() {
    if (tokens_.now().kind != Token::Kind::kWord || !is_key(tokens_.now().text))
      tokens_.fail("a key is wanted behind 'has', such as meta.ink");
    return tokens_.take().text;
  }
  void take_value(const std::string& sign, Query& q) {
    const Token t = tokens_.now();
    if (t.kind != Token::Kind::kWord && t.kind != Token::Kind::kText)
      tokens_.fail("a value is wanted behind '" + sign + "'" +
                   (t.kind == Token::Kind::kEnd ? "" : ", and '" + t.text + "' is none"));
    tokens_.take();
    q.text = t.text;
    if (t.kind == Token::Kind::kWord) q.number = whole_number<double>(t.text);
  }

  Tokens tokens_;
};

}  // namespace

QueryError::QueryError(std::string_view text, std::size_t at, const std::string& what_is_wrong)
    : std::runtime_error("column " + std::to_string(at) + ": " + what_is_wrong),
      column(at),
      problem(what_is_wrong) {
  for (const char c : text) shown += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  shown = "    " + shown + "\n    " + std::string(at - 1, ' ') + "^\n";
}

Query parse_query(std::string_view text) {
  if (text.size() > kMaxQueryBytes)
    throw QueryError("", 1,
                     "a condition of " + std::to_string(text.size()) + " bytes; at most " +
                         std::to_string(kMaxQueryBytes));
  return QueryParser(text).whole();
}

}  // namespace firn::runs
