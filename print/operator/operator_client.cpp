#include "print/operator/operator_client.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "files/usage_error.h"
#include "print/operator/operator_desk.h"
#include "runs/folder/address.h"
#include "runs/folder/run_folder.h"
#include "runtime/socket_address.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr int kConnectWithin_s = 5, kTryEvery_ms = 20;

// @returns -1 with errno; EAGAIN: the print has not accepted those before
int connect_to(const fs::path& socket) {
  const SocketAddress address(socket);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd >= 0 && ::connect(fd, address.get(), sizeof(sockaddr_un)) != 0) {
    const int error = errno;
    ::close(fd);
    errno = error;
    return -1;
  }
  return fd;
}

}  // namespace

std::unique_ptr<OperatorClient> OperatorClient::try_connect(const fs::path& run, std::int64_t run_id) {
  runs::require_run(run);
  const int fd = connect_to(operator_socket(run));
  if (fd < 0 && errno == EAGAIN) return nullptr;
  if (fd < 0) {
    const bool nobody = errno == ENOENT || errno == ECONNREFUSED;
    throw UsageError(run.string() + (nobody ? ": is not running; firn print --resume " + run.string() +
                                                  " goes on with an unfinished print"
                                            : ": cannot be reached: " + std::string(std::strerror(errno))));
  }
  std::unique_ptr<OperatorClient> client(new OperatorClient(fd));
  // The desk refuses orders for another run, as where this folder took the place of one that was moved.
  if (run_id == 0) run_id = runs::address_of(run).run_id;
  if (run_id != 0) client->say("run " + std::to_string(run_id));
  return client;
}

OperatorClient::OperatorClient(const fs::path& run) {
  for (int n = 0; n < kConnectWithin_s * 1000 / kTryEvery_ms; ++n) {
    if (const auto client = try_connect(run)) {
      fd_ = std::exchange(client->fd_, -1);
      return;
    }
    ::poll(nullptr, 0, kTryEvery_ms);
  }
  throw UsageError(run.string() + ": the print accepts nobody: " + std::to_string(kConnectWithin_s) +
                   " s have passed");
}

OperatorClient::~OperatorClient() {
  if (fd_ >= 0) ::close(fd_);
}

bool OperatorClient::answers(const fs::path& run) {
  const int fd = connect_to(operator_socket(run));
  if (fd >= 0) ::close(fd);
  return fd >= 0;
}

std::string OperatorClient::state_of(const fs::path& run) try {
  constexpr std::string_view kState = "state ";
  if (const auto client = try_connect(run)) {
    client->say("state");
    if (const auto line = client->next(1.0); line && line->starts_with(kState))
      return line->substr(kState.size());
  }
  return "running";
} catch (const std::exception&) {
  return "running";
}

bool OperatorClient::await_end(const std::function<bool()>& interrupted,
                               const std::function<void(const std::string&)>& note) const {
  constexpr int kLook_ms = 100, kLooksBeforeNote = 20;
  ucred print{};
  socklen_t size = sizeof print;
  if (::getsockopt(fd_, SOL_SOCKET, SO_PEERCRED, &print, &size) != 0) return true;
  const int process = int(::syscall(SYS_pidfd_open, print.pid, 0));
  if (process < 0) return true;  // it has ended
  pollfd ended{process, POLLIN, 0};
  int looks = 0;
  while (!interrupted() && ::poll(&ended, 1, kLook_ms) <= 0)
    if (++looks == kLooksBeforeNote) note("the run folder is being sealed and packed");
  ::close(process);
  return ended.revents != 0;
}

void OperatorClient::say(const std::string& line) {
  const std::string text = line + "\n";
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t sent = ::send(fd_, text.data() + at, text.size() - at, MSG_NOSIGNAL);
    if (sent < 0 && errno == EAGAIN) {
      pollfd writable{fd_, POLLOUT, 0};
      if (::poll(&writable, 1, kConnectWithin_s * 1000) > 0) continue;
      throw std::runtime_error("the print takes nothing: 5 s have passed");
    }
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
    else if (got == 0 || (errno != EINTR && errno != EAGAIN))
      closed_ = true;
  }
}

}  // namespace firn
