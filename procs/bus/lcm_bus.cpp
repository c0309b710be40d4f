#include "procs/bus/lcm_bus.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <stdexcept>

#include "core/options/number.h"
#include "procs/bus/channel_filter.h"

namespace firn {
namespace {

constexpr int kMaxAtOnce = 512;  // datagrams per receive(), so that a flood does not starve the node

template <class T>
void set_option(int fd, int level, int option, const T& value, const char* name) {
  if (::setsockopt(fd, level, option, &value, sizeof value) != 0)
    throw std::runtime_error(std::string(name) + ": " + std::strerror(errno));
}

// Linux reports twice the size for data.
int granted(int fd) {
  int twice = 0;
  socklen_t size = sizeof twice;
  ::getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &twice, &size);
  return twice / 2;
}

int number(std::string_view text, int low, int high, const char* name) {
  const std::optional<int> v = whole_number(text, low, high);
  if (!v)
    throw std::runtime_error(std::string(name) + " '" + std::string(text) + "': must lie in [" +
                             std::to_string(low) + ", " + std::to_string(high) + "]");
  return *v;
}

struct Address {
  sockaddr_in group{};
  int receive_buffer = kWantedReceiveBuffer;
};

Address parse(std::string_view url) {
  constexpr std::string_view kScheme = "udpm://";
  if (!url.starts_with(kScheme)) throw std::runtime_error("must begin with udpm://");
  url.remove_prefix(kScheme.size());
  const std::size_t query = url.find('?');
  const std::string_view host = url.substr(0, query);
  const std::size_t colon = host.rfind(':');
  if (colon == std::string_view::npos) throw std::runtime_error("has no port");
  Address a;
  a.group.sin_family = AF_INET;
  a.group.sin_port = htons(std::uint16_t(number(host.substr(colon + 1), 1, 65535, "port")));
  if (::inet_pton(AF_INET, std::string(host.substr(0, colon)).c_str(), &a.group.sin_addr) != 1 ||
      !IN_MULTICAST(ntohl(a.group.sin_addr.s_addr)))
    throw std::runtime_error(std::string(host.substr(0, colon)) + " is no multicast address");
  for (std::string_view rest = query == std::string_view::npos ? "" : url.substr(query + 1); !rest.empty();) {
    const std::string_view option = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), option.size() + 1));
    if (option.starts_with("ttl="))
      number(option.substr(4), 0, 0, "ttl, which is 0 on loopback,");
    else if (option.starts_with("recv_buf_size="))
      a.receive_buffer = number(option.substr(14), 1, 1 << 30, "recv_buf_size");
    else if (option != "key=none")
      throw std::runtime_error("option '" + std::string(option) +
                               "' is none of ttl, recv_buf_size, key=none");
  }
  return a;
}

}  // namespace

std::string default_bus_url(int port) {
  return "udpm://239.255.76.67:" + std::to_string(port) +
         "?ttl=0&recv_buf_size=" + std::to_string(kWantedReceiveBuffer);
}

LcmBus::LcmBus(const std::string& url, const std::optional<BusKey>& key) : buffer_(std::size_t(1) << 16) {
  try {
    open(url, key);
  } catch (const std::runtime_error& e) {
    if (receiver_ >= 0) ::close(receiver_);
    if (sender_ >= 0) ::close(sender_);
    throw std::runtime_error("LCM cannot open " + url + ": " + e.what() + "; run `firn doctor`");
  }
}

