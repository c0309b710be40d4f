#include "page/listening.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "files/usage_error.h"
#include "page/server.h"

namespace firn::page {
namespace {

constexpr int kPortsToTry = 20;

struct Address {
  sockaddr_storage bytes{};
  socklen_t size = 0;
  bool v6 = false;

  in_port_t& port() {
    return v6 ? reinterpret_cast<sockaddr_in6&>(bytes).sin6_port
              : reinterpret_cast<sockaddr_in&>(bytes).sin_port;
  }
};

Address address_of(const std::string& bind) {
  Address a;
  auto& four = reinterpret_cast<sockaddr_in&>(a.bytes);
  auto& six = reinterpret_cast<sockaddr_in6&>(a.bytes);
  if (::inet_pton(AF_INET, bind.c_str(), &four.sin_addr) == 1) {
    four.sin_family = AF_INET;
    a.size = sizeof four;
  } else if (::inet_pton(AF_INET6, bind.c_str(), &six.sin6_addr) == 1) {
    six.sin6_family = AF_INET6;
    a.size = sizeof six;
    a.v6 = true;
  } else {
    throw UsageError("--bind " + bind + ": is no address of this machine");
  }
  return a;
}

/// Returns the descriptor; -1 with errno.
int try_port(Address& address, int port) {
  address.port() = htons(std::uint16_t(port));
  const int fd = ::socket(address.bytes.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int on = 1;
  if (fd < 0) return fd;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address.bytes), address.size) == 0 &&
      ::listen(fd, SOMAXCONN) == 0)
    return fd;
  const int why = errno;
  ::close(fd);
  errno = why;
  return -1;
}

}  // namespace

Listening listen_on(const std::string& bind, int port) {
  Address address = address_of(bind);
  Listening l;
  l.v6 = address.v6;
  const bool any_port = port == 0;
  for (int n = 0; l.fd < 0; ++n) {
    const int wanted = any_port ? (n < kPortsToTry ? kFirstPort + n : 0) : port;
    l.fd = try_port(address, wanted);
    if (l.fd < 0 && (!any_port || wanted == 0 || errno != EADDRINUSE))
      throw UsageError("cannot listen on " + bind + ":" + std::to_string(wanted) + ": " +
                       std::strerror(errno));
  }
  ::getsockname(l.fd, reinterpret_cast<sockaddr*>(&address.bytes), &address.size);
  l.port = ntohs(address.port());
  const bool any = bind == "0.0.0.0" || bind == "::";
  const std::string shown = any ? "127.0.0.1" : l.v6 ? "[" + bind + "]" : bind;
  l.address = "http://" + shown + ":" + std::to_string(l.port) + "/";
  return l;
}

}  // namespace firn::page
