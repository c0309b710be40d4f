#include "print/live/row_rehearsal.h"

#include <fmt/core.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <thread>

#include "config/labs.h"
#include "files/usage_error.h"

namespace firn {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kRehearsal_s = 0.5;
constexpr int kMaxRows = 200;
constexpr double kMargin = 1.5;      // of the longest time measured
constexpr double kMinShare = 0.125;  // of the speed asked for

struct SocketPair {
  int ends[2] = {-1, -1};
  SocketPair() {
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0)
      throw UsageError("no socket for the rehearsal of a scan");
  }
  ~SocketPair() {
    for (const int fd : ends)
      if (fd >= 0) ::close(fd);
  }
  SocketPair(const SocketPair&) = delete;
  SocketPair& operator=(const SocketPair&) = delete;
};

}  // namespace

double slowest_row_s(double period_s) {
  const int rows = std::clamp(int(kRehearsal_s / std::max(period_s, 1e-4)), 4, kMaxRows);
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(std::min(period_s, kRehearsal_s / 4.0)));
  SocketPair line;
  const Clock::time_point begin = Clock::now() + period;
  // An instrument sends a row when it is due; the reader of another thread is late by the machine's load.
  std::thread instrument([&] {
    std::array<char, 4096> row{};
    for (int n = 0; n < rows; ++n) {
      std::this_thread::sleep_until(begin + n * period);
      if (::send(line.ends[0], row.data(), row.size(), MSG_NOSIGNAL) < 0) break;
    }
    ::shutdown(line.ends[0], SHUT_WR);
  });
  double slowest = 0.0;
  std::size_t bytes = 0;
  std::array<char, 4096> in{};
  for (;;) {
    const ssize_t n = ::recv(line.ends[1], in.data(), in.size() - bytes % in.size(), 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    bytes += std::size_t(n);
    if (bytes % in.size() != 0) continue;
    const Clock::time_point due = begin + int(bytes / in.size() - 1) * period;
    slowest = std::max(slowest, std::chrono::duration<double>(Clock::now() - due).count());
  }
  instrument.join();
  return slowest;
}

double row_period_s(const Experiment& e, double speed_mm_s) {
  return e.grid.pitch_y_mm / speed_mm_s / e.run.time_scale;
}

std::string fit_scan_speed(Experiment& e, double slowest_s) {
  if (prints_paths(e)) return "";  // its laser stores the readings of a whole path
  const double asked = e.process.scan_speed_mm_s, needed_s = kMargin * slowest_s;
  if (row_period_s(e, asked) >= needed_s) return "";
  const double speed = std::floor(e.grid.pitch_y_mm / (needed_s * e.run.time_scale) * 100.0) / 100.0;
  const std::string why = fmt::format(
      "rows of {:g} mm come every {:.2f} ms of wall time, and this machine took up to {:.2f} ms to "
      "read one",
      e.grid.pitch_y_mm, row_period_s(e, asked) * 1e3, slowest_s * 1e3);
  if (!(speed >= kMinShare * asked))
    throw UsageError(
        fmt::format("process.scan_speed_mm_s = {:g}: {}. Set process.scan_speed_mm_s to at most {:.2f}{}, or "
                    "wait until the "
                    "machine is less busy; --bus in-process loses no row at any speed",
                    asked, why, speed, e.run.time_scale > 1.0 ? ", or --speedup lower" : ""));
  e.process.scan_speed_mm_s = speed;
  return fmt::format("process.scan_speed_mm_s = {:.2f} instead of {:g}: {}", speed, asked, why);
}

}  // namespace firn
