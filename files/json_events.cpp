#include "files/json_events.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "files/decimal.h"

namespace firn {
namespace {

constexpr std::size_t kNumberBytes = 64;  // of lookahead in which nearly every number ends

class Events {
 public:
  Events(ByteBlocks& in, JsonHandler& to) : in_(in), to_(to) {}

  void read() {
    while (in_.size() < 3 && in_.more()) continue;
    if (in_.size() >= 3 && std::string_view(in_.begin(), 3) == "\xef\xbb\xbf") in_.take(3);
    value();
    while (!open_.empty()) next();
    if (blank() != -1) fail("unexpected bytes after the end of the document");
  }

 private:
  enum class Inside { kObject, kList };

  [[noreturn]] void fail(const std::string& what) const { throw JsonMistake{in_.position() + 1, what}; }
  [[noreturn]] void unexpected(int c, const char* expected) const {
    if (c == -1) fail(std::string("the end of the file, expected ") + expected);
    fail("unexpected " +
         (c > 32 && c < 127 ? std::string("'") + char(c) + "'" : "byte " + std::to_string(c)) +
         ", expected " + expected);
  }

  /// Returns the next byte that is not white space, without taking that byte; -1 at the end.
  int blank() {
    for (;;) {
      for (const char* p = in_.begin(); p != in_.end(); ++p)
        if (*p != ' ' && *p != '\n' && *p != '\t' && *p != '\r') {
          in_.take(std::size_t(p - in_.begin()));
          return static_cast<unsigned char>(*p);
        }
      in_.take(in_.size());
      if (!in_.more()) return -1;
    }
  }

  /// Reads the next token of the innermost open object or list.
  void next() {
    const bool object = open_.back() == Inside::kObject;
    int c = blank();
    if (c == (object ? '}' : ']')) {
      if (after_comma_) unexpected(c, object ? "a key" : "a value");
      in_.take(1);
      open_.pop_back();
      first_ = false;
      object ? to_.end_object() : to_.end_list();
      return;
    }
    if (!first_ && !after_comma_) {
      if (c != ',') unexpected(c, object ? "',' or '}'" : "',' or ']'");
      in_.take(1);
      after_comma_ = true;
      return;
    }
    first_ = after_comma_ = false;
    if (object) {
      if (c != '"') unexpected(c, "a key");
      text();
      to_.key(text_);
      if (c = blank(); c != ':') unexpected(c, "':'");
      in_.take(1);
    }
    value();
  }

  void value() {
    const int c = blank();
    switch (c) {
      case '{':
      case '[':
        in_.take(1);
        open_.push_back(c == '{' ? Inside::kObject : Inside::kList);
        first_ = true;
        c == '{' ? to_.start_object() : to_.start_list();
        return;
      case '"':
        text();
        return to_.text(text_);
      case 't':
        word("true");
        return to_.boolean(true);
      case 'f':
        word("false");
        return to_.boolean(false);
      case 'n':
        word("null");
        return to_.null();
      default:
        if (c != '-' && (c < '0' || c > '9')) unexpected(c, "a value");
        return number();
    }
  }

  void word(const char* expected) {
    for (const char* p = expected; *p; ++p) {
      if (in_.peek() != *p) unexpected(in_.peek(), expected);
      in_.take(1);
    }
  }

  static bool in_number(int c) {
    return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'e' || c == 'E';
  }

  void number() {
    if (in_.size() < kNumberBytes) in_.more();
    const char *const from = in_.begin(), *end = nullptr;
    const bool zero_first = in_.size() > 1 && (*from == '0' || (*from == '-' && from[1] == '0'));
    double value = 0.0;
    // shorter than the buffered bytes, so that the end is visible; only a point or the end may follow a
    // leading zero
    if (in_.size() >= kNumberBytes && !zero_first) end = read_short_decimal(from, in_.end(), value);
    if (end && !in_number(*end)) {
      const bool whole = std::string_view(from, std::size_t(end - from)).find('.') == std::string_view::npos;
      in_.take(std::size_t(end - from));
      return whole ? to_.integer(value) : to_.number(value);
    }
    any_number();
  }

