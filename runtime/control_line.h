// ControlLine sends and reads lines over the socket pair of launcher and process. Down: "KEY <64 digits>"
// unless the bus has none, "START", "CLOCK <ns of CLOCK_BOOTTIME> <node time there, us>" on a host that
// follows the launcher's clock, "STOP <cause>". Up: "READY", "FAULT <text>", "FINISH <status> <reason>",
// "ERROR <text>", "PORT <why an instrument's port is not open; nothing: all are>". End of file: the other
// side is gone.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace firn {

class ControlLine {
 public:
  /// Takes the descriptor over and makes it nonblocking. -1 = none: nothing comes, nothing goes.
  explicit ControlLine(int fd);
  ~ControlLine();
  ControlLine(ControlLine&& other) noexcept;
  ControlLine& operator=(ControlLine&&) = delete;
  void take(int fd);  ///< as in the constructor; the one held before is closed

  int fd() const { return fd_; }
  void say(std::string_view line);  ///< line breaks in it become blanks; never blocks for long, never throws
  std::optional<std::string> next();       ///< the next whole line; reads the waiting bytes
  bool closed() const { return closed_; }  ///< the other side has closed and all lines were taken

 private:
  int fd_;
  bool closed_ = false;
  std::string buffer_;
};

}  // namespace firn
