#include "tests/live/port_bridge.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "runtime/port_wire.h"
#include "runtime/run_clock.h"

namespace firn::test {
namespace {

constexpr double kLook_us = 1000.0;

/// One direction of a line: bytes that wait for their time on the wire.
class Paced {
 public:
  explicit Paced(int baud) : byte_us_(baud > 0 ? 10.0e6 / baud : 0.0) {}
  void add(const std::byte* bytes, std::size_t n) {
    if (waiting_.empty()) free_us_ = std::max(free_us_, double(monotonic_us()));
    waiting_.append(reinterpret_cast<const char*>(bytes), n);
  }
  bool empty() const { return waiting_.empty(); }
  /// Until all of them are there.
  double left_us() const {
    return waiting_.empty() ? kLook_us
                            : free_us_ + double(waiting_.size()) * byte_us_ - double(monotonic_us());
  }
  /// The bytes whose last bit is on the other side by now.
  std::string due() {
    std::size_t n = waiting_.size();
    if (byte_us_ > 0.0) {
      n = std::min(n, std::size_t(std::max(0.0, (double(monotonic_us()) - free_us_) / byte_us_)));
      free_us_ += double(n) * byte_us_;
    }
    std::string bytes = waiting_.substr(0, n);
    waiting_.erase(0, n);
    return bytes;
  }

 private:
  double byte_us_, free_us_ = 0.0;
  std::string waiting_;
};

}  // namespace

PortBridge::PortBridge(Kind kind, const std::filesystem::path& socket, int baud)
    : kind_(kind), socket_(socket), baud_(baud) {
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

// A wire waits for no processor: where it may, the thread goes before all others.
void PortBridge::serve() {
  ::setpriority(PRIO_PROCESS, id_t(::gettid()), -20);
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
  Paced to_world(baud_), to_host(baud_);
  while (!over_) {
    pollfd p[2] = {{host, POLLIN, 0}, {world.fd(), POLLIN, 0}};
    const bool idle = to_world.empty() && to_host.empty();
    const double wait_us = std::clamp(std::min(to_world.left_us(), to_host.left_us()), 0.0, kLook_us);
    const timespec timeout{0, idle ? 20'000'000 : long(wait_us * 1e3)};
    ::ppoll(p, 2, &timeout, nullptr);
    if (p[0].revents) {
      const ssize_t got = ::read(host, bytes, sizeof bytes);
      if (got <= 0) return;
      to_world.add(bytes, std::size_t(got));
    }
    if (p[1].revents) {
      std::size_t got = 0;
      const PortWire::Io io = world.read(bytes, got);
      if (io == PortWire::Io::kLost) return;
      if (io == PortWire::Io::kDone) to_host.add(bytes, got);
    }
    const std::string out = to_world.due(), in = to_host.due();
    std::size_t sent = 0;
    for (std::size_t done = 0; done < out.size(); done += sent)
      if (world.write(std::as_bytes(std::span(out)).subspan(done), sent) == PortWire::Io::kLost) return;
    if (!in.empty() && ::write(host, in.data(), in.size()) != ssize_t(in.size())) return;
  }
}

}  // namespace firn::test
