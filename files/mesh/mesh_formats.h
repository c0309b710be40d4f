// read_stl, read_ply, read_obj and read_3mf read the formats of files/mesh/mesh_file.h, one source each.
#pragma once

#include <span>
#include <string>

#include "files/mesh/mesh_file.h"

namespace firn::mesh {

using Bytes = std::span<const std::byte>;

MeshData read_stl(Bytes bytes, const std::string& name, FacetCount count);
MeshData read_ply(Bytes bytes, const std::string& name, FacetCount count);
MeshData read_obj(Bytes bytes, const std::string& name);
MeshData read_3mf(Bytes bytes, const std::string& name);

/// Ends the message of a file whose header and size disagree: how one of them is chosen.
inline constexpr const char* kChooseCount =
    "write the file anew, or choose with mesh.facet_count = \"header\" or \"file\" in the settings of firn "
    "slice";

[[noreturn]] void fail_at_byte(const std::string& name, std::size_t byte, const std::string& problem);
/// @throws unless `facets` is within kMaxFacets
void check_count(const std::string& name, std::size_t byte, std::size_t facets);

/// @throws UsageError: UTF-16, with a byte order mark or without
void check_encoding(std::string_view text, const std::string& name);
/// @throws UsageError: lines that end by carriage returns alone
void check_text_form(std::string_view text, const std::string& name);
/// Skips the mark of UTF-8.
Bytes without_byte_order_mark(Bytes bytes);

/// Cursor over the words and numbers of a text, without copies.
class TextCursor {
 public:
  TextCursor(std::string_view text, const std::string& name, std::size_t first_line = 1)
      : begin_(text.data()), at_(begin_), end_(begin_ + text.size()), name_(name), first_line_(first_line) {}

  [[noreturn]] void fail(const std::string& problem) const;  ///< at the line of the last word

  /// The next word behind blanks and line ends; empty at the end.
  std::string_view word() {
    while (at_ != end_ && static_cast<unsigned char>(*at_) <= ' ') ++at_;
    return rest_of_word();
  }
  /// The next word of this line; empty at its end.
  std::string_view word_in_line() {
    while (at_ != end_ && static_cast<unsigned char>(*at_) <= ' ' && *at_ != '\n') ++at_;
    return rest_of_word();
  }
  void skip_line() {
    while (at_ != end_ && *at_ != '\n') ++at_;
    if (at_ != end_) ++at_;
  }
  /// Returns a word as a number; nan and inf are numbers, and values too large for a double are infinite.
  /// @throws UsageError
  double number(std::string_view word, const char* what) const;
  /// Returns a word as a whole number within 64 bits. @throws UsageError
  std::int64_t whole(std::string_view word, const char* what) const;

  bool ended() const { return at_ == end_; }
  /// The line of a byte of the text.
  std::size_t line_of(std::size_t offset) const;
  std::size_t offset() const { return std::size_t(at_ - begin_); }
  std::size_t left() const { return std::size_t(end_ - at_); }
  std::string_view rest() const { return {at_, left()}; }

 private:
  std::string_view rest_of_word() {
    word_ = at_;
    while (at_ != end_ && static_cast<unsigned char>(*at_) > ' ') ++at_;
    return {word_, std::size_t(at_ - word_)};
  }

  const char *begin_, *at_, *end_, *word_ = begin_;
  const std::string& name_;
  std::size_t first_line_;
};

inline std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace firn::mesh
