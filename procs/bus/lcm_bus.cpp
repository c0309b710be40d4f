#include "procs/bus/lcm_bus.h"

#include <lcm/lcm.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <utility>

namespace firn {
namespace {

constexpr int kMostAtOnce = 512;  // datagrams per receive(), so that a flood does not starve the node

}  // namespace

std::string default_bus_url(int port) {
  return "udpm://239.255.76.67:" + std::to_string(port) +
         "?ttl=0&recv_buf_size=" + std::to_string(kWantedReceiveBuffer);
}

LcmBus::LcmBus(const std::string& url) : lcm_(lcm_create(url.c_str())) {
  if (!lcm_) throw std::runtime_error("LCM cannot open " + url + ": run `firn doctor`");
}

LcmBus::~LcmBus() { lcm_destroy(lcm_); }

void LcmBus::subscribe(const std::string& channel) {
  lcm_subscription_t* s = lcm_subscribe(lcm_, channel.c_str(), &LcmBus::on_message, this);
  if (!s) throw std::runtime_error("LCM cannot subscribe to " + channel);
  lcm_subscription_set_queue_capacity(s,
                                      0);  // no limit here: the transport and the runner drop stale messages
}

int LcmBus::fd() const { return lcm_get_fileno(lcm_); }

void LcmBus::receive(const Sink& sink) {
  sink_ = &sink;
  for (int n = 0; n < kMostAtOnce && !thrown_; ++n)
    if (lcm_handle_timeout(lcm_, 0) <= 0) break;
  sink_ = nullptr;
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

void LcmBus::on_message(const lcm_recv_buf_t* buffer, const char* channel, void* self) {
  auto* bus = static_cast<LcmBus*>(self);
  try {
    (*bus->sink_)(channel, std::span(static_cast<const std::byte*>(buffer->data), buffer->data_size));
  } catch (...) {
    if (!bus->thrown_) bus->thrown_ = std::current_exception();
  }
}

void LcmBus::publish(std::string_view channel, std::span<const std::byte> datagram) {
  // A datagram that the kernel refuses is a lost datagram: the transport sends it again when asked.
  lcm_publish(lcm_, std::string(channel).c_str(), datagram.data(), unsigned(datagram.size()));
}

int granted_receive_buffer() {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return 0;
  const int wanted = kWantedReceiveBuffer;
  int granted = 0;
  socklen_t size = sizeof granted;
  ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &wanted, sizeof wanted);
  ::getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &granted, &size);
  ::close(fd);
  return granted / 2;  // Linux reports twice the size for data
}

std::string receive_buffer_warning() {
  const int granted = granted_receive_buffer();
  if (granted >= kWantedReceiveBuffer) return {};
  return "the kernel grants " + std::to_string(granted) + " bytes of receive buffer, " +
         std::to_string(kWantedReceiveBuffer) +
         " are wanted: messages will be lost and sent again; sysctl -w net.core.rmem_max=" +
         std::to_string(kWantedReceiveBuffer);
}

}  // namespace firn
