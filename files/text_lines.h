// TextLines reads a text file line by line, whichever program wrote it: ASCII, UTF-8 or UTF-16, with or
// without a byte order mark; lines that end with LF, CR LF or CR.
#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <string_view>

#include "files/byte_blocks.h"

namespace firn {

class TextLines {
 public:
  /// @param name of the file, for errors @param longest_bytes of a line, in UTF-8
  TextLines(std::istream& in, std::string name, std::size_t longest_bytes);

  /// Reads the next line, in UTF-8 and without its end, valid until the next call. Returns false behind the
  /// last line. @throws UsageError: a line longer than the limit
  bool next(std::string_view& line);

  std::int64_t number() const { return number_; }  ///< of the line that was read last, from 1
  /// Share of a file of so many bytes that has been read, 0 to 1; 0 of an empty file.
  double fraction(double file_bytes) const;
  /// @throws UsageError "<name>:<line>: <problem>"
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  enum class Encoding { kBytes, kUtf16Little, kUtf16Big };

  void detect_encoding();
  bool next_of_bytes(std::string_view& line);
  bool next_of_utf16(std::string_view& line);
  int unit(std::size_t n);
  [[noreturn]] void fail_long() const;

  ByteBlocks in_;
  std::string name_;
  std::size_t longest_, used_ = 0;  // used_: bytes of the line that was handed out
  std::int64_t number_ = 0;
  Encoding encoding_ = Encoding::kBytes;
  std::string decoded_;
};

/// Text of a file as a message may show it: printable ASCII, at most so many characters.
std::string shown_text(std::string_view text, std::size_t most = 40);

}  // namespace firn