void LcmBus::open(const std::string& url, const std::optional<BusKey>& key) {
  const Address address = parse(url);
  if (bus_is_keyed(url) != key.has_value())
    throw std::runtime_error(key ? "key=none, but there is a key" : "there is no key, and not key=none");
  if (key) {
    check_.emplace(*key);
    mac_.emplace(*key);
  }
  group_ = address.group;
  loopback_ = int(::if_nametoindex("lo"));
  if (loopback_ == 0) throw std::runtime_error("there is no interface lo");
  ip_mreqn membership{};
  membership.imr_multiaddr = group_.sin_addr;
  membership.imr_ifindex = loopback_;
  ip_mreqn through{};
  through.imr_address.s_addr = htonl(INADDR_LOOPBACK);
  through.imr_ifindex = loopback_;

  receiver_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (receiver_ < 0) throw std::runtime_error(std::string("socket: ") + std::strerror(errno));
  set_option(receiver_, SOL_SOCKET, SO_REUSEADDR, 1, "SO_REUSEADDR");
  set_option(receiver_, SOL_SOCKET, SO_RCVBUF, address.receive_buffer, "SO_RCVBUF");
  set_option(receiver_, IPPROTO_IP, IP_MULTICAST_ALL, 0, "IP_MULTICAST_ALL");
  set_option(receiver_, IPPROTO_IP, IP_PKTINFO, 1, "IP_PKTINFO");
  // Bound to the group, not to any address: a datagram that is sent to this host alone does not arrive.
  if (::bind(receiver_, reinterpret_cast<const sockaddr*>(&group_), sizeof group_) != 0)
    throw std::runtime_error(std::string("bind: ") + std::strerror(errno));
  set_option(receiver_, IPPROTO_IP, IP_ADD_MEMBERSHIP, membership, "joining the group on lo");

  sender_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (sender_ < 0) throw std::runtime_error(std::string("socket: ") + std::strerror(errno));
  set_option(sender_, IPPROTO_IP, IP_MULTICAST_IF, through, "sending by lo");
  set_option(sender_, IPPROTO_IP, IP_MULTICAST_TTL, 0, "IP_MULTICAST_TTL");
}

LcmBus::~LcmBus() {
  ::close(receiver_);
  ::close(sender_);
}

void LcmBus::subscribe(const std::string& channel) {
  if (channel.empty() || channel.size() > kMaxChannelBytes)
    throw std::runtime_error("LCM cannot subscribe to '" + channel + "': a channel has 1 to 63 bytes");
  channels_.insert(channel);
  keep_others_out();
}

void LcmBus::subscribe_own() {
  own_programs_ = true;
  keep_others_out();
}

// Without the filter, which some sandboxes refuse, receive() alone chooses.
void LcmBus::keep_others_out() {
  std::vector<sock_filter> program = channel_filter(channels_, std::string(own_programs_ ? kOwnPrefix : ""));
  const sock_fprog filter{std::uint16_t(program.size()), program.data()};
  if (program.empty() || ::setsockopt(receiver_, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0)
    (void)::setsockopt(receiver_, SOL_SOCKET, SO_DETACH_FILTER, &filter,
                       sizeof filter);  // one of fewer channels
}

void LcmBus::subscribe_all() {
  if (!check_) throw std::logic_error("a relay needs a bus with a key");
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof own;
  if (::bind(sender_, reinterpret_cast<const sockaddr*>(&own), size) != 0 ||
      ::getsockname(sender_, reinterpret_cast<sockaddr*>(&own), &size) != 0)
    throw std::runtime_error(std::string("bind, of a relay: ") + std::strerror(errno));
  own_port_ = own.sin_port;
  all_channels_ = true;
  // The kernel keeps out datagrams that this socket sent. Without the filter, which some sandboxes refuse,
  // receive does.
  sock_filter program[] = {BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 0),  // the port of the sender
                           BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ntohs(own_port_), 0, 1),
                           BPF_STMT(BPF_RET | BPF_K, 0), BPF_STMT(BPF_RET | BPF_K, 0xFFFFFFFF)};
  const sock_fprog filter{std::uint16_t(std::size(program)), program};
  (void)::setsockopt(receiver_, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter);
}

void LcmBus::receive(const Sink& sink) { take_waiting(sink, false); }
void LcmBus::receive_sealed(const Sink& sink) { take_waiting(sink, true); }

