// The four drivers wired to the simulated world at byte level, in simulated time: two sides written
// independently from the same cards.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "drivers/jet/jet.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/stage/stage.h"
#include "plant/world.h"

namespace firn::drivers::test {

class MemoryRecord final : public plant::WorldRecord {
 public:
  void append(plant::RecordKind kind, std::span<const std::byte> payload) override {
    plant::decode(kind, payload, history);
  }
  plant::WorldHistory history;
};

class WorldRig {
 public:
  explicit WorldRig(const plant::WorldConfig& config, StageConfig stage = fast_stage());

  static StageConfig fast_stage();
  static plant::WorldConfig small_world(int nx, int ny);

  using Act = std::function<void(std::int64_t, Effects&)>;
  void act(std::string_view port, const Act& f);
  /// Runs until `done` or the limit; @returns done().
  bool run(const std::function<bool()>& done, double limit_s);
  void run_for(double s) {
    run([] { return false; }, s);
  }
  bool all_safe() const;
  void start();                        ///< connects everything and waits until all are SAFE
  void kill(std::string_view port);    ///< the process dies: the port is closed, the driver does nothing
  void resume(std::string_view port);  ///< it is back with what it knew

  std::vector<Result> results(std::string_view port) const;
  std::int64_t fired() const;  ///< triggers that the jet obeyed
  /// The stage's requests that contain `text`, as sent.
  int sent(std::string_view port, std::string_view text) const;

  MemoryRecord record;
  plant::World world;
  Stage stage;
  Jet jet;
  LaserProfiler profiler;
  Lamp lamp;
  std::int64_t now_us = 0;
  std::map<std::string, std::vector<DriverEvent>, std::less<>> events;
  std::map<std::string, std::string, std::less<>> written;

 private:
  struct Port {
    std::string name;
    Driver* driver;
    std::int64_t wake_us = 0;
    bool connected = false;
    bool dead = false;
  };
  Port& port(std::string_view name);
  void step(Port& p, const std::function<void(Effects&)>& f);

  std::vector<Port> ports_;
};

}  // namespace firn::drivers::test
