#include "print/operator/key_reader.h"

#include <poll.h>
#include <unistd.h>

namespace firn {

KeyReader::KeyReader() {
  if (!::isatty(STDIN_FILENO) || !::isatty(STDERR_FILENO) || ::tcgetpgrp(STDIN_FILENO) != ::getpgrp() ||
      ::tcgetattr(STDIN_FILENO, &before_) != 0)
    return;
  termios keys = before_;
  keys.c_lflag &= ~tcflag_t(ICANON | ECHO);
  keys.c_cc[VMIN] = 0;
  keys.c_cc[VTIME] = 0;
  if (::tcsetattr(STDIN_FILENO, TCSANOW, &keys) == 0) fd_ = STDIN_FILENO;
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

std::optional<OperatorOrder> KeyReader::order_of(char key) {
  const auto order = [](OperatorVerb verb) { return OperatorOrder{new_order_id(), verb, {}, {}}; };
  switch (key) {
    case 'p':
      return order(OperatorVerb::kPause);
    case 'c':
      return order(OperatorVerb::kContinue);
    case 'f':
      return order(OperatorVerb::kFinishLayer);
    case 'S':
      return order(OperatorVerb::kStop);
    default:
      return std::nullopt;
  }
}

}  // namespace firn
