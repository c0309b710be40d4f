// StageNode connects the stage to the bus: STAGE_COMMAND, LINE_PLAN, ENABLE, SAFE_STOP, instrument ->
// FOLLOWED_PATH, ANSWER_STAGE, STATE_STAGE, FAULT_STAGE.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "core/grid/offsets.h"
#include "drivers/link/some_driver.h"
#include "drivers/stage/stage_driver.h"
#include "firn/line_plan_t.hpp"
#include "firn/stage_command_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/stage: one pass, scan, path or move per command.
class StageNode final : public DriverNode<StageNode, drivers::Some<drivers::StageDriver>, drivers::Effects> {
 public:
  explicit StageNode(const Experiment& experiment);

  using DriverNode::on;
  void on(const stage_command_t&, Time now, Outbox&);
  void on(const line_plan_t& plan, Time, Outbox&) { plan_ = plan; }  ///< kept for the command that follows it
  void on_measured(drivers::FollowedWay& way, Time, Outbox&);

 private:
  OffsetTable places_;
  line_plan_t plan_ = line_plan_t{};
  stage_command_t traced_ = stage_command_t{};  ///< the last command that follows a path
};

std::unique_ptr<Node> make_stage(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
