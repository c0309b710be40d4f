// bus_latency [messages [seconds]]: two processes on the bus of one run, with its key. Prints for messages of
// 144 bytes, 10 kB and 1 MB the time from send() to the receiver's hands, one message at a time, and what a
// flood of each size loses: messages that had to be sent again, and those that never came.
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "firn/heartbeat_t.hpp"
#include "print/process/bus_port.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/run_clock.h"
#include "runtime/transport.h"
#include "tests/bench/bench.h"

namespace firn::bench::bus_latency {

namespace {

using namespace firn;

constexpr std::int64_t kRun = 9;
constexpr std::string_view kChannel = channels::kHeightMap.name;
constexpr std::size_t kHeadBytes = 36, kStampBytes = 8;
constexpr std::size_t kBacklogBytes = std::size_t(8) << 20;

struct End {
  End(NodeId self, const std::string& url, const BusKey& key, Transport::Deliver deliver)
      : bus(url, key),
        transport({.self = self,
                   .run_id = kRun,
                   .burst_bytes = TransportOptions::burst_into(bus.receive_buffer_bytes())},
                  std::move(deliver)) {}
  void listen() {
    for (const std::string& channel : transport.wire_channels()) bus.subscribe(channel);
  }
  void service() {
    bus.receive(
        [&](std::string_view c, std::span<const std::byte> b) { transport.receive(c, b, monotonic_us()); });
    transport.tick(monotonic_us());
    Transport::Datagram d;
    while (transport.next_datagram(monotonic_us(), d)) bus.publish(d.channel, d.bytes);
  }
  void wait(std::int64_t longest_us, int other = -1) {
    const std::int64_t wall = monotonic_us();
    pollfd fds[2] = {{bus.fd(), POLLIN, 0}, {other, POLLIN, 0}};
    const timespec timeout = poll_timeout(std::min(transport.due_us(wall) - wall, longest_us));
    ::ppoll(fds, other < 0 ? 1 : 2, &timeout, nullptr);
  }
  /// Tells of the last message, so that its loss is noticed.
  void beat() {
    heartbeat_t m{};
    m.header.run_id = kRun;
    m.header.seq = ++beats;
    m.node = "surface_mapper";
    for (const Transport::Last& l : transport.last_sent()) {
      m.channel.emplace_back(l.channel);
      m.last_seq.push_back(l.seq);
    }
    m.n = std::int32_t(m.channel.size());
    std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    bus.publish(channels::heartbeat(NodeId::kSurfaceMapper).name, bytes);
  }
  LcmBus bus;
  Transport transport;
  std::int64_t beats = 0;
};

void put(std::int64_t v, std::byte* to) {
  for (int k = 0; k < 8; ++k) to[k] = std::byte(std::uint64_t(v) >> (56 - 8 * k));
}

std::vector<std::byte> message(std::size_t bytes) {
  std::vector<std::byte> m(std::max(bytes, kHeadBytes + kStampBytes));
  put(1, m.data());
  put(kRun, m.data() + 8);
  return m;
}

void send(End& end, std::vector<std::byte>& m, std::int64_t seq) {
  put(seq, m.data() + 20);
  const std::int64_t now = monotonic_ns();
  std::memcpy(m.data() + m.size() - kStampBytes, &now, sizeof now);
  end.transport.send(kChannel, m, now / 1000);
  end.service();
}

/// The receiving process: answers each message with how long it took [ns].
[[noreturn]] void receive(const std::string& url, const BusKey& key, int answers) {
  End end(NodeId::kController, url, key, [&](const ChannelInfo&, std::span<const std::byte> m) {
    std::int64_t sent = 0;
    std::memcpy(&sent, m.data() + m.size() - kStampBytes, sizeof sent);
    const std::int64_t took = monotonic_ns() - sent;
    if (::write(answers, &took, sizeof took) != sizeof took) ::_exit(1);
  });
  end.transport.subscribe(kChannel);
  end.listen();
  const std::int64_t ready = 0;
  if (::write(answers, &ready, sizeof ready) != sizeof ready) ::_exit(1);
  for (;;) {
    end.wait(100'000, answers);
    char c = 0;
    if (::recv(answers, &c, 1, MSG_DONTWAIT) == 0) ::_exit(0);
    end.service();
  }
}

double quantile(std::vector<std::int64_t>& ns, double q) {
  std::ranges::sort(ns);
  return 1e-6 * double(ns[std::min(ns.size() - 1, std::size_t(q * double(ns.size())))]);
}

/// Waits until all messages have come, or none came for three seconds. @returns how many came
std::int64_t collect(End& end, int answers, std::int64_t wanted, std::vector<std::int64_t>& took) {
  std::int64_t last_us = monotonic_us(), beat_us = 0;
  while (std::int64_t(took.size()) < wanted && monotonic_us() - last_us < 3'000'000) {
    std::int64_t ns = 0;
    while (::recv(answers, &ns, sizeof ns, MSG_DONTWAIT) == sizeof ns) {
      took.push_back(ns);
      last_us = monotonic_us();
    }
    if (std::int64_t(took.size()) >= wanted) break;
    if (monotonic_us() - beat_us >= 100'000) {
      end.beat();
      beat_us = monotonic_us();
    }
    end.wait(20'000, answers);
    end.service();
  }
  return std::int64_t(took.size());
}

void measure(std::size_t bytes, int messages, double seconds) {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0) std::exit(1);
  const std::string url = default_bus_url(free_bus_port(monotonic_ns()));
  const BusKey key = BusKey::random();
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(pair[0]);
    receive(url, key, pair[1]);
  }
  ::close(pair[1]);
  End end(NodeId::kSurfaceMapper, url, key, [](const ChannelInfo&, std::span<const std::byte>) {});
  end.listen();
  std::int64_t seq = 0;
  if (::read(pair[0], &seq, sizeof seq) != sizeof seq) std::exit(1);
  std::vector<std::byte> m = message(bytes);
  std::vector<std::int64_t> took;
  for (int n = 0; n < messages; ++n) {
    send(end, m, ++seq);
    collect(end, pair[0], n + 1, took);
    ::usleep(5000);  // the pace has time
  }
  std::printf("%8zu bytes: one way p50 %.3f ms, p99 %.3f ms of %zu; ", m.size(), quantile(took, 0.5),
              quantile(took, 0.99), took.size());
  std::fflush(stdout);
  const std::int64_t began = monotonic_us(), first = seq;
  const auto before = end.transport.stats().resent;
  std::vector<std::int64_t> flood;
  while (monotonic_us() - began < std::int64_t(seconds * 1e6)) {
    for (int k = 0; k < 16 && end.transport.backlog_bytes() < kBacklogBytes; ++k) send(end, m, ++seq);
    end.service();
    std::int64_t ns = 0;
    while (::recv(pair[0], &ns, sizeof ns, MSG_DONTWAIT) == sizeof ns) flood.push_back(ns);
  }
  collect(end, pair[0], seq - first, flood);
  const double wall_s = double(monotonic_us() - began) * 1e-6;
  std::printf("flood of %.0f messages/s, %.0f MB/s: %llu sent again, %lld of %lld lost\n",
              double(flood.size()) / wall_s, double(flood.size()) * double(m.size()) / wall_s * 1e-6,
              static_cast<unsigned long long>(end.transport.stats().resent - before),
              static_cast<long long>(seq - first - std::int64_t(flood.size())),
              static_cast<long long>(seq - first));
  ::close(pair[0]);
  ::waitpid(child, nullptr, 0);
}

}  // namespace

FIRN_BENCH(bus_latency) {
  const int messages = argc > 1 ? std::max(1, std::atoi(argv[1])) : 200;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 2.0;
  std::printf("receive buffer granted: %d bytes\n", granted_receive_buffer());
  for (const std::size_t bytes : {std::size_t(144), std::size_t(10'000), std::size_t(1'000'000)})
    measure(bytes, messages, seconds);
  return 0;
}

}  // namespace firn::bench::bus_latency
