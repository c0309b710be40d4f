// Bench holds a world with its bytes at hand: it sends to a port, runs for a while and returns the replies.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plant/world/world.h"

namespace firn::plant {

/// Keeps everything in memory.
class MemoryRecord : public WorldRecord {
 public:
  void append(RecordKind kind, std::span<const std::byte> payload) override {
    ok = decode(kind, payload, history) && ok;
  }
  WorldHistory history;
  bool ok = true;
};

class Bench {
 public:
  explicit Bench(const WorldConfig& config) : world(config, &record) {
    for (const auto port : {kStagePort, kJetPort, kProfilerPort, kLampPort}) world.connect(port, now_us);
  }
  void send(std::string_view port, std::string_view bytes) {
    world.receive(port, std::as_bytes(std::span(bytes.data(), bytes.size())), now_us);
  }
  /// Lets `us` pass, collecting all bytes.
  void run(std::int64_t us) {
    now_us += us;
    world.advance(now_us, [&](const World::Sent& s) {
      log.push_back({std::string(s.port), s.t_us,
                     std::string(reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size()), s.close});
      heard[std::string(s.port)] += log.back().bytes;
      closed[std::string(s.port)] |= s.close;
    });
  }
  /// Sends, waits until the port answers (at most `limit_us`) and returns the answer.
  std::string ask(std::string_view port, std::string_view bytes, std::int64_t limit_us = 5'000'000) {
    heard[std::string(port)].clear();
    send(port, bytes);
    const std::int64_t until_us = now_us + limit_us;
    while (heard[std::string(port)].empty() && world.next_event_us() <= until_us)
      run(world.next_event_us() - now_us);
    return heard[std::string(port)];
  }
  std::string stage(std::string_view line) { return ask(kStagePort, std::string(line) + "\n"); }

  struct Line {
    std::string port;
    std::int64_t t_us;
    std::string bytes;
    bool close;
    bool operator==(const Line&) const = default;
  };
  MemoryRecord record;
  World world;
  std::int64_t now_us = 0;
  std::vector<Line> log;
  std::map<std::string, std::string> heard;
  std::map<std::string, bool> closed;
};

inline std::string hex(std::string_view text) {
  std::string bytes;
  int high = -1;
  for (const char c : text) {
    const int d = c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    if (d < 0) continue;
    if (high < 0)
      high = d;
    else {
      bytes.push_back(char(high << 4 | d));
      high = -1;
    }
  }
  return bytes;
}

/// Makes the jet ready to be fired by the stage.
inline void start_jet(Bench& b) {
  b.ask(kJetPort, "Q");
  for (const char* c : {"X", "2", "0", "0", "0"}) b.ask(kJetPort, c);
  b.ask(kJetPort, hex("53 15 06 00 00 00 C8 00 01 90 00 00 00 14 FF EC 00 1E 00 1E 00 1E CD"));
  b.ask(kJetPort, hex("53 04 12 03 E8 01"));
}
inline void arm_jet(Bench& b) { b.ask(kJetPort, hex("53 03 08 01 0C")); }
inline void disarm_jet(Bench& b) { b.ask(kJetPort, hex("53 03 08 00 0B")); }

inline void start_stage(Bench& b, double ramp_mm_s2 = 5000.0) {
  b.stage("WAIT MODE NOWAIT");
  b.stage("ABS");
  for (const char* axis : {"@0", "@1", "@2"}) b.stage(std::string("ENABLE ") + axis);
  b.stage("RAMP RATE " + std::to_string(ramp_mm_s2));
}

/// Moves and waits for standstill.
inline void go(Bench& b, const std::string& line) {
  b.stage(line);
  while (b.stage("PLANESTATUS(0)") != "%0\n") b.run(2000);
}

/// Prints `rows` x `columns` droplets at the grid's cells in serpentine rows, as a driver does, and cures.
void print_layer(Bench& b, int columns, int rows);

}  // namespace firn::plant
