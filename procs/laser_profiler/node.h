// LaserProfilerNode connects the laser profiler to the bus: PROFILER_COMMAND, ENABLE, SAFE_STOP, instrument
// -> HEIGHT_PROFILE, SCAN_DONE, ANSWER_LASER_PROFILER, STATE_LASER_PROFILER, FAULT_LASER_PROFILER.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/laser_profiler/profiler_driver.h"
#include "drivers/link/some_driver.h"
#include "firn/height_profile_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/laser_profiler. The y of a profile is the stage's Y at its trigger (the encoder count
/// in the reply) plus the offset of the laser line from the nozzle, or of an instrument without an encoder
/// input that of the order; its x is shifted with the stage's. The swaths of a scan have one numbering of
/// rows and one SCAN_DONE.
class LaserProfilerNode final
    : public DriverNode<LaserProfilerNode, drivers::Some<drivers::ProfilerDriver>, drivers::Effects> {
 public:
  explicit LaserProfilerNode(const Experiment& experiment);

  using DriverNode::on;
  void on(const profiler_command_t&, Time now, Outbox&);
  void on_measured(drivers::ProfileRow&, Time now, Outbox&);
  void on_measured(drivers::ScanDone&, Time now, Outbox&);

 private:
  double counts_per_mm_;
  double offset_y_mm_;
  profiler_command_t scan_{};       // the command that armed the swath
  std::int32_t rows_received_ = 0;  // of the swaths of the scan that are over
};

std::unique_ptr<Node> make_laser_profiler(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
