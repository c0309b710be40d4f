// LampNode connects the lamp to the bus: LAMP_COMMAND, STATE_STAGE, ENABLE, SAFE_STOP, RUN_END, instrument ->
// ANSWER_LAMP, STATE_LAMP, FAULT_LAMP.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/lamp/lamp_driver.h"
#include "drivers/link/some_driver.h"
#include "firn/lamp_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/lamp, of the kind that the settings name: timed exposures, while the stage stands
/// (interlock 9); at the end of the run the node releases the panel.
class LampNode final : public DriverNode<LampNode, drivers::Some<drivers::LampDriver>, drivers::Effects> {
 public:
  explicit LampNode(const Experiment& experiment);

  using DriverNode::on;
  void on(const lamp_command_t&, Time now, Outbox&);
  void on(const run_end_t&, Time now, Outbox&);
  void on(const device_state_t&, Time now, Outbox&);

 private:
  static constexpr std::int64_t kRests = -1;
  void bar(Time now, Outbox& out);

  std::int64_t stage_seq_ = 0;      ///< of the newest STATE_STAGE
  std::int64_t moves_us_ = kRests;  ///< when it told a motion
  std::int64_t commanded_us_ = 0;   ///< when the newest exposure was commanded
};

std::unique_ptr<Node> make_lamp(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
