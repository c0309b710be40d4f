// Measures the robot's V+ program on the simulated controller (plant/twins/vplus).
//
//   build/bench/vplus_bench speed                     # path points a second, by statements in a tick and
//   lines in a block build/bench/vplus_bench difference [COMMANDS [SEEDS]]   # both twins of the robot,
//   command by command
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/plant/robot_pair.h"
#include "tests/plant/vplus_text.h"

namespace {

using namespace firn;
using namespace firn::plant;

constexpr double kNeeded = 1.0 / 0.016;  // points a second: those of the path that runs meanwhile

struct Upload {
  double points_per_s = 0.0, longest_reply_s = 0.0;
  bool whole = false;
};

/// Loads a path as the driver does: blocks of lines of which the last one is answered.
Upload upload(IceBench& b, std::int32_t id, const std::vector<drivers::fvp::Counts>& counts, int lines) {
  const std::int64_t from_us = b.now_us;
  Upload u;
  b.robot("PATH BEGIN " + std::to_string(id) + " N=" + std::to_string(counts.size()) + " DT=0.016");
  drivers::fvp::FvpDialect dialect;
  dialect.points = counts;
  for (std::size_t at = 0; at < counts.size();) {
    const std::size_t count = std::min(counts.size() - at, std::size_t(lines) * 3);
    b.seq = drivers::fvp::next_seq(b.seq);
    std::vector<std::byte> bytes;
    dialect.write(drivers::fvp::path_block(b.seq, at, count, 0), bytes);
    const std::int64_t sent_us = b.now_us;
    b.ask(kRobotPort, bytes, 600'000'000);
    u.longest_reply_s = std::max(u.longest_reply_s, double(b.now_us - sent_us) * 1e-6);
    at += count;
  }
  drivers::fvp::PointsCrc crc;
  for (const auto& c : counts) crc.add(c);
  char hex[5];
  std::snprintf(hex, sizeof hex, "%04X", unsigned(crc.value()));
  u.whole = b.robot(std::string("PATH END ") + hex) == "ACK " + std::to_string(counts.size());
  u.points_per_s = double(counts.size()) / (double(b.now_us - from_us) * 1e-6);
  return u;
}

Upload measured(int statements_per_tick, int lines, bool checks, bool running) {
  IceWorldConfig config = small();
  config.robot = shipped_program(statements_per_tick);
  if (checks) {
    std::string& text = config.robot.texts[0].text;
    const std::string_view off = "fv.checks = FALSE";
    text.replace(text.find(off), off.size(), "fv.checks = TRUE");
  }
  IceBench b(config);
  b.run(10'000'000);
  b.home();
  if (running) {  // a path that lasts longer than the upload
    std::vector<drivers::fvp::Counts> slow(3000, drivers::fvp::Counts{5, 900000, 100000, 7});
    for (std::size_t n = 0; n < slow.size(); ++n) slow[n][0] += std::int32_t(n);
    upload(b, 1, slow, 8);
    b.move_to(drivers::fvp::joints_of(slow.front()));
    b.robot("PATH RUN 1 0");
  }
  std::vector<drivers::fvp::Counts> counts;
  for (std::int32_t n = 0; n < 300; ++n)
    counts.push_back({-312345 + n * 37, 1012345 - n * 29, 123456, -701234 + n * 8});
  Upload u = upload(b, 2, counts, lines);
  if (running && b.world.ice()->vplus_robot()->late_segments() > 0) u.whole = false;
  return u;
}

int speed() {
  std::printf("A path that runs needs %.1f points a second. A block's reply is awaited for 0.25 s.\n",
              kNeeded);
  std::printf("%-16s %-6s %-22s %-22s %-22s\n", "statements/tick", "lines", "points/s (reply, s)",
              "while a path runs", "each line's CRC too");
  for (const int budget : {80, 160, 320, 640, 1600})
    for (const int lines : {1, 4, 8, 64}) {
      std::printf("%-16d %-6d", budget, lines);
      for (int k = 0; k < 3; ++k) {
        const Upload u = measured(budget, lines, k == 2, k == 1);
        std::printf(" %7.1f (%5.3f)%-7s", u.points_per_s, u.longest_reply_s, u.whole ? "" : " LATE");
        std::fflush(stdout);
      }
      std::printf("\n");
    }
  return 0;
}

int difference(std::int64_t commands, int seeds) {
  std::size_t differences = 0;
  for (const int budget : {80, 160, 1600})
    for (int seed = 1; seed <= seeds; ++seed) {
      IceWorldConfig config = small();
      config.arm.slip_probability = 0.2;
      RobotPair pair(config, shipped_program(budget), std::uint64_t(seed));
      pair.run(commands);
      const PairCounts& c = pair.counts();
      std::printf(
          "%d statements/tick, seed %d: %lld commands, %lld sent again, %lld refused, %lld reconnects, %lld "
          "reboots, %lld paths, "
          "%lld samples of motion, %lld stops, %lld silences, %lld trips, %lld slips: %zu differences\n",
          budget, seed, (long long)c.commands, (long long)c.resent, (long long)c.refused,
          (long long)c.reconnects, (long long)c.reboots, (long long)c.paths, (long long)c.samples,
          (long long)c.stops, (long long)c.silences, (long long)c.trips, (long long)c.slips,
          pair.differences().size());
      for (const std::string& d : pair.differences()) std::printf("  %s\n", d.c_str());
      differences += pair.differences().size();
    }
  return differences == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "speed") == 0) return speed();
  if (argc > 1 && std::strcmp(argv[1], "difference") == 0)
    return difference(argc > 2 ? std::atoll(argv[2]) : 10'000, argc > 3 ? std::atoi(argv[3]) : 3);
  std::fprintf(stderr, "usage: vplus_bench speed | difference [COMMANDS [SEEDS]]\n");
  return 2;
}
