#include "print/hosts/lane.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <stdexcept>

#include "procs/bus/bus_key.h"

namespace firn {
namespace {

sockaddr_un address_of(const std::string& name, socklen_t& size) {
  sockaddr_un a{};
  a.sun_family = AF_UNIX;
  if (name.empty() || name.size() + 1 > sizeof a.sun_path)
    throw std::runtime_error("'" + name + "' is no lane");
  std::copy(name.begin(), name.end(), a.sun_path + 1);  // the first byte 0: not in the file system
  size = socklen_t(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return a;
}

[[noreturn]] void refuse(const char* what) {
  throw std::runtime_error(std::string("a lane, ") + what + ": " + std::strerror(errno));
}

bool write_all(int fd, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t sent = ::write(fd, bytes, count);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes += sent;
    count -= std::size_t(sent);
  }
  return true;
}

}  // namespace

LaneDoor::LaneDoor() : name_("firn-" + BusKey::random().line().substr(4, 32)) {
  socklen_t size = 0;
  const sockaddr_un address = address_of(name_, size);
  fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd_ < 0) refuse("socket");
  if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), size) != 0 || ::listen(fd_, 4) != 0) {
    ::close(fd_);
    refuse("bind");
  }
}

LaneDoor::~LaneDoor() { ::close(fd_); }

int LaneDoor::accept() {
  const int fd = ::accept4(fd_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) return -1;
  ucred who{};
  socklen_t size = sizeof who;
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 && who.uid == ::geteuid()) return fd;
  ::close(fd);
  return -1;
}

void carry_lane(const std::string& name) {
  socklen_t size = 0;
  const sockaddr_un address = address_of(name, size);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) refuse("socket");
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), size) != 0) refuse("connect");
  const int from[] = {STDIN_FILENO, fd}, to[] = {fd, STDOUT_FILENO};
  char bytes[16 << 10];
  for (;;) {
    pollfd fds[] = {{from[0], POLLIN, 0}, {from[1], POLLIN, 0}};
    if (::poll(fds, 2, -1) < 0 && errno != EINTR) return;
    for (int n = 0; n < 2; ++n) {
      if (fds[n].revents == 0) continue;
      const ssize_t got = ::read(from[n], bytes, sizeof bytes);
      if (got <= 0 || !write_all(to[n], bytes, std::size_t(got))) return;
    }
  }
}

}  // namespace firn
