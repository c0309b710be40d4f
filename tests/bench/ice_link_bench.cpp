// ice_link_bench [POINTS]: CPU seconds that the links of the ice printer cost for a print of POINTS
// trajectory points (default 3,900,000: 1.3 million path lines, a whole gear) and a tenth as many pulses, in
// paths of 1,250 points.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "drivers/robot/robot.h"
#include "drivers/valve/fvb.h"
#include "tests/bench/bench.h"
#include "tests/support/valve_firmware.h"

namespace firn::bench::ice_link_bench {

using namespace firn::drivers;

namespace {

double cpu_s() { return double(std::clock()) / CLOCKS_PER_SEC; }

std::vector<double> path(std::size_t points, double shift) {
  std::vector<double> q;
  for (std::size_t n = 0; n < points; ++n) {
    const double u = double(n) / double(points - 1);
    q.insert(q.end(), {-0.9 + shift + 0.2 * u, 1.6 - 0.1 * u, 24.0, -0.7 - shift - 0.1 * u});
  }
  return q;
}

}  // namespace

FIRN_BENCH(ice_link_bench) {
  const std::size_t points = argc > 1 ? std::size_t(std::atoll(argv[1])) : 3'900'000;
  constexpr std::size_t kPath = 1250, kBlock = 192;
  const std::vector<double> q = path(kPath, 0.01);
  std::vector<fvp::Counts> counts(kPath), back;
  fvp::FvpDialect dialect;
  std::vector<std::byte> tx;
  double convert = 0, write = 0, sum = 0, read = 0;
  std::size_t lines = 0, bytes = 0;
  std::uint64_t check = 0;
  for (std::size_t done = 0; done < points; done += kPath) {
    double t = cpu_s();
    for (std::size_t n = 0; n < kPath; ++n)
      counts[n] = fvp::counts_of({q[4 * n], q[4 * n + 1], q[4 * n + 2], q[4 * n + 3]});
    convert += cpu_s() - t;
    t = cpu_s();
    fvp::PointsCrc crc;
    for (const fvp::Counts& c : counts) crc.add(c);
    check += crc.value();
    sum += cpu_s() - t;
    dialect.points = counts;
    back.clear();
    for (std::size_t at = 0; at < kPath; at += kBlock) {
      tx.clear();
      t = cpu_s();
      dialect.write(fvp::path_block(7, at, kBlock, 0), tx);
      write += cpu_s() - t;
      t = cpu_s();
      std::string_view text(reinterpret_cast<const char*>(tx.data()), tx.size());
      for (; !text.empty(); ++lines) {
        const std::size_t end = text.find('\n') + 1;
        WordReader words(fvp::parse(text.substr(0, end)).text);
        words.word();
        words.word();
        words.number(0, fvp::kMaxPoints);
        while (!words.at_end()) back.push_back(fvp::parse_counts(words).value());
        text.remove_prefix(end);
      }
      read += cpu_s() - t;
      bytes += tx.size();
    }
    if (back != counts) return std::printf("points were lost\n"), 1;
  }
  std::printf(
      "%zu points, %zu path lines, %.1f MB: convert %.2f s, CRC %.2f s, write %.2f s, read %.2f s of CPU\n",
      points, lines, double(bytes) * 1e-6, convert, sum, write, read);

  std::vector<std::uint16_t> ticks;
  for (std::size_t n = 0; n < kPath / 10; ++n) ticks.push_back(std::uint16_t(80 * n));
  double t = cpu_s();
  for (std::size_t done = 0; done < points / 10; done += ticks.size()) {
    tx.clear();
    fvb::encode_data(3, 0, ticks, tx);
    const auto d = fvb::parse_data(fvb::find(tx).payload);
    check += d ? d->tick(d->entries - 1) : 0;
  }
  std::printf("%zu pulses written and read: %.3f s of CPU (%llu)\n", points / 10, cpu_s() - t,
              static_cast<unsigned long long>(check));

  // The driver on a robot that answers every block at once: the cost for the host, without the robot.
  t = cpu_s();
  Robot robot{RobotOptions{}};
  Effects fx;
  const std::size_t paths = points / kPath / 10;
  for (std::size_t p = 1; p <= paths; ++p) {
    robot.add_path(std::int64_t(p), 0.016, 4, q, std::int64_t(p), fx);
    fx.clear();
  }
  std::printf("%zu paths checked and kept by the driver: %.3f s of CPU\n", paths, cpu_s() - t);
  return 0;
}

}  // namespace firn::bench::ice_link_bench
