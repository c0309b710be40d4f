#include "files/path/gcode_block.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/options/number.h"
#include "files/text_lines.h"

namespace firn {
namespace {

constexpr std::size_t kMaxWordsBytes = 1000;  // of a line without its comment
constexpr std::string_view kOnceOnly = "XYZIJKRFE";
/// Words by which controllers and firmware branch and compute.
constexpr std::string_view kControl[] = {"IF",    "THEN",     "ELSE", "ELIF", "ELSEIF", "ENDIF",
                                         "WHILE", "ENDWHILE", "FOR",  "GOTO", "DO",     "END",
                                         "CALL",  "SUB",      "VAR",  "SET",  "REPEAT"};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
bool is_alpha(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool ends_words(char c) { return std::string_view(";(*/%").find(c) != std::string_view::npos; }
char upper(char c) { return c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c; }

std::string uppercase(std::string_view text) {
  std::string all(text);
  std::ranges::transform(all, all.begin(), upper);
  return all;
}

/// M codes whose words are those of RS-274; the words behind any other are its own: M92 X80, M117 text.
bool shares_words(double m) {
  return (m >= 2.0 && m < 10.0) || m == 30.0 || m == 48.0 || m == 49.0 || m == 60.0 || m == 82.0 ||
         m == 83.0 || m == 98.0 || m == 99.0;
}

class BlockReader {
 public:
  BlockReader(std::string_view line, GcodeExponent exponent,
              const std::function<void(const std::string&)>& fail)
      : text_(line), exponent_(exponent), fail_(fail) {}

  GcodeBlock read() {
    skip_blanks();
    while (at_ < text_.size() && !done_) {
      item();
      skip_blanks();
    }
    return std::move(block_);
  }

 private:
  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }
  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }

  void item() {
    const char c = upper(peek());
    if (c == ';' || c == '*' || (c == '/' && peek(1) == '/')) {  // a comment, a checksum
      done_ = true;
      return;
    }
    if (c == '(') {
      const std::size_t end = text_.find(')', at_);
      if (end == text_.npos) fail_("a comment without its )");
      at_ = end + 1;
      return;
    }
    if (c == '/') {  // a line that a switch of the machine leaves out
      ++at_;
      return;
    }
    block_.empty = false;
    if (c == '%') {
      block_.percent = done_ = true;
      return;
    }
    if (!any_word_ && is_command()) return command();
    if (c == '#' || c == '[') fail_("parameters and expressions (#, [ ]) are not read");
    if (is_digit(c) || c == '.' || c == '+' || c == '-')
      fail_(fmt::format("{}: a number without its letter", shown_text(text_.substr(at_), 20)));
    if (c < 'A' || c > 'Z') fail_(fmt::format("'{}' is no word of G-code", shown_text(text_.substr(at_, 1))));
    word(c);
  }

  /// A name of two letters or more, or a sign by which senders of G-code talk to the firmware: $H, @pause.
  bool is_command() const {
    const char c = peek();
    if (c == '$' || c == '@' || c == '?') return true;
    if (upper(c) == 'T' && (peek(1) == '?' || peek(1) == 'x' || peek(1) == 'c'))
      return true;  // Prusa's tool prompts
    return (is_alpha(c) || c == '_') && (is_alpha(peek(1)) || peek(1) == '_');
  }
  void command() {
    std::size_t end = at_;
    while (end < text_.size() && !is_blank(text_[end]) && text_[end] != '=' && text_[end] != ';') ++end;
    block_.command = shown_text(uppercase(text_.substr(at_, end - at_)));
    std::string_view name = block_.command;
    while (!name.empty() && is_digit(name.back())) name.remove_suffix(1);  // DO1, END1
    if (std::ranges::find(kControl, name) != std::end(kControl))
      fail_(fmt::format("{}: variables, branches and loops are not read", block_.command));
    block_.arguments = text_.substr(end);
    done_ = true;
  }

  void word(char letter) {
    const std::size_t from = at_++;
    const bool glued = from > 0 && (is_digit(text_[from - 1]) || text_[from - 1] == '.');
    skip_blanks();
    if (letter == 'O') refuse_call();
    if (peek() == '#' || peek() == '[') fail_("parameters and expressions (#, [ ]) are not read");
    if (from > kMaxWordsBytes) fail_(fmt::format("a line longer than the limit of {} bytes", kMaxWordsBytes));
    std::string_view rest = text_.substr(at_);
    const std::size_t before = rest.size();
    // Behind the letter E itself an e can only begin an exponent.
    const bool as_exponent = exponent_ == GcodeExponent::kExponent || letter == 'E';
    const std::optional<double> value =
        take_number<double>(rest, as_exponent ? Exponent::kRead : Exponent::kLeft);
    const std::string_view digits = text_.substr(at_, before - rest.size());
    at_ += digits.size();
    any_word_ = any_word_ || letter != 'N';
    if (!value) return flag(letter, from);
    check_end(from);
    if (exponent_ != GcodeExponent::kUnknown && letter != 'E') check_exponent(letter, from, digits);
    if (letter == 'G') {
      block_.g.push_back(*value);
    } else if (letter == 'M') {
      machine_code(*value);
    } else {
      if (letter == 'E') block_.e_axis = block_.e_axis || !glued || digits.find('.') != digits.npos;
      if (letter == 'X' || letter == 'Y') count_decimals(digits);
      if (block_[letter] && kOnceOnly.find(letter) != kOnceOnly.npos && exponent_ != GcodeExponent::kUnknown)
        fail_(fmt::format("{} stands twice in one block", letter));
      block_[letter] = *value;
    }
  }

