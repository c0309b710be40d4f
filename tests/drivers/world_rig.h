// WorldRig holds the four drivers of the ink-jet lab wired to the simulated world.
#pragma once

#include "drivers/jet/jet.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/stage/stage.h"
#include "tests/drivers/port_rig.h"

namespace firn::drivers::test {

class WorldRig : public PortRig {
 public:
  explicit WorldRig(const plant::WorldConfig& config, StageOptions stage = fast_stage(),
                    LampOptions lamp = {}, LaserProfilerOptions profiler = {});

  static StageOptions fast_stage();
  static plant::WorldConfig small_world(int nx, int ny);

  void start() { connect_all(); }
  std::vector<Result> results(std::string_view port) const { return all<Result>(port); }
  std::int64_t fired() const;  ///< triggers that the jet obeyed
  /// The stage's requests that contain `text`, as sent.
  int sent(std::string_view port, std::string_view text) const;

  Stage stage;
  Jet jet;
  LaserProfiler profiler;
  Lamp lamp;
};

}  // namespace firn::drivers::test
