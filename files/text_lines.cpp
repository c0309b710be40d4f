#include "files/text_lines.h"

#include <algorithm>
#include <utility>

#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::string_view kUtf8Mark = "\xef\xbb\xbf", kUtf16LittleMark = "\xff\xfe",
                           kUtf16BigMark = "\xfe\xff";
constexpr char32_t kReplacement = 0xfffd;

void append_utf8(char32_t c, std::string& to) {
  if (c < 0x80) {
    to += char(c);
  } else if (c < 0x800) {
    to += char(0xc0 | (c >> 6));
    to += char(0x80 | (c & 0x3f));
  } else if (c < 0x10000) {
    to += char(0xe0 | (c >> 12));
    to += char(0x80 | ((c >> 6) & 0x3f));
    to += char(0x80 | (c & 0x3f));
  } else {
    to += char(0xf0 | (c >> 18));
    to += char(0x80 | ((c >> 12) & 0x3f));
    to += char(0x80 | ((c >> 6) & 0x3f));
    to += char(0x80 | (c & 0x3f));
  }
}

}  // namespace

TextLines::TextLines(std::istream& in, std::string name, std::size_t longest_bytes)
    : in_(in), name_(std::move(name)), longest_(longest_bytes) {
  detect_encoding();
}

double TextLines::fraction(double file_bytes) const {
  return file_bytes > 0.0 ? std::min(1.0, double(in_.position() + used_) / file_bytes) : 0.0;
}

void TextLines::fail(const std::string& problem) const {
  throw UsageError(name_ + ":" + std::to_string(number_) + ": " + problem);
}

void TextLines::fail_long() const {
  fail("a line longer than the limit of " + std::to_string(longest_) + " bytes");
}

/// By the byte order mark, or by the NUL that every ASCII character has in UTF-16.
void TextLines::detect_encoding() {
  while (in_.size() < 3 && in_.more()) {
  }
  const std::string_view head(in_.begin(), std::min<std::size_t>(in_.size(), 3));
  if (head.starts_with(kUtf8Mark)) {
    in_.take(kUtf8Mark.size());
  } else if (head.starts_with(kUtf16LittleMark) || head.starts_with(kUtf16BigMark)) {
    encoding_ = head.starts_with(kUtf16LittleMark) ? Encoding::kUtf16Little : Encoding::kUtf16Big;
    in_.take(2);
  } else if (head.size() > 1 && (head[0] == '\0') != (head[1] == '\0')) {
    encoding_ = head[1] == '\0' ? Encoding::kUtf16Little : Encoding::kUtf16Big;
  }
}

bool TextLines::next(std::string_view& line) {
  in_.take(std::exchange(used_, 0));
  ++number_;
  return encoding_ == Encoding::kBytes ? next_of_bytes(line) : next_of_utf16(line);
}

bool TextLines::next_of_bytes(std::string_view& line) {
  std::size_t length = 0;
  const auto ends = [](char c) { return c == '\n' || c == '\r'; };
  do {
    while (length < in_.size() && !ends(in_.begin()[length])) ++length;
  } while (length == in_.size() && length <= longest_ && in_.more());
  if (length > longest_) fail_long();
  used_ = length;
  if (length == in_.size() && length == 0) return false;
  // CR, CR LF, or CR CR LF, which is CR LF written as text twice
  std::size_t returns = 0;
  const auto at = [&](std::size_t n) {
    while (n >= in_.size() && in_.more()) {
    }
    return n < in_.size() ? in_.begin()[n] : '\0';
  };
  while (returns < 3 && at(length + returns) == '\r') ++returns;
  if (at(length + returns) == '\n')
    used_ += returns + 1;
  else
    used_ += std::min<std::size_t>(returns, 1);
  line = std::string_view(in_.begin(), length);
  return true;
}

/// The n-th 16-bit unit from here; -1 behind the end. A last odd byte is no unit.
int TextLines::unit(std::size_t n) {
  while (in_.size() < 2 * n + 2 && in_.more()) {
  }
  if (in_.size() < 2 * n + 2) return -1;
  const auto byte = [&](std::size_t k) { return int(static_cast<unsigned char>(in_.begin()[2 * n + k])); };
  return encoding_ == Encoding::kUtf16Little ? byte(0) | byte(1) << 8 : byte(0) << 8 | byte(1);
}

bool TextLines::next_of_utf16(std::string_view& line) {
  if (unit(0) < 0) return false;
  decoded_.clear();
  std::size_t n = 0;
  for (;; ++n) {
    const int c = unit(n);
    if (c < 0 || c == '\n' || c == '\r') break;
    const bool high = c >= 0xd800 && c < 0xdc00, low = c >= 0xdc00 && c < 0xe000;
    const int second = high ? unit(n + 1) : -1;
    if (second >= 0xdc00 && second < 0xe000) {
      append_utf8(char32_t(0x10000 + ((c - 0xd800) << 10) + (second - 0xdc00)), decoded_);
      ++n;
    } else {
      append_utf8(high || low ? kReplacement : char32_t(c), decoded_);
    }
    if (decoded_.size() > longest_) fail_long();
  }
  if (unit(n) == '\r' && unit(n + 1) == '\n')
    n += 2;
  else if (unit(n) >= 0)
    ++n;
  used_ = 2 * n;
  line = decoded_;
  return true;
}

std::string shown_text(std::string_view text, std::size_t most) {
  std::string shown(text.substr(0, most));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

}  // namespace firn
