// LcmBus sends and receives datagrams of LCM's UDP multicast protocol on the loopback interface: the only
// network calls of Firn. LCM's own receiver is not used: it trusts offsets and lengths of fragments, listens
// on every interface, and takes datagrams that were sent to this host alone.
#pragma once

#include <netinet/in.h>

#include <array>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "procs/bus/bus_key.h"
#include "procs/bus/lcm_packet.h"
#include "procs/bus/message_mac.h"
#include "runtime/bus.h"

namespace firn {

inline constexpr int kWantedReceiveBuffer = 4'194'304;  ///< bytes of kernel buffer per receiver

/// Returns "udpm://239.255.76.67:<port>?ttl=0&recv_buf_size=4194304": datagrams never leave this machine.
std::string default_bus_url(int port);

class LcmBus : public Bus {
 public:
  /// @param url "udpm://<multicast address>:<port>[?ttl=0][&recv_buf_size=<bytes>][&key=none]"
  /// @param key authenticates all that is sent; a datagram without its MAC is dropped. None exactly if the
  /// URL has key=none
  /// @throws std::runtime_error naming the URL and the remedy if there is no such bus on loopback
  explicit LcmBus(const std::string& url, const std::optional<BusKey>& key = std::nullopt);
  ~LcmBus() override;
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  void subscribe(const std::string& channel) override;
  int fd() const override { return receiver_; }
  /// Datagrams that are no whole message of a process of this run are dropped and counted.
  void receive(const Sink& sink) override;
  void publish(std::string_view channel, std::span<const std::byte> datagram) override;
  /// As the kernel grants them to this process; all of a run ask for the same.
  std::size_t receive_buffer_bytes() const override;

  /// Listens to the channels of the lab's own programs, and to those subscribed.
  void subscribe_own();

  /// For a relay to another host: listens to every channel, but not to this bus itself. Only with
  /// a key, by which receive_sealed() still drops messages of other runs.
  void subscribe_all();
  /// As receive() and publish(), with the messages' MACs behind them, as they are on the bus. A second copy
  /// of a message is not published again.
  void receive_sealed(const Sink& sink);
  void publish_sealed(std::string_view channel, std::span<const std::byte> sealed);

  std::uint64_t dropped(PacketFault fault) const { return dropped_[std::size_t(fault)]; }
  /// One sentence with the numbers by cause; empty when nothing was dropped.
  std::string dropped_text() const;

 private:
  void open(const std::string& url, const std::optional<BusKey>& key);
  void keep_others_out();
  void take_waiting(const Sink& sink, bool sealed);
  void send(std::string_view channel, std::span<const std::byte> datagram,
            std::span<const std::byte> trailer);

  int receiver_ = -1, sender_ = -1;
  int loopback_ = 0;  // index of the interface
  sockaddr_in group_{};
  std::set<std::string, std::less<>> channels_;
  bool all_channels_ = false, own_programs_ = false;
  in_port_t own_port_ = 0;  // of sent datagrams, in network order; with all_channels_
  std::vector<std::byte> buffer_;
  std::array<std::uint64_t, kPacketFaults> dropped_{};
  std::optional<MacVerifier> check_;
  std::mutex sending_;
  std::optional<MessageMac> mac_;
  std::uint32_t sequence_ = 0;
};

/// Returns the receive buffer in bytes that the kernel grants on a request for kWantedReceiveBuffer.
int granted_receive_buffer();
/// Returns an empty text, or one sentence with the granted size, the wanted size and the remedy.
std::string receive_buffer_warning();

}  // namespace firn
