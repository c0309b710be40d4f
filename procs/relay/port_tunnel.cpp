#include "procs/relay/port_tunnel.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "runtime/socket_address.h"

namespace firn::relay {
namespace {

constexpr std::size_t kPieceBytes = 16 << 10;
constexpr std::size_t kPiecesAtOnce = 8;
constexpr std::size_t kMostWaitingInLink = std::size_t(1) << 20;  // beyond it bytes wait in the sockets
constexpr std::size_t kMostWaitingHere = std::size_t(8) << 20;    // for a program that reads nothing

}  // namespace

PortTunnel::PortTunnel(Side side, std::filesystem::path folder, const std::vector<std::string>& ports,
                       Link& link)
    : side_(side), folder_(std::move(folder)), link_(link) {
  for (const std::string& port : ports) cables_.push_back({.port = port, .waiting = {}});
  if (side_ == Side::kInstruments) return;
  std::filesystem::create_directories(folder_);
  for (Cable& c : cables_) listen(c);
}

PortTunnel::~PortTunnel() {
  for (Cable& c : cables_) {
    close(c);
    if (c.listener < 0) continue;
    ::close(c.listener);
    ::unlink((folder_ / c.port).c_str());
  }
}

void PortTunnel::listen(Cable& c) {
  const std::filesystem::path path = folder_ / c.port;
  ::unlink(path.c_str());
  const SocketAddress address(path);
  c.listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (c.listener < 0 || ::bind(c.listener, address.get(), sizeof(sockaddr_un)) != 0 ||
      ::listen(c.listener, 1) != 0)
    throw std::runtime_error(path.string() + ": no port of a simulated instrument: " + std::strerror(errno));
}

void PortTunnel::connect(Cable& c) {
  const SocketAddress address(folder_ / c.port);
  c.fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (c.fd >= 0 && ::connect(c.fd, address.get(), sizeof(sockaddr_un)) == 0) return;
  close(c);
  send(c, {});
}

void PortTunnel::close(Cable& c) {
  if (c.fd >= 0) ::close(c.fd);
  c.fd = -1;
  c.waiting.clear();
  c.ends = false;
}

// A piece without bytes begins a connection that is new and ends one that is not.
void PortTunnel::send(Cable& c, std::span<const std::byte> bytes) {
  link_.send({FrameKind::kPort, c.port, ++c.sent, c.connection, bytes});
}

bool PortTunnel::has_room() const { return link_.waiting_bytes() < kMostWaitingInLink; }

void PortTunnel::add_to(std::vector<pollfd>& fds) const {
  const short reads = has_room() ? POLLIN : 0;
  for (const Cable& c : cables_) {
    if (c.fd >= 0)
      fds.push_back({c.fd, short((c.ends ? 0 : reads) | (c.waiting.empty() ? 0 : POLLOUT)), 0});
    else if (c.listener >= 0)
      fds.push_back({c.listener, POLLIN, 0});
  }
}

void PortTunnel::service() {
  for (Cable& c : cables_) {
    if (c.fd >= 0) {
      write(c);
      if (!c.ends) read(c);
    }
    if (c.fd >= 0 || c.listener < 0) continue;
    c.fd = ::accept4(c.listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (c.fd < 0) continue;
    ++c.connection;
    send(c, {});
  }
}

void PortTunnel::read(Cable& c) {
  std::array<std::byte, kPieceBytes> piece;
  for (std::size_t n = 0; n < kPiecesAtOnce && c.fd >= 0 && has_room(); ++n) {
    const ssize_t got = ::recv(c.fd, piece.data(), piece.size(), MSG_DONTWAIT);
    if (got > 0) {
      send(c, std::span(piece).first(std::size_t(got)));
    } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
      close(c);
      send(c, {});
    } else if (errno == EAGAIN) {
      return;
    }
  }
}

void PortTunnel::write(Cable& c) {
  std::size_t gone = 0;
  while (gone < c.waiting.size()) {
    const ssize_t put =
        ::send(c.fd, c.waiting.data() + gone, c.waiting.size() - gone, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0 && errno != EAGAIN) {  // its last words are still to be read, and then its end
      gone = c.waiting.size();
      break;
    }
    if (put < 0) break;
    gone += std::size_t(put);
  }
  c.waiting.erase(c.waiting.begin(), c.waiting.begin() + std::ptrdiff_t(gone));
  if (c.ends && c.waiting.empty()) close(c);
}

void PortTunnel::take(const Frame& f) {
  const auto c = std::ranges::find(cables_, f.name, &Cable::port);
  if (c == cables_.end() || f.number != c->taken + 1) return;
  ++c->taken;
  if (side_ == Side::kInstruments && f.second > c->connection) {
    close(*c);
    c->connection = f.second;
    connect(*c);
    return;
  }
  if (f.second != c->connection || c->fd < 0 || c->ends) return;
  if (f.bytes.empty()) {
    c->ends = true;
  } else {
    c->waiting.insert(c->waiting.end(), f.bytes.begin(), f.bytes.end());
  }
  write(*c);
  if (c->waiting.size() <= kMostWaitingHere) return;
  close(*c);
  send(*c, {});
}

}  // namespace firn::relay
