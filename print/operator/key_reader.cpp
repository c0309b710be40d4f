#include "print/operator/key_reader.h"

#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <utility>

namespace firn {

KeyReader::KeyReader() {
  if (!::isatty(STDIN_FILENO) || !::isatty(STDERR_FILENO) || ::tcgetpgrp(STDIN_FILENO) != ::getpgrp() ||
      ::tcgetattr(STDIN_FILENO, &before_) != 0)
    return;
  termios keys = before_;
  keys.c_lflag &= ~tcflag_t(ICANON | ECHO);
  keys.c_cc[VMIN] = 0;
  keys.c_cc[VTIME] = 0;
  if (::tcsetattr(STDIN_FILENO, TCSAFLUSH, &keys) == 0) fd_ = STDIN_FILENO;
}

KeyReader::~KeyReader() {
  if (fd_ >= 0) ::tcsetattr(fd_, TCSANOW, &before_);
}

std::optional<char> KeyReader::next() {
  pollfd ready{fd_, POLLIN, 0};
  char key = 0;
  if (fd_ < 0 || ::poll(&ready, 1, 0) <= 0) return std::nullopt;
  if (::read(fd_, &key, 1) == 1) return key;
  ::tcsetattr(fd_, TCSANOW, &before_);
  fd_ = -1;  // the terminal is gone, or another job has it
  return std::nullopt;
}

KeyPress KeyReader::press(char key, double now_s) {
  const auto order = [](OperatorVerb verb) {
    return KeyPress{OperatorOrder{new_order_id(), verb, {}, {}}, {}};
  };
  const bool twice = std::exchange(once_, 0) == key && now_s - once_s_ <= kTwiceWithin_s;
  switch (key) {
    case 'p':
      return order(OperatorVerb::kPause);
    case 'c':
      return order(OperatorVerb::kContinue);
    case 'f':
    case 'S':
      if (twice) return order(key == 'f' ? OperatorVerb::kFinishLayer : OperatorVerb::kStop);
      once_ = key;
      once_s_ = now_s;
      return {{},
              std::string("press ") + key +
                  (key == 'f' ? " again: this layer is finished, then the print ends"
                              : " again: the lab is stopped at once")};
    default:
      return {{}, std::string(kHelp)};
  }
}

KeyPress KeyReader::press(char key) {
  return press(key,
               std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count());
}

}  // namespace firn
