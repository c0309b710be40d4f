#include "runtime/port_wire.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "runtime/run_clock.h"
#include "runtime/serial_line.h"
#include "runtime/socket_address.h"

namespace firn {
namespace {

constexpr std::int64_t kConnectWithin_us = 2'000'000;
constexpr std::int64_t kLookForEnd_us = 10'000;  // of the program that ran before
constexpr int kKeepIdle_s = 1, kKeepEvery_s = 1, kKeepTries = 3, kUnacknowledged_ms = 3000;

// A dead peer is noticed after some 3 s, with bytes under way or without.
void keep_alive(int fd) {
  const auto set = [&](int level, int option, int value) {
    ::setsockopt(fd, level, option, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, kKeepIdle_s);
  set(IPPROTO_TCP, TCP_KEEPINTVL, kKeepEvery_s);
  set(IPPROTO_TCP, TCP_KEEPCNT, kKeepTries);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, kUnacknowledged_ms);
}

}  // namespace

PortWire::PortWire(PortAddress address) : address_(std::move(address)) {
  if (address_.kind == PortAddress::Kind::kCassette) deck_ = std::make_unique<CassetteDeck>(address_.place);
  if (address_.kind != PortAddress::Kind::kTcp) return;
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_NUMERICSERV;
  const std::string port = std::to_string(address_.tcp_port);
  if (const int error = ::getaddrinfo(address_.place.c_str(), port.c_str(), &wanted, &found); error != 0)
    throw std::runtime_error(to_text(address_) + ": the host is not known: " + ::gai_strerror(error));
  remote_size_ = found->ai_addrlen;
  std::memcpy(&remote_, found->ai_addr, remote_size_);
  ::freeaddrinfo(found);
}

PortWire::PortWire(PortWire&& other) noexcept
    : address_(std::move(other.address_)),
      remote_(other.remote_),
      remote_size_(other.remote_size_),
      state_(std::exchange(other.state_, State::kClosed)),
      fd_(std::exchange(other.fd_, -1)),
      due_us_(other.due_us_),
      trouble_(std::move(other.trouble_)),
      bridge_(std::move(other.bridge_)),
      deck_(std::move(other.deck_)),
      played_(std::move(other.played_)),
      child_(std::move(other.child_)) {}

void PortWire::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  bridge_.reset();
  child_.let_go(monotonic_us());
  state_ = State::kClosed;
  due_us_ = INT64_MAX;
}

void PortWire::failed(const std::string& why) {
  close();
  trouble_ = to_text(address_) + ": " + why;
}

PortWire::Io PortWire::gone(const std::string& why) {
  trouble_ = to_text(address_) + ": " + why;
  return Io::kLost;
}

void PortWire::connect_socket(const sockaddr* to, socklen_t size) {
  fd_ = ::socket(to->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd_ < 0) return failed(std::strerror(errno));
  if (to->sa_family != AF_UNIX) keep_alive(fd_);
  if (::connect(fd_, to, size) == 0)
    state_ = State::kOpen;
  else if (errno == EINPROGRESS)
    state_ = State::kConnecting;
  else
    failed(std::strerror(errno));
}

void PortWire::open(std::int64_t wall_us) {
  close();
  trouble_.clear();
  switch (address_.kind) {
    case PortAddress::Kind::kSimulated:
      return failed("the simulated world has no place of its own");
    case PortAddress::Kind::kUnix: {
      const SocketAddress address(address_.place);
      return connect_socket(address.get(), sizeof(sockaddr_un));
    }
    case PortAddress::Kind::kCassette:
      return open_cassette(wall_us);
    case PortAddress::Kind::kPython:
      state_ = State::kConnecting;
      return start_program(wall_us);
    case PortAddress::Kind::kV4l2:
    case PortAddress::Kind::kFolder:
      return open_pictures();
    case PortAddress::Kind::kTcp:
      connect_socket(reinterpret_cast<const sockaddr*>(&remote_), remote_size_);
      if (state_ == State::kConnecting) due_us_ = wall_us + kConnectWithin_us;
      return;
    case PortAddress::Kind::kSerial: {
      std::string why;
      fd_ = open_serial_line(address_, why);
      if (fd_ < 0) return failed(why);
      state_ = address_.open_wait_ms > 0 ? State::kConnecting : State::kOpen;
      if (state_ == State::kConnecting) due_us_ = wall_us + address_.open_wait_ms * std::int64_t(1000);
      return;
    }
  }
}

