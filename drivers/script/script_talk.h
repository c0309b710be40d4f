// ScriptTalk holds the conversation with a driver class in Python: lines of text over one port, to the
// program that runs the class (runtime/python_child.h) and back. docs/write-a-driver.md describes the class.
//
//   to the program    begin N FILE CLASS :ARGUMENTS LINE METHOD...
//                                                        imports the class; LINE 1: bytes pass through Firn
//                     call N LIMIT METHOD name=1,2 ...           one method, within LIMIT s; "connect"
//                     constructs
//                                                                a name with a '*' before it is a list
//                     stop N LIMIT                               breaks off the running call, then calls
//                     safe() line 0|1    bytes 4f4b0a                   of the instrument's port
//   from the program  done N :TEXT name=1,2 ...                  the call has returned
//                     fail N KIND :TEXT                          it has raised
//                     write N 4f4b0a                             bytes for the instrument, of call N
//                     note :TEXT
//
// A text has every byte but letters, digits and "_.-/" as %XX. One call runs at a time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/link/dialect.h"

namespace firn::drivers::script {

using Values = std::map<std::string, std::vector<double>, std::less<>>;

/// A line of the program.
struct Line {
  enum class Kind : std::uint8_t { kDone, kFailed, kWrite, kNote };
  /// Of a failure: the class raised firn.Refused, was broken off, waited for the instrument in vain, or
  /// anything else.
  enum class Why : std::uint8_t { kRefused, kStopped, kLate, kError };
  Kind kind = Kind::kNote;
  Why why = Why::kError;
  std::int32_t call = 0;
  std::string text;
  Values values;
  std::vector<std::byte> bytes;  ///< of kWrite

  /// A number of the answer; NaN: the class returned none of that name.
  double number(std::string_view name) const;
};

/// Returns the line in its parts, given without its end; nothing: it is none of the program's.
std::optional<Line> parse_line(std::string_view line);

std::string encode_text(std::string_view text);
/// Returns nothing for a text with a broken %XX.
std::optional<std::string> decode_text(std::string_view text);

/// Returns "call 7 1.5 on percent=80\n". Doubles are written so that they are read back exactly.
std::string call_line(std::int32_t call, double limit_s, std::string_view method, const Values& arguments);
std::string begin_line(std::int32_t call, std::string_view file, std::string_view class_name,
                       std::string_view arguments, bool line, std::span<const std::string_view> methods);
std::string stop_line(std::int32_t call, double limit_s);
std::string line_line(bool open);
std::string bytes_line(std::span<const std::byte> bytes);

/// Requests are a call's number (Request::argument) whose line is kept here until it is sent.
class ScriptDialect final : public Dialect {
 public:
  ScriptDialect();
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override { return {}; }  ///< never asked: a call without an answer ends the program
  void write(const Request& request, std::vector<std::byte>& tx) const override;

  /// Returns the request that sends `line`, whose number is `call`.
  Request request(std::int32_t call, std::string line, std::uint16_t tag);

 private:
  mutable std::map<std::int32_t, std::string> lines_;  // not sent yet
};

}  // namespace firn::drivers::script
