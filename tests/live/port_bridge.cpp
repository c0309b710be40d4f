#include "tests/live/port_bridge.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

#include "runtime/port_wire.h"

namespace firn::test {

PortBridge::PortBridge(Kind kind, const std::filesystem::path& socket) : kind_(kind), socket_(socket) {
  if (kind == Kind::kSerial) {
    int slave = -1;
    char name[128];
    if (::openpty(&master_, &slave, name, nullptr, nullptr) != 0) throw std::runtime_error("openpty");
    ::close(slave);  // the host opens it
    slave_ = name;
  } else {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof a;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&a), sizeof a) != 0 || ::listen(listener_, 1) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&a), &size) != 0)
      throw std::runtime_error("cannot listen");
    port_ = ntohs(a.sin_port);
  }
  thread_ = std::thread([this] { serve(); });
}

PortBridge::~PortBridge() {
  over_ = true;
  thread_.join();
  for (const int fd : {listener_, master_})
    if (fd >= 0) ::close(fd);
}

std::string PortBridge::address(int baud) const {
  return kind_ == Kind::kTcp ? "tcp:127.0.0.1:" + std::to_string(port_)
                             : "serial:" + slave_ + "?baud=" + std::to_string(baud);
}

void PortBridge::serve() {
  while (!over_) {
    if (kind_ == Kind::kTcp) {
      pollfd p{listener_, POLLIN, 0};
      if (::poll(&p, 1, 20) <= 0) continue;
      const int host = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (host < 0) continue;
      carry(host);
      ::close(host);
    } else {
      pollfd p{master_, POLLIN, 0};
      ::poll(&p, 1, 0);
      if (p.revents & POLLHUP)  // nobody has the line open
        ::usleep(5000);
      else
        carry(master_);
    }
  }
}

// Until one side goes. A line that is closed reads as an error.
void PortBridge::carry(int host) {
  PortWire world(parse_port_address("unix:" + socket_.string()));
  world.open(0);
  if (world.state() != PortWire::State::kOpen) {
    ::usleep(5000);
    return;
  }
  std::byte bytes[4096];
  while (!over_) {
    pollfd p[2] = {{host, POLLIN, 0}, {world.fd(), POLLIN, 0}};
    ::poll(p, 2, 20);
    if (p[0].revents) {
      const ssize_t got = ::read(host, bytes, sizeof bytes);
      if (got <= 0) return;
      std::size_t sent = 0;
      for (std::size_t done = 0; done < std::size_t(got); done += sent)
        if (world.write(std::span(bytes).subspan(done, std::size_t(got) - done), sent) == PortWire::Io::kLost)
          return;
    }
    if (p[1].revents) {
      std::size_t got = 0;
      const PortWire::Io io = world.read(bytes, got);
      if (io == PortWire::Io::kLost) return;
      if (io == PortWire::Io::kDone && ::write(host, bytes, got) != ssize_t(got)) return;
    }
  }
}

}  // namespace firn::test
