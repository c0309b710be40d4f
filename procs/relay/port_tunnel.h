// PortTunnel is one end of the cables between drivers at a host and their simulated instruments, which are in
// the world at the launcher's computer: a socket of the driver's port there is one of the world's port here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/relay/link.h"

namespace firn::relay {

class PortTunnel {
 public:
  enum class Side : std::uint8_t {
    kDrivers,      ///< listens at the ports, and each connection begins here
    kInstruments,  ///< connects to the ports
  };

  /// @param folder of the sockets, one for each port, by its name
  /// @param link carries the bytes; it must live longer
  /// @throws std::runtime_error naming the port at which nobody can listen
  PortTunnel(Side side, std::filesystem::path folder, const std::vector<std::string>& ports, Link& link);
  ~PortTunnel();
  PortTunnel(const PortTunnel&) = delete;
  PortTunnel& operator=(const PortTunnel&) = delete;

  void add_to(std::vector<pollfd>& fds) const;
  /// Takes connections and bytes of this computer. Never waits.
  void service();
  /// Takes a kPort frame of the other end. Copies that came by other lanes, and bytes of no port here,
  /// are passed over.
  void take(const Frame& frame);

 private:
  struct Cable {
    std::string port;
    int listener = -1, fd = -1;
    std::int64_t connection = 0;       // counted by the drivers' side
    std::int64_t sent = 0, taken = 0;  // pieces of all connections
    std::vector<std::byte> waiting;    // for fd
    bool ends = false;                 // close fd when nothing waits
  };
  void listen(Cable& cable);
  void connect(Cable& cable);
  void send(Cable& cable, std::span<const std::byte> bytes);
  void read(Cable& cable);
  void write(Cable& cable);
  static void close(Cable& cable);
  bool has_room() const;

  Side side_;
  std::filesystem::path folder_;
  Link& link_;
  std::vector<Cable> cables_;
};

}  // namespace firn::relay
