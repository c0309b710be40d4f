// Ports holds the instrument ports of a driver process: nonblocking Unix sockets with a queue for output,
// whose changes become events. (Serial lines and TCP follow the same shape.)
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "runtime/time.h"

struct pollfd;

namespace firn {

class Ports {
 public:
  using OnLink = std::function<void(PortId, LinkState)>;
  using OnBytes = std::function<void(PortId, std::span<const std::byte>)>;

  /// @param paths socket of each port; nothing is connected before open_all().
  explicit Ports(std::vector<std::string> paths);
  ~Ports();
  Ports(const Ports&) = delete;
  Ports& operator=(const Ports&) = delete;

  void open_all(std::int64_t wall_us);
  void write(PortId port, std::span<const std::byte> bytes);
  /// Closes (told, if it was open) and connects again, until somebody listens (told).
  void reopen(PortId port, std::int64_t wall_us);

  void add_to(std::vector<pollfd>& fds) const;
  /// Connects ports that are due, writes waiting output, reads arrived bytes.
  void service(std::int64_t wall_us, const OnLink& on_link, const OnBytes& on_bytes);
  std::int64_t due_us() const;  ///< next attempt to connect

 private:
  struct Port {
    std::string path;
    int fd = -1;
    std::int64_t connect_at_us = INT64_MAX;
    bool tell_closed = false;
    std::vector<std::byte> waiting;
  };
  void close(Port& p);
  void flush(Port& p);

  std::vector<Port> ports_;
};

}  // namespace firn
