// LcmBus sends and receives datagrams over UDP multicast: the only LCM calls of Firn.
#pragma once

#include <exception>
#include <string>

#include "runtime/bus.h"

struct _lcm_t;
struct _lcm_recv_buf_t;

namespace firn {

inline constexpr int kWantedReceiveBuffer = 4'194'304;  ///< bytes of kernel buffer per receiver

/// Returns "udpm://239.255.76.67:<port>?ttl=0&recv_buf_size=4194304": datagrams never leave this machine.
std::string default_bus_url(int port);

class LcmBus : public Bus {
 public:
  /// @throws std::runtime_error naming the URL and the remedy if LCM cannot open the URL
  explicit LcmBus(const std::string& url);
  ~LcmBus() override;
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  void subscribe(const std::string& channel) override;
  int fd() const override;
  void receive(const Sink& sink) override;
  void publish(std::string_view channel, std::span<const std::byte> datagram) override;

 private:
  static void on_message(const _lcm_recv_buf_t* buffer, const char* channel, void* self);
  _lcm_t* lcm_;
  const Sink* sink_ = nullptr;  // during receive()
  std::exception_ptr thrown_;   // nothing may pass through LCM's C frames
};

/// Returns the receive buffer in bytes that the kernel grants on a request for kWantedReceiveBuffer (tested
/// with a separate socket: LCM hides its own).
int granted_receive_buffer();
/// Returns an empty text, or one sentence with the granted size, the wanted size and the remedy.
std::string receive_buffer_warning();

}  // namespace firn
