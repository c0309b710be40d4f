// KeyReader reads single keys of the terminal of a print: orders of the operator without firn ctl.
#pragma once

#include <termios.h>

#include <optional>
#include <string>
#include <string_view>

#include "print/operator/operator_order.h"

namespace firn {

/// Holds the meaning of a pressed key: an order, or a sentence for the user.
struct KeyPress {
  std::optional<OperatorOrder> order;
  std::string hint;
};

/// While this lives, the terminal hands over each key at once and does not show it; Ctrl-C works as before.
/// Keys that were typed ahead of it are dropped. Without a terminal on stdin and stderr, or in the
/// background, there are no keys.
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
      "keys: p pause, c continue; twice: ff finish this layer and end, SS stop at once; Ctrl-C makes the lab "
      "safe";
  static constexpr double kTwiceWithin_s = 3.0;
  /// Takes a key. What ends the print wants the key twice, and nothing between: a key meant for another
  /// window ends no print of hours. @param now_s of a steady clock
  KeyPress press(char key, double now_s);
  KeyPress press(char key);  ///< now

 private:
  int fd_ = -1;
  termios before_{};
  char once_ = 0;  // a key that waits for its second press
  double once_s_ = 0.0;
};

}  // namespace firn
