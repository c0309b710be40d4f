// LineWriter and WordReader write and read lines of words that end with `*`, a CRC-16 in four hex digits and
// CR LF: written into a fixed buffer, read in place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace firn::drivers {

/// Writes one line. After text that does not fit, overflow() is true and the line must not be used.
class LineWriter {
 public:
  static constexpr std::size_t kLongest = 120;  ///< characters with CR LF

  LineWriter& text(std::string_view text);
  LineWriter& number(std::int64_t value);
  LineWriter& word(std::string_view text) { return this->text(" ").text(text); }
  LineWriter& word(std::int64_t value) { return text(" ").number(value); }
  /// `*`, CRC of everything from character `from` on, CR LF. @returns the whole line.
  std::string_view finish(std::size_t from);

  std::string_view so_far() const { return {line_.data(), size_}; }
  /// Characters that can still be written before finish().
  std::size_t room() const { return kLongest - kEnd - size_; }
  void cut(std::size_t size) { size_ = size; }
  bool overflow() const { return overflow_; }

 private:
  static constexpr std::size_t kEnd = 7;

  std::array<char, kLongest> line_;
  std::size_t size_ = 0;
  bool overflow_ = false;
};

/// The text of a line (with or without CR LF) from character `from` on, if the CRC at its end is right.
std::optional<std::string_view> checked_text(std::string_view line, std::size_t from);

/// Reads words from the left.
class WordReader {
 public:
  explicit WordReader(std::string_view text, char between = ' ') : rest_(text), between_(between) {}
  std::string_view word();  ///< empty at the end
  /// A whole word that is a number within [low, high]; otherwise good() is false from then on.
  std::int64_t number(std::int64_t low, std::int64_t high);
  bool good() const { return good_; }
  bool at_end() const { return rest_.empty(); }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  char between_;
  bool good_ = true;
};

}  // namespace firn::drivers
