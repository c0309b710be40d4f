// PortWire is one nonblocking connection to an instrument: TCP, a serial line, a Unix socket, a source of
// pictures, a cassette or the program of a driver class in Python.
#pragma once

#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "files/port_address.h"
#include "runtime/camera/camera_bridge.h"
#include "runtime/cassette_deck.h"
#include "runtime/python_child.h"

namespace firn {

class PortWire {
 public:
  enum class State : std::uint8_t { kClosed, kConnecting, kOpen };
  enum class Io : std::uint8_t { kDone, kLater, kLost };

  /// Resolves the name of a TCP host, reads a cassette, once. @throws std::runtime_error or
  /// std::invalid_argument naming the address or the line of the cassette
  explicit PortWire(PortAddress address);
  ~PortWire() { close(); }
  PortWire(PortWire&& other) noexcept;
  PortWire& operator=(PortWire&&) = delete;

  /// Begins to connect. Afterwards kConnecting (TCP, a serial line that is given time), kOpen, or kClosed
  /// with trouble().
  void open(std::int64_t wall_us);
  /// Looks whether the connection has come about; kClosed with trouble() when it has failed or takes too
  /// long.
  State settle(std::int64_t wall_us);
  void close();

  State state() const { return state_; }
  int fd() const { return fd_; }  ///< -1 when closed
  std::int64_t due_us() const;    ///< when settle() must be called next; INT64_MAX unless connecting
  const PortAddress& address() const { return address_; }
  const std::string& trouble() const {
    return trouble_;
  }  ///< of the last open(), or of its end, with the address

  /// @returns kDone with `count` > 0, kLater, or kLost: the other side has gone
  Io read(std::span<std::byte> to, std::size_t& count);
  Io write(std::span<const std::byte> bytes, std::size_t& count);
  /// Drops bytes that a serial line has taken and not sent yet.
  void drop_unsent();

 private:
  void failed(const std::string& why);
  Io gone(const std::string& why);
  void open_pictures();
  void start_program(std::int64_t wall_us);
  void open_cassette(std::int64_t wall_us);
  void wait_for_cassette();
  Io read_cassette(std::span<std::byte> to, std::size_t& count);
  void connect_socket(const sockaddr* to, socklen_t size);

  PortAddress address_;
  sockaddr_storage remote_{};  // of a TCP port
  socklen_t remote_size_ = 0;
  State state_ = State::kClosed;
  int fd_ = -1;
  std::int64_t due_us_ = INT64_MAX;
  std::string trouble_;
  std::unique_ptr<camera::CameraBridge> bridge_;  // of a source of pictures, while it is open
  std::unique_ptr<CassetteDeck> deck_;  // of a cassette; fd_ is a timer that runs out when bytes come
  std::vector<std::byte> played_;       // come, and not read yet
  PythonChild child_;
};

}  // namespace firn