  /// Any number of the grammar, byte by byte.
  void any_number() {
    text_.clear();
    const auto digits = [&] {
      if (in_.peek() < '0' || in_.peek() > '9') unexpected(in_.peek(), "a digit");
      while (in_.peek() >= '0' && in_.peek() <= '9') keep();
    };
    bool whole = true;
    if (in_.peek() == '-') keep();
    if (in_.peek() == '0')
      keep();
    else
      digits();
    if (in_.peek() == '.') {
      whole = false;
      keep();
      digits();
    }
    if (in_.peek() == 'e' || in_.peek() == 'E') {
      whole = false;
      keep();
      if (in_.peek() == '+' || in_.peek() == '-') keep();
      digits();
    }
    const char* from = text_.data();
    double value = 0.0;
    if (std::from_chars(from, from + text_.size(), value).ec != std::errc())
      value = std::strtod(from, nullptr);  // 0 or infinite
    if (!std::isfinite(value)) fail("number overflow: " + text_.substr(0, 40));
    whole ? to_.integer(value) : to_.number(value);
  }
  void keep() {
    text_ += char(in_.peek());
    in_.take(1);
  }

  void text() {
    in_.take(1);
    text_.clear();
    for (;;) {
      const int c = in_.peek();
      if (c == -1) unexpected(c, "the end of the text");
      if (c < 0x20) fail("a control character in a text");
      if (c >= 0x80) {
        several_bytes(c);
        continue;
      }
      in_.take(1);
      if (c == '"') return;
      if (c == '\\')
        escape();
      else
        text_ += char(c);
    }
  }

  /// A character of two to four bytes, well formed (Unicode 15, table 3-7).
  void several_bytes(int first) {
    const int count = first >= 0xc2 && first <= 0xdf   ? 1
                      : (first & 0xf0) == 0xe0         ? 2
                      : first >= 0xf0 && first <= 0xf4 ? 3
                                                       : 0;
    if (count == 0) fail("not UTF-8");
    keep();
    for (int n = 0; n < count; ++n) {
      const int c = in_.peek();
      const int low = n > 0 ? 0x80 : first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
      const int high = n > 0 ? 0xbf : first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
      if (c < low || c > high) fail("not UTF-8");
      keep();
    }
  }

  unsigned hex() {
    unsigned value = 0;
    for (int n = 0; n < 4; ++n) {
      const int c = in_.peek();
      const int digit = c >= '0' && c <= '9'   ? c - '0'
                        : c >= 'a' && c <= 'f' ? c - 'a' + 10
                        : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                               : -1;
      if (digit < 0) unexpected(c, "four hexadecimal digits");
      value = 16 * value + unsigned(digit);
      in_.take(1);
    }
    return value;
  }

  void escape() {
    static constexpr std::string_view kNames = "\"\\/bfnrt", kMeanings = "\"\\/\b\f\n\r\t";
    const int c = in_.peek();
    if (const std::size_t known = kNames.find(char(c)); c != -1 && known != kNames.npos) {
      text_ += kMeanings[known];
      in_.take(1);
      return;
    }
    if (c != 'u') unexpected(c, "an escape");
    in_.take(1);
    unsigned code = hex();
    if (code >= 0xdc00 && code <= 0xdfff) fail("the second half of a pair of surrogates without the first");
    if (code >= 0xd800 && code <= 0xdbff) {
      for (const char expected : {'\\', 'u'}) {
        if (in_.peek() != expected) fail("the first half of a pair of surrogates without the second");
        in_.take(1);
      }
      const unsigned low = hex();
      if (low < 0xdc00 || low > 0xdfff) fail("the first half of a pair of surrogates without the second");
      code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
    }
    const int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static constexpr unsigned kLead[4] = {0x00, 0xc0, 0xe0, 0xf0};
    text_ += char(kLead[more] | (code >> (6 * more)));
    for (int n = more; n-- > 0;) text_ += char(0x80 | ((code >> (6 * n)) & 0x3f));
  }

  ByteBlocks& in_;
  JsonHandler& to_;
  std::vector<Inside> open_;
  bool first_ = false, after_comma_ = false;
  std::string text_;
};

}  // namespace

void read_json_events(ByteBlocks& in, JsonHandler& to) { Events(in, to).read(); }

}  // namespace firn
