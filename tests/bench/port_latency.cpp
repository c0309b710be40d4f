// Measures two times of a serial line, each over N rounds: until a second opener is refused with the holder's
// name, and from a stop to the first of its bytes in the line's driver while 4 KB wait at 9600 baud. A UART
// has up to 16 bytes more in its own queue, 16.7 ms at 9600 baud; a pseudo terminal has not.
//   ./firn bench port_latency [N]
#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "runtime/ports.h"
#include "runtime/run_clock.h"
#include "runtime/serial_line.h"
#include "tests/bench/bench.h"

namespace firn::bench::port_latency {

namespace {

using namespace firn;

constexpr double kFifo_ms = 16 * 10 / 9600.0 * 1e3;

struct Line {
  Line() {
    if (::openpty(&master, &slave, name, nullptr, nullptr) != 0) std::abort();
    ::fcntl(master, F_SETFL, O_NONBLOCK);
    address = parse_port_address("serial:" + std::string(name) + "?baud=9600");
  }
  ~Line() {
    ::close(slave);
    ::close(master);
  }
  int master = -1, slave = -1;
  char name[128];
  PortAddress address;
};

void show(const char* what, std::vector<double> ms, double more_ms) {
  std::ranges::sort(ms);
  double load[3] = {};
  ::getloadavg(load, 3);
  const auto at = [&](double share) {
    return ms[std::min(ms.size() - 1, std::size_t(share * double(ms.size())))] + more_ms;
  };
  std::printf("%s: p50 %.3f ms, p99 %.3f ms, most %.3f ms of %zu; load %.1f\n", what, at(0.5), at(0.99),
              ms.back() + more_ms, ms.size(), load[0]);
}

bool second_opener(int rounds) {
  Line line;
  int ready[2];
  if (::pipe(ready) != 0) return false;
  const pid_t holder = ::fork();
  if (holder == 0) {
    std::string why;
    const char held = open_serial_line(line.address, why) >= 0 ? 'y' : 'n';
    if (::write(ready[1], &held, 1) != 1) ::_exit(1);
    for (;;) ::pause();
  }
  char held = 'n';
  bool named = ::read(ready[0], &held, 1) == 1 && held == 'y';
  std::vector<double> ms;
  for (int n = 0; n < rounds; ++n) {
    std::string why;
    const std::int64_t began_us = monotonic_us();
    const int fd = open_serial_line(line.address, why);
    ms.push_back(double(monotonic_us() - began_us) * 1e-3);
    named = named && fd < 0 && why.find("process " + std::to_string(holder)) != std::string::npos;
    if (fd >= 0) ::close(fd);
  }
  ::kill(holder, SIGKILL);
  ::waitpid(holder, nullptr, 0);
  show(named ? "a second opener is refused, the holder named" : "NOT REFUSED by name", ms, 0.0);
  return named;
}

bool stop_on_the_wire(int rounds) {
  std::vector<double> ms;
  bool sent = true;
  const std::string queued(4096, 'x');
  for (int n = 0; n < rounds; ++n) {
    Line line;
    Ports ports({line.address});
    ports.open_all(monotonic_us());
    bool open = false;
    const auto turn = [&] {
      ports.service(
          monotonic_us(), [&](PortId, LinkState link) { open = link == LinkState::kOpen; },
          [](PortId, std::span<const std::byte>) {});
    };
    while (!open) turn();
    ports.write(PortId{0}, std::as_bytes(std::span(queued)), true);
    turn();
    std::int64_t left_us = 0;
    ports.record([&](PortId, Cassette::Kind kind, std::span<const std::byte>) {
      if (kind == Cassette::Kind::kSent && left_us == 0) left_us = monotonic_us();
    });
    const std::int64_t began_us = monotonic_us();
    ports.drop_waiting(PortId{0});
    ports.write(PortId{0}, std::as_bytes(std::span("S", 1)), false);
    while (left_us == 0 && monotonic_us() - began_us < 1'000'000) turn();
    sent = sent && left_us != 0;
    ms.push_back(double((left_us == 0 ? monotonic_us() : left_us) - began_us) * 1e-3);
  }
  show(sent ? "stop to its first byte, 9600 baud, 4 KB queued, 16 bytes of a UART added" : "NOT SENT", ms,
       kFifo_ms);
  return sent;
}

}  // namespace

FIRN_BENCH(port_latency) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 1000;
  const bool refused = second_opener(rounds), sent = stop_on_the_wire(rounds);
  return refused && sent ? 0 : 1;
}

}  // namespace firn::bench::port_latency