void LcmBus::take_waiting(const Sink& sink, bool sealed) {
  sockaddr_in from{};
  for (int n = 0; n < kMaxAtOnce; ++n) {
    iovec place{buffer_.data(), buffer_.size()};
    alignas(cmsghdr) std::byte control[CMSG_SPACE(sizeof(in_pktinfo))];
    msghdr message{};
    message.msg_iov = &place;
    message.msg_iovlen = 1;
    message.msg_name = &from;
    message.msg_namelen = sizeof from;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    const ssize_t got = ::recvmsg(receiver_, &message, 0);
    if (got < 0) return;
    if (all_channels_ && from.sin_port == own_port_) continue;
    int interface = 0;
    for (cmsghdr* c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(&message, c))
      if (c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_PKTINFO) {
        in_pktinfo info;
        std::memcpy(&info, CMSG_DATA(c), sizeof info);
        interface = info.ipi_ifindex;
      }
    LcmPacket p;
    if (interface != loopback_)
      p.fault = PacketFault::kNotLoopback;
    else if (message.msg_flags & MSG_TRUNC)
      p.fault = PacketFault::kTooLong;
    else
      p = read_packet(std::span(buffer_).first(std::size_t(got)));
    const bool wanted =
        p.fault == PacketFault::kNone && (all_channels_ || channels_.contains(p.channel) ||
                                          (own_programs_ && p.channel.starts_with(kOwnPrefix)));
    const auto whole = p.payload;
    if (wanted && check_) {
      const MacFault fault = check_->open(p.channel, p.payload);
      if (fault == MacFault::kForged) p.fault = PacketFault::kForged;
      if (fault == MacFault::kRepeated) p.fault = PacketFault::kRepeated;
    }
    if (p.fault != PacketFault::kNone)
      ++dropped_[std::size_t(p.fault)];
    else if (wanted)
      sink(p.channel, sealed ? whole : p.payload);
  }
}

void LcmBus::publish(std::string_view channel, std::span<const std::byte> datagram) {
  const std::lock_guard lock(sending_);  // numbers leave in order
  std::byte trailer[kMacTrailerBytes];
  if (mac_) mac_->write(channel, datagram, trailer);
  send(channel, datagram, mac_ ? std::span<const std::byte>(trailer) : std::span<const std::byte>());
}

void LcmBus::publish_sealed(std::string_view channel, std::span<const std::byte> sealed) {
  std::span<const std::byte> message = sealed;
  const MacFault fault = check_->open(channel, message);
  if (fault == MacFault::kForged) ++dropped_[std::size_t(PacketFault::kForged)];
  if (fault != MacFault::kNone) return;  // a copy has come by another lane
  const std::lock_guard lock(sending_);
  send(channel, sealed, {});
}

void LcmBus::send(std::string_view channel, std::span<const std::byte> datagram,
                  std::span<const std::byte> trailer) {
  if (channel.empty() || channel.size() > kMaxChannelBytes ||
      channel.size() + 1 + datagram.size() + trailer.size() > kMaxShortMessageBytes)
    throw std::logic_error("LCM: " + std::to_string(datagram.size()) + " bytes on '" + std::string(channel) +
                           "' are no short message");
  std::byte head[kPacketHead];
  write_packet_head(sequence_++, head);
  char name[kMaxChannelBytes + 1] = {};
  channel.copy(name, kMaxChannelBytes);
  iovec parts[4] = {{head, sizeof head},
                    {name, channel.size() + 1},
                    {const_cast<std::byte*>(datagram.data()), datagram.size()},
                    {const_cast<std::byte*>(trailer.data()), trailer.size()}};
  msghdr message{};
  message.msg_name = &group_;
  message.msg_namelen = sizeof group_;
  message.msg_iov = parts;
  message.msg_iovlen = 4;
  // A datagram that the kernel refuses is a lost datagram: the transport sends it again when asked.
  (void)::sendmsg(sender_, &message, MSG_NOSIGNAL);
}

std::string LcmBus::dropped_text() const {
  std::string causes;
  std::uint64_t total = 0;
  for (int n = 1; n < kPacketFaults; ++n)
    if (const std::uint64_t count = dropped_[std::size_t(n)]; count > 0) {
      total += count;
      causes += (causes.empty() ? "" : ", ") + std::to_string(count) + " " + word(PacketFault(n));
    }
  return total == 0 ? "" : std::to_string(total) + " foreign datagrams dropped (" + causes + ")";
}

std::size_t LcmBus::receive_buffer_bytes() const { return std::size_t(granted(receiver_)); }

int granted_receive_buffer() {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return 0;
  const int wanted = kWantedReceiveBuffer;
  ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &wanted, sizeof wanted);
  const int bytes = granted(fd);
  ::close(fd);
  return bytes;
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
