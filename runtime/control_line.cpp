#include "runtime/control_line.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace firn {
namespace {

constexpr int kPatienceMs = 1000;  // for a reader that does not read

}  // namespace

ControlLine::ControlLine(int fd) : fd_(-1) { take(fd); }

void ControlLine::take(int fd) {
  if (fd_ >= 0) ::close(fd_);
  fd_ = fd;
  if (fd_ < 0) return;
  ::fcntl(fd_, F_SETFL, ::fcntl(fd_, F_GETFL) | O_NONBLOCK);
  ::fcntl(fd_, F_SETFD, FD_CLOEXEC);
}

ControlLine::~ControlLine() {
  if (fd_ >= 0) ::close(fd_);
}

ControlLine::ControlLine(ControlLine&& o) noexcept
    : fd_(std::exchange(o.fd_, -1)), closed_(o.closed_), buffer_(std::move(o.buffer_)) {}

void ControlLine::say(std::string_view line) {
  if (fd_ < 0) return;
  std::string text(line);
  std::replace(text.begin(), text.end(), '\n', ' ');
  text += '\n';
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t sent = ::send(fd_, text.data() + at, text.size() - at, MSG_NOSIGNAL);
    if (sent > 0) {
      at += std::size_t(sent);
    } else if (errno == EAGAIN) {
      pollfd p{fd_, POLLOUT, 0};
      if (::poll(&p, 1, kPatienceMs) <= 0) return;
    } else if (errno != EINTR) {
      return;
    }
  }
}

std::optional<std::string> ControlLine::next() {
  for (;;) {
    if (const auto end = buffer_.find('\n'); end != std::string::npos) {
      std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return line;
    }
    if (fd_ < 0 || closed_) return std::nullopt;
    char chunk[4096];
    const ssize_t got = ::recv(fd_, chunk, sizeof chunk, 0);
    if (got > 0) {
      buffer_.append(chunk, std::size_t(got));
    } else if (got < 0 && errno == EINTR) {
      continue;
    } else {
      if (got == 0 || errno != EAGAIN) closed_ = true;
      return std::nullopt;
    }
  }
}

}  // namespace firn
