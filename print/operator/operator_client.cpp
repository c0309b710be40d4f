#include "print/operator/operator_client.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "files/usage_error.h"
#include "print/operator/operator_desk.h"
#include "runtime/socket_address.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// @returns -1 with errno
int connect_to(const fs::path& socket) {
  const SocketAddress address(socket);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd >= 0 && ::connect(fd, address.get(), sizeof(sockaddr_un)) != 0) {
    const int error = errno;
    ::close(fd);
    errno = error;
    return -1;
  }
  return fd;
}

}  // namespace

OperatorClient::OperatorClient(const fs::path& run) {
  if (!fs::exists(run / "provenance.json")) throw UsageError(run.string() + ": is no run folder");
  fd_ = connect_to(operator_socket(run));
  if (fd_ >= 0) return;
  const bool nobody = errno == ENOENT || errno == ECONNREFUSED;
  throw UsageError(run.string() + (nobody ? ": is not running; firn print --resume " + run.string() +
                                                " goes on with an unfinished print"
                                          : ": cannot be reached: " + std::string(std::strerror(errno))));
}

OperatorClient::~OperatorClient() {
  if (fd_ >= 0) ::close(fd_);
}

bool OperatorClient::answers(const fs::path& run) {
  const int fd = connect_to(operator_socket(run));
  if (fd >= 0) ::close(fd);
  return fd >= 0;
}

void OperatorClient::say(const std::string& line) {
  const std::string text = line + "\n";
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t sent = ::send(fd_, text.data() + at, text.size() - at, MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR)
      throw std::runtime_error(std::string("the print is gone: ") + std::strerror(errno));
    if (sent > 0) at += std::size_t(sent);
  }
}

void OperatorClient::send(const OperatorOrder& order) {
  say(std::to_string(order.id) + " " + to_text(order));
}

std::optional<std::string> OperatorClient::next(double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    if (const auto end = buffer_.find('\n'); end != std::string::npos) {
      std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return line;
    }
    const std::chrono::duration<double, std::milli> left = until - std::chrono::steady_clock::now();
    pollfd ready{fd_, POLLIN, 0};
    if (closed_ || ::poll(&ready, 1, std::max(0, int(left.count()))) <= 0) return std::nullopt;
    char chunk[4096];
    const ssize_t got = ::recv(fd_, chunk, sizeof chunk, 0);
    if (got > 0)
      buffer_.append(chunk, std::size_t(got));
    else if (got == 0 || errno != EINTR)
      closed_ = true;
  }
}

}  // namespace firn
