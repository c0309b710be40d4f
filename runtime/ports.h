// Ports holds the instrument ports of a driver process: nonblocking connections with a queue for output,
// whose changes become events.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "files/cassette.h"
#include "runtime/port_rate.h"
#include "runtime/port_wire.h"
#include "runtime/time.h"

struct pollfd;

namespace firn {

class Ports {
 public:
  using OnLink = std::function<void(PortId, LinkState)>;
  using OnBytes = std::function<void(PortId, std::span<const std::byte>)>;

  static constexpr std::size_t kReadPerTurn = 16384;  ///< [bytes]

  using OnRefused = std::function<void(PortId, const std::string& cause)>;
  /// Why bytes of a command must not leave now; empty: they may.
  using LeaseRefusal = std::function<std::string()>;

  /// @param addresses of each port; nothing is connected before open_all().
  /// @param lease_refusal asked right before any byte of a command is handed to the kernel
  /// @param rates of each port; a port without one may send any number of bytes
  /// @throws std::runtime_error: the host of a TCP port is not known
  explicit Ports(const std::vector<PortAddress>& addresses, LeaseRefusal lease_refusal = {},
                 const std::vector<PortRate>& rates = {});
  Ports(const Ports&) = delete;
  Ports& operator=(const Ports&) = delete;

  /// Is told of everything that crosses a port: bytes once they have left or have come, openings, ends.
  using Tape = std::function<void(PortId, Cassette::Kind, std::span<const std::byte>)>;
  void record(Tape tape) { tape_ = std::move(tape); }

  void open_all(std::int64_t wall_us);
  /// @param of_command they leave only while the lease holds: bytes that the kernel has not taken when it
  /// ends are dropped and told of. Where a part has left, the link is closed instead: later bytes must
  /// not end the half frame.
  void write(PortId port, std::span<const std::byte> bytes, bool of_command);
  /// Drops what waits, and what a serial line has not sent yet: a stop must not wait behind it. Commands
  /// among it are told of as refused. If no command was written since the last call, nothing is dropped: what
  /// is under way then is that stop itself, or makes safe, and a print ends with two stops at once.
  void drop_waiting(PortId port);
  /// Closes (told, if it was open) and connects again, until somebody listens (told).
  void reopen(PortId port, std::int64_t wall_us);

  void add_to(std::vector<pollfd>& fds) const;
  /// Connects ports that are due, writes waiting output, reads at most kReadPerTurn bytes of each port. A
  /// port that sends faster than its rate is closed, with a notice: its instrument's protocol never does.
  void service(std::int64_t wall_us, const OnLink& on_link, const OnBytes& on_bytes);
  /// Tells of the bytes that were not let out since the last call.
  void take_refused(const OnRefused& on_refused);
  /// Returns the sentences about ports that could not be opened or were lost, each once until it opens.
  std::vector<std::string> take_notices();
  /// Why a port is not open now: "tcp:127.0.0.1:4001: Connection refused"; empty: each is, or was not tried.
  std::string trouble() const;
  std::int64_t due_us() const;  ///< next attempt to connect

 private:
  struct Waiting {
    std::vector<std::byte> bytes;
    std::size_t sent = 0;
    bool of_command = false;
  };
  struct Port {
    explicit Port(const PortAddress& address) : wire(address) {}
    PortWire wire;
    std::int64_t connect_at_us = INT64_MAX;
    std::int64_t pause_us = 0;  // before the next attempt
    bool told_open = false;     // the driver was told so
    bool tell_closed = false;
    std::string said;  // the last notice
    std::deque<Waiting> waiting;
    std::size_t waiting_bytes = 0;
    std::string refused;   // cause
    bool stopped = false;  // no command was written since drop_waiting()
    RateMeter meter;
  };
  void close(Port& p);
  void lost(Port& p);
  void connect(Port& p, std::int64_t wall_us);
  void flush(Port& p);
  void read(Port& p, std::int64_t wall_us, const OnBytes& on_bytes);

  void tell(const Port& p, Cassette::Kind kind, std::span<const std::byte> bytes = {}) const {
    if (tape_) tape_(PortId(&p - ports_.data()), kind, bytes);
  }

  std::vector<Port> ports_;
  LeaseRefusal lease_refusal_;
  Tape tape_;
  std::vector<std::string> notices_;
};

}  // namespace firn