  void flag(char letter, std::size_t from) {
    const char next = peek();
    const std::string shown = shown_text(text_.substr(from), 20);
    if (letter == 'G' || letter == 'M' || (at_ < text_.size() && !is_alpha(next) && !ends_words(next)))
      fail_(fmt::format("{}: {} must be followed by a finite number", shown, letter));
    if (block_.flag_text.empty()) block_.flag_text = shown;
    block_.flag[std::size_t(letter - 'A')] = true;
  }

  /// A number ends where a word, a comment or the line does.
  void check_end(std::size_t from) const {
    const char c = peek();
    if (at_ >= text_.size() || is_blank(c) || is_alpha(c) || ends_words(c)) return;
    std::size_t end = at_;
    while (end < text_.size() && !is_blank(text_[end]) && text_[end] != ';') ++end;
    fail_(fmt::format("{} is no number: it goes on with '{}'", shown_text(text_.substr(from, end - from), 30),
                      shown_text(text_.substr(at_, 1))));
  }

  /// X1e-05 is an exponent, X1E5 may be a word. Numbers that could be either are refused.
  void check_exponent(char letter, std::size_t from, std::string_view digits) const {
    const bool behind = exponent_ == GcodeExponent::kWordE;
    const std::string_view number =
        behind ? text_.substr(at_) : digits.substr(std::min(digits.find_first_of("eE"), digits.size()));
    if (number.empty() || upper(number.front()) != 'E') return;
    std::size_t n = 1;
    const bool is_signed = number.size() > 1 && (number[1] == '-' || number[1] == '+');
    if (is_signed) ++n;
    const std::size_t first = n;
    while (n < number.size() && is_digit(number[n])) ++n;
    const bool fraction = n < number.size() && number[n] == '.';
    const bool written_by_program = is_signed && n - first >= 2 && !fraction;
    const bool other_case = number.front() == 'e' && text_[from] == letter;
    const std::string shown = shown_text(text_.substr(from, at_ - from + (behind ? n : 0)), 30);
    if (behind && written_by_program)
      fail_(fmt::format(
          "{} is an exponent or a word E: with an axis E numbers have no exponents; write {} in full, "
          "or a blank before E",
          shown, letter));
    if (!behind && !written_by_program && !other_case)
      fail_(
          fmt::format("{} is an exponent or a word E: write the number in full, or a blank before E", shown));
  }

  void count_decimals(std::string_view digits) {
    const std::size_t point = digits.find('.'), end = std::min(digits.find_first_of("eE"), digits.size());
    if (point != digits.npos) block_.decimals = std::max(block_.decimals, int(end - point - 1));
  }

  void machine_code(double value) {
    block_.m.push_back(value);
    if (value == 98.0) fail_("M98 calls a subprogram, which is not read");
    if (shares_words(value)) return;
    block_.command = fmt::format("M{:g}", value);
    block_.arguments = text_.substr(at_);
    const std::size_t g = block_.arguments.find_first_of("gG");
    if (value >= 10.0 && value < 70.0 && g != block_.arguments.npos && g + 1 < block_.arguments.size() &&
        is_digit(block_.arguments[g + 1]))
      fail_(fmt::format("M{:g} with a G code behind it: write them in lines of their own", value));
    done_ = true;
  }

  /// O1000 names a program; with a word behind it, or a name, it calls or repeats a part of one.
  void refuse_call() const {
    std::size_t i = at_;
    while (i < text_.size() && (is_digit(text_[i]) || text_[i] == ' ')) ++i;
    if (i < text_.size() && (text_[i] == '<' || is_alpha(text_[i])))
      fail_("O-words that call, repeat or choose are not read");
  }

  std::string_view text_;
  GcodeExponent exponent_;
  const std::function<void(const std::string&)>& fail_;
  GcodeBlock block_;
  std::size_t at_ = 0;
  bool done_ = false, any_word_ = false;
};

}  // namespace

bool GcodeBlock::has_g(double code) const { return std::ranges::find(g, code) != g.end(); }
bool GcodeBlock::has_m(double code) const { return std::ranges::find(m, code) != m.end(); }

GcodeBlock read_gcode_block(std::string_view line, GcodeExponent exponent,
                            const std::function<void(const std::string&)>& fail) {
  return BlockReader(line, exponent, fail).read();
}

}  // namespace firn
