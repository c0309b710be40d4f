#include "tests/drivers/real_wire.h"

#include <arpa/inet.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

namespace firn::drivers::test {
namespace {

bool comes(int fd, int within_ms) {
  pollfd p{fd, POLLIN, 0};
  return ::poll(&p, 1, within_ms) > 0;
}

constexpr int kPatience = 5000;  // turns of at most a millisecond

}  // namespace

RealWire::RealWire(Kind kind, const std::filesystem::path& name) : kind_(kind), name_(name) {
  if (kind == Kind::kTcp) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof a;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&a), sizeof a) != 0 || ::listen(listener_, 4) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&a), &size) != 0)
      throw std::runtime_error("cannot listen");
    tcp_port_ = ntohs(a.sin_port);
  }
  wire_.emplace(address());
}

RealWire::~RealWire() {
  for (const int fd : {far_, listener_})
    if (fd >= 0) ::close(fd);
}

PortAddress RealWire::address() const {
  return parse_port_address(kind_ == Kind::kTcp ? "tcp:127.0.0.1:" + std::to_string(tcp_port_)
                                                : "serial:" + name_.string() + "?baud=115200&open_wait_ms=0");
}

void RealWire::open() {
  wire_->close();
  if (kind_ == Kind::kTcp) {
    if (far_ >= 0) ::close(far_);
    far_ = -1;
  } else if (far_ < 0) {
    int slave = -1;
    char name[128];
    if (::openpty(&far_, &slave, name, nullptr, nullptr) != 0) throw std::runtime_error("openpty");
    ::close(slave);
    std::filesystem::remove(name_);
    std::filesystem::create_symlink(name, name_);
  }
  wire_->open(0);
  for (int n = 0; wire_->settle(n) == PortWire::State::kConnecting && n < kPatience; ++n)
    comes(wire_->fd(), 1);
  if (wire_->state() != PortWire::State::kOpen) throw std::runtime_error(wire_->trouble());
  if (kind_ == Kind::kTcp) far_ = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
}

void RealWire::end() {
  if (kind_ == Kind::kTcp) {
    const linger reset{1, 0};
    ::setsockopt(far_, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
  }
  ::close(far_);
  far_ = -1;
  std::byte bytes[256];
  std::size_t count = 0;
  for (int n = 0; n < kPatience; ++n) {
    if (wire_->read(bytes, count) == PortWire::Io::kLost) return wire_->close();
    comes(wire_->fd(), 1);
  }
  throw std::runtime_error("the host does not notice that the line has gone");
}

std::string RealWire::to_instrument(std::string_view bytes) {
  std::string out;
  std::size_t sent = 0;
  char got[4096];
  for (int n = 0; out.size() < bytes.size(); ++n) {
    std::size_t count = 0;
    if (sent < bytes.size() &&
        wire_->write(std::as_bytes(std::span(bytes.substr(sent))), count) == PortWire::Io::kDone)
      sent += count;
    if (!comes(far_, 1)) {
      if (n > kPatience) throw std::runtime_error("bytes are lost on their way to the instrument");
      continue;
    }
    if (const ssize_t size = ::read(far_, got, sizeof got); size > 0) out.append(got, std::size_t(size));
  }
  return out;
}

std::string RealWire::to_host(std::string_view bytes) {
  std::string out;
  std::size_t sent = 0;
  std::byte got[4096];
  for (int n = 0; out.size() < bytes.size(); ++n) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - sent, 1024);
    if (part > 0)
      if (const ssize_t size = ::write(far_, bytes.data() + sent, part); size > 0) sent += std::size_t(size);
    comes(wire_->fd(), 1);
    std::size_t count = 0;
    if (wire_->read(got, count) == PortWire::Io::kDone)
      out.append(reinterpret_cast<const char*>(got), count);
    else if (n > kPatience)
      throw std::runtime_error("bytes are lost on their way to the host");
  }
  return out;
}

}  // namespace firn::drivers::test
