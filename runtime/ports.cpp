#include "runtime/ports.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace firn {
namespace {

constexpr std::int64_t kRetryUs = 50'000;
constexpr std::size_t kMostWaiting = std::size_t(4)
                                     << 20;  // an instrument that reads nothing is not worth more

/// The address of a Unix socket. It holds 107 bytes; a longer path is reached through its open folder.
class SocketAddress {
 public:
  explicit SocketAddress(const std::filesystem::path& path) {
    address_.sun_family = AF_UNIX;
    std::string text = path.string();
    if (text.size() >= sizeof address_.sun_path) {
      folder_ = ::open(path.parent_path().c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
      text = "/proc/self/fd/" + std::to_string(folder_) + "/" + path.filename().string();
    }
    if (text.size() >= sizeof address_.sun_path)
      throw std::runtime_error(path.string() + ": too long for the name of a Unix socket");
    std::memcpy(address_.sun_path, text.c_str(), text.size());
  }
  ~SocketAddress() {
    if (folder_ >= 0) ::close(folder_);
  }
  SocketAddress(const SocketAddress&) = delete;
  SocketAddress& operator=(const SocketAddress&) = delete;
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address_); }

 private:
  sockaddr_un address_{};
  int folder_ = -1;  // -1 as well when there is no such folder: nobody listens there
};

/// @returns -1 if nobody listens there.
int connect_to(const std::string& path) {
  const SocketAddress address(path);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) throw std::runtime_error(std::string("socket: ") + std::strerror(errno));
  if (::connect(fd, address.get(), sizeof(sockaddr_un)) != 0) {
    ::close(fd);
    return -1;
  }
  return fd;
}

}  // namespace

Ports::Ports(std::vector<std::string> paths, LeaseLoss lease_loss) : lease_loss_(std::move(lease_loss)) {
  for (std::string& path : paths) ports_.emplace_back().path = std::move(path);
}

Ports::~Ports() {
  for (Port& p : ports_) close(p);
}

void Ports::open_all(std::int64_t wall_us) {
  for (Port& p : ports_) p.connect_at_us = wall_us;
}

void Ports::write(PortId port, std::span<const std::byte> bytes, bool of_command) {
  Port& p = ports_.at(std::size_t(port));
  if (p.fd < 0) return;  // the driver was told that the link is closed
  if (p.waiting_bytes + bytes.size() > kMostWaiting) {
    close(p);
    p.tell_closed = true;
    return;
  }
  p.waiting.push_back({{bytes.begin(), bytes.end()}, 0, of_command});
  p.waiting_bytes += bytes.size();
  flush(p);
}

void Ports::reopen(PortId port, std::int64_t wall_us) {
  Port& p = ports_.at(std::size_t(port));
  p.tell_closed = p.tell_closed || p.fd >= 0;
  close(p);
  p.connect_at_us = wall_us;
}

void Ports::add_to(std::vector<pollfd>& fds) const {
  for (const Port& p : ports_)
    if (p.fd >= 0) fds.push_back({p.fd, short(POLLIN | (p.waiting.empty() ? 0 : POLLOUT)), 0});
}

void Ports::service(std::int64_t wall_us, const OnLink& on_link, const OnBytes& on_bytes) {
  for (std::size_t n = 0; n < ports_.size(); ++n) {
    Port& p = ports_[n];
    const PortId id = PortId(n);
    if (p.tell_closed) {
      p.tell_closed = false;
      on_link(id, LinkState::kClosed);
    }
    if (p.fd < 0 && wall_us >= p.connect_at_us) {
      p.fd = connect_to(p.path);
      p.connect_at_us = p.fd < 0 ? wall_us + kRetryUs : INT64_MAX;
      if (p.fd >= 0) on_link(id, LinkState::kOpen);
    }
    if (p.fd < 0) continue;
    flush(p);
    std::byte buffer[16384];
    while (p.fd >= 0) {
      const ssize_t got = ::recv(p.fd, buffer, sizeof buffer, 0);
      if (got > 0) {
        on_bytes(id, std::span(buffer, std::size_t(got)));
      } else if (got < 0 && (errno == EAGAIN || errno == EINTR)) {
        break;
      } else {
        close(p);
        on_link(id, LinkState::kClosed);
      }
    }
    if (p.tell_closed) {
      p.tell_closed = false;
      on_link(id, LinkState::kClosed);
    }
  }
}

void Ports::take_refused(const OnRefused& on_refused) {
  for (std::size_t n = 0; n < ports_.size(); ++n)
    if (const std::string cause = std::exchange(ports_[n].refused, {}); !cause.empty())
      on_refused(PortId(n), cause);
}

std::int64_t Ports::due_us() const {
  std::int64_t due = INT64_MAX;
  for (const Port& p : ports_) due = std::min(due, p.tell_closed ? 0 : p.connect_at_us);
  return due;
}

void Ports::close(Port& p) {
  if (p.fd >= 0) ::close(p.fd);
  p.fd = -1;
  p.waiting.clear();
  p.waiting_bytes = 0;
}

void Ports::flush(Port& p) {
  while (p.fd >= 0 && !p.waiting.empty()) {
    Waiting& w = p.waiting.front();
    if (std::string loss = w.of_command && lease_loss_ ? lease_loss_() : ""; !loss.empty()) {
      p.refused = std::move(loss);
      if (w.sent > 0) {
        close(p);
        p.tell_closed = true;
        return;
      }
      p.waiting_bytes -= w.bytes.size();
      p.waiting.pop_front();
      continue;
    }
    const ssize_t sent = ::send(p.fd, w.bytes.data() + w.sent, w.bytes.size() - w.sent, MSG_NOSIGNAL);
    if (sent > 0) {
      w.sent += std::size_t(sent);
      if (w.sent == w.bytes.size()) {
        p.waiting_bytes -= w.bytes.size();
        p.waiting.pop_front();
      }
    } else if (errno == EAGAIN || errno == EINTR) {
      return;
    } else {
      close(p);
      p.tell_closed = true;
    }
  }
}

}  // namespace firn
