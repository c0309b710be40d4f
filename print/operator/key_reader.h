// KeyReader reads single keys of the terminal of a print: orders of the operator without firn ctl.
#pragma once

#include <termios.h>

#include <optional>
#include <string_view>

#include "print/operator/operator_order.h"

namespace firn {

/// While this lives, the terminal hands over each key at once and does not show it; Ctrl-C works as before.
/// Without a terminal on stdin and stderr, or in the background, there are no keys.
class KeyReader {
 public:
  KeyReader();
  ~KeyReader();
  KeyReader(const KeyReader&) = delete;
  KeyReader& operator=(const KeyReader&) = delete;

  int fd() const { return fd_; }  ///< readable when a key was pressed; -1: there are none
  /// Returns the next key that was pressed; does not block.
  std::optional<char> next();

  static constexpr std::string_view kHelp =
      "keys: p pause, c continue, f finish this layer and end, S stop at once; Ctrl-C makes the lab safe";
  /// Returns the order of a key; nothing for any other key.
  static std::optional<OperatorOrder> order_of(char key);

 private:
  int fd_ = -1;
  termios before_{};
};

}  // namespace firn