void PortWire::open_pictures() try {
  bridge_ = std::make_unique<camera::CameraBridge>(camera::open_picture_source(address_));
  fd_ = bridge_->take_fd();
  state_ = State::kOpen;
} catch (const std::runtime_error& why) {
  failed(why.what());
}

// Two programs of one class never hold the instrument at a time.
void PortWire::start_program(std::int64_t wall_us) {
  due_us_ = wall_us + kLookForEnd_us;
  if (!child_.ended(wall_us)) return;
  std::string why;
  fd_ = child_.start(address_.driver_files, why);
  if (fd_ < 0) return failed(why);
  state_ = State::kOpen;
}

void PortWire::open_cassette(std::int64_t wall_us) {
  fd_ = ::timerfd_create(CLOCK_BOOTTIME, TFD_NONBLOCK | TFD_CLOEXEC);
  if (fd_ < 0) return failed(std::strerror(errno));
  state_ = State::kOpen;
  played_.clear();
  deck_->open(wall_us);
  wait_for_cassette();
}

void PortWire::wait_for_cassette() {
  const std::int64_t due_us = played_.empty() ? deck_->due_us() : 1;
  itimerspec at{};
  if (due_us != INT64_MAX) at.it_value = {due_us / 1'000'000, due_us % 1'000'000 * 1000};
  if (fd_ >= 0) ::timerfd_settime(fd_, TFD_TIMER_ABSTIME, &at, nullptr);
}

PortWire::Io PortWire::read_cassette(std::span<std::byte> to, std::size_t& count) {
  bool closed = false;
  if (played_.empty() && !deck_->take(monotonic_us(), played_, closed)) {
    wait_for_cassette();
    return Io::kLater;
  }
  if (closed) return Io::kLost;
  count = std::min(to.size(), played_.size());
  std::copy_n(played_.begin(), count, to.begin());
  played_.erase(played_.begin(), played_.begin() + std::ptrdiff_t(count));
  return Io::kDone;
}

PortWire::State PortWire::settle(std::int64_t wall_us) {
  if (state_ != State::kConnecting) return state_;
  if (address_.kind == PortAddress::Kind::kPython) {
    if (wall_us < due_us_) return state_;
    start_program(wall_us);
    if (state_ != State::kOpen) return state_;
  } else if (address_.kind == PortAddress::Kind::kSerial) {
    if (wall_us < due_us_) return state_;
    state_ = State::kOpen;
  } else {
    pollfd p{fd_, POLLOUT, 0};
    if (::poll(&p, 1, 0) <= 0) {
      if (wall_us >= due_us_) failed("no answer within 2 s");
      return state_;
    }
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) {
      failed(std::strerror(error));
      return state_;
    }
    state_ = State::kOpen;
  }
  due_us_ = INT64_MAX;
  return state_;
}

std::int64_t PortWire::due_us() const { return state_ == State::kConnecting ? due_us_ : INT64_MAX; }

PortWire::Io PortWire::read(std::span<std::byte> to, std::size_t& count) {
  if (deck_) return read_cassette(to, count);
  const bool serial = address_.kind == PortAddress::Kind::kSerial;
  if (serial) {  // without a byte, read() returns 0 as it does for a line that was pulled out
    pollfd p{fd_, POLLIN, 0};
    if (::poll(&p, 1, 0) <= 0) return Io::kLater;
  }
  const ssize_t got = serial ? ::read(fd_, to.data(), to.size()) : ::recv(fd_, to.data(), to.size(), 0);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return Io::kLater;
  if (got <= 0)
    return gone(got < 0  ? std::strerror(errno)
                : serial ? "the line is gone"
                         : "the other side has closed it");
  count = std::size_t(got);
  return Io::kDone;
}

PortWire::Io PortWire::write(std::span<const std::byte> bytes, std::size_t& count) {
  if (deck_) {
    count = bytes.size();
    if (!deck_->send(bytes, monotonic_us()))
      trouble_ = to_text(address_) + ": what is sent stands nowhere on the cassette:" + shown(bytes);
    wait_for_cassette();
    return Io::kDone;
  }
  const ssize_t sent = address_.kind == PortAddress::Kind::kSerial
                           ? ::write(fd_, bytes.data(), bytes.size())
                           : ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (sent < 0 && (errno == EAGAIN || errno == EINTR)) return Io::kLater;
  if (sent < 0) return gone(std::strerror(errno));
  count = std::size_t(sent);
  return sent == 0 ? Io::kLater : Io::kDone;
}

void PortWire::drop_unsent() {
  if (fd_ >= 0 && address_.kind == PortAddress::Kind::kSerial) firn::drop_unsent(fd_);
}

}  // namespace firn
