// RobotPair sends the same commands to both twins of the robot, the one that is written from FVP/1 and the
// one that executes the V+ text, under the same faults, and compares replies, events and motions.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "plant/twins/vplus_robot.h"
#include "tests/plant/ice_bench.h"

namespace firn::plant {

struct PairCounts {
  std::int64_t commands = 0, resent = 0, reconnects = 0, reboots = 0, paths = 0, paths_through = 0, stops = 0,
               trips = 0, silences = 0, slips = 0, samples = 0, refused = 0;
};

class RobotPair {
 public:
  /// @param statements_per_tick of the V+ controller
  RobotPair(const IceWorldConfig& config, const IceRobotProgram& program, std::uint64_t seed);

  /// Sends random commands until there are `count`, in turns of moves, paths, stops, faults and refusals.
  void run(std::int64_t count);
  const std::vector<std::string>& differences() const { return differences_; }  ///< at most 20
  const PairCounts& counts() const { return counts_; }
  const vplus::Machine& machine() const { return bench_[1].world.ice()->vplus_robot()->machine(); }

 private:
  using Replies = std::array<std::string, 2>;
  struct Bench {
    explicit Bench(const IceWorldConfig& config) : world(IceBench::config_of(config, 1.0), &record) {}
    MemoryRecord record;
    World world;
    std::int64_t now_us = 0;
    std::string heard;
    std::size_t read = 0;  ///< of heard
    std::vector<std::string> events;
    std::vector<Joints> trace;  ///< commanded joints, one for each sample of the arm while traced
    bool traced = false;
    double newest_s = -1.0;
  };

  int roll(int below) { return int(random_() % std::uint32_t(below)); }
  bool chance(double p) { return double(random_() % 1'000'000) < p * 1e6; }
  void run_for(std::int64_t us);
  void advance(Bench& b, std::int64_t us);
  void send(Bench& b, const std::string& line, bool cut);
  std::string reply_of(Bench& b, std::int64_t seq, std::int64_t limit_us);
  Replies ask(const std::string& words);
  void connect();
  void differ(const std::string& what, const std::string& a, const std::string& b);
  void compare_events(const std::string& when);
  std::array<int, 2> compare_status();  ///< @returns the last path's times [ms]
  void compare_place();

  void one_turn();
  void ready();
  void some_questions(int count);
  std::string random_command();
  void go_to(const Joints& q);
  void go_anywhere();
  void load(std::int32_t id, const std::vector<Joints>& points);
  void load_badly();
  void run_path(bool interrupt);
  void interrupt_motion();
  void recover();
  void reconnect();
  void reboot();

  IceWorldConfig config_;
  std::mt19937 random_;
  std::array<Bench, 2> bench_;
  std::int64_t seq_ = 0;
  PairCounts counts_;
  std::vector<std::string> differences_;
  std::vector<std::vector<Joints>> loaded_ = {{}, {}};
  bool same_place_ = false;
};

}  // namespace firn::plant
