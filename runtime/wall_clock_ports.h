// WallClockPorts lets a Lab run on instrument ports: its time is the clock's, its bytes those of sockets,
// serial lines and sockets of a simulated world.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "files/port_address.h"
#include "runtime/lab.h"
#include "runtime/ports.h"

namespace firn {

class WallClockPorts final : public LabWorld {
 public:
  /// @param addresses of each port by name @throws std::runtime_error: the host of a TCP port is not known
  explicit WallClockPorts(const std::map<std::string, PortAddress>& addresses);

  /// Waits until the port is open, 3 s at most; one that does not open is closed by the next advance().
  void connect(std::string_view port, Time now) override;
  void disconnect(std::string_view port, Time now) override;
  void receive(std::string_view port, std::span<const std::byte> bytes, Time now) override;
  /// The clock's time, or a millisecond later when no byte waits.
  Time next_event() const override;
  void advance(Time now, const Send& send) override;

  /// Sentences about ports that do not open.
  std::vector<std::string> take_notices() { return ports_.take_notices(); }

 private:
  struct Heard {
    std::size_t port;
    std::vector<std::byte> bytes;
    bool close;
  };
  std::size_t index_of(std::string_view port) const;
  std::int64_t lab_us() const;
  void listen(std::int64_t max_us);

  std::vector<std::string> names_;
  Ports ports_;
  std::vector<bool> open_;
  std::vector<Heard> heard_;
  std::int64_t began_us_;
};

}  // namespace firn
