// Bus sends and receives datagrams for a runner. LcmBus (procs/bus) is the real one; tests bring their
// own.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace firn {

class Bus {
 public:
  using Sink = std::function<void(std::string_view channel, std::span<const std::byte> datagram)>;
  virtual ~Bus() = default;

  virtual void subscribe(const std::string& channel) = 0;
  virtual int fd() const = 0;  ///< readable when a datagram waits
  /// Hands on waiting datagrams (bounded), without blocking.
  virtual void receive(const Sink& sink) = 0;
  virtual void publish(std::string_view channel,
                       std::span<const std::byte> datagram) = 0;  ///< from any thread
  /// Returns how many bytes wait for a receiver that is busy, before datagrams are lost.
  virtual std::size_t receive_buffer_bytes() const { return 0; }
};

}  // namespace firn
