#include "procs/stage/node.h"

#include <utility>

#include "config/device_kinds.h"
#include "config/labs.h"
#include "config/nozzles.h"
#include "drivers/stage/grbl_stage.h"
#include "drivers/stage/script_stage.h"
#include "drivers/stage/stage.h"
#include "firn/followed_path_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

drivers::StageOptions stage_config(const Experiment& e) {
  drivers::StageOptions c{e.stage};
  c.raster_speed_mm_s = e.process.pass_speed_mm_s;
  c.move_speed_mm_s = e.process.pass_speed_mm_s;
  c.max_pulse_rate_hz = jets_rate_hz(e);
  c.host_latency_s = host_latency_s(e.run.time_scale);
  return c;
}

std::unique_ptr<drivers::StageDriver> stage_driver(const Experiment& e) {
  const drivers::StageOptions c = stage_config(e);
  if (is_python_driver(e, "stage"))
    return std::make_unique<drivers::ScriptStage>(script_options(e, "stage", c.host_latency_s), c);
  if (has_grbl_stage(e)) return std::make_unique<drivers::GrblStage>(c);
  return std::make_unique<drivers::Stage>(c);
}

// The way of a plan; the shutter's switches as the plan has them.
drivers::StageWay way_of(const line_plan_t& plan) {
  drivers::StageWay way;
  for (std::size_t k = 0; k < plan.t_s.size(); ++k)
    way.knots.push_back({plan.t_s[k], plan.x_mm[k], plan.y_mm[k], plan.vx_mm_s[k], plan.vy_mm_s[k]});
  way.switch_mm = plan.switch_mm;
  return way;
}

}  // namespace

StageNode::StageNode(const Experiment& e)
    : DriverNode(NodeId::kStage, stage_driver(e)), places_(e.actuation) {
  subscribe(channels::kStageCommand, this);
  if (prints_lines(e)) subscribe(channels::kLinePlan, this);
}

void StageNode::on(const stage_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  using Stage = drivers::Some<drivers::StageDriver>;
  switch (StageVerb(c.verb)) {
    case StageVerb::kPass:
      return perform(c, true, now, out, [&](Stage& stage, std::int64_t now_us, Effects& fx) {
        stage->run_pass(fires_of(c), 0, c.z_mm, c.speed_mm_s, now_us, fx, c.lead_mm,
                        placement_of(c, places_));
      });
    case StageVerb::kScan:
      return perform(c, false, now, out, [&](Stage& stage, std::int64_t now_us, Effects& fx) {
        stage->scan(c.x_mm, c.y_mm, c.z_mm, c.grid.pitch_y_mm, c.rows, c.speed_mm_s, now_us, fx);
      });
    case StageVerb::kTrace: {
      if (c.command_id > traced_.command_id) traced_ = c;
      // Without its plan the command would follow a way of no knots, which the driver refuses.
      drivers::StageWay way = plan_.path == c.scan_id ? way_of(plan_) : drivers::StageWay{};
      return perform(c, true, now, out, [&](Stage& stage, std::int64_t now_us, Effects& fx) {
        stage->trace(std::move(way), c.z_mm, now_us, fx);
      });
    }
    case StageVerb::kMove:
      return perform(c, false, now, out, [&](Stage& stage, std::int64_t now_us, Effects& fx) {
        stage->move_to(c.x_mm, c.y_mm, c.z_mm, c.speed_mm_s, now_us, fx);
      });
    case StageVerb::kHome:
      return perform(c, false, now, out,
                     [](Stage& stage, std::int64_t now_us, Effects& fx) { stage->home(now_us, fx); });
  }
}

void StageNode::on_measured(drivers::FollowedWay& way, Time, Outbox& out) {
  followed_path_t m{};
  m.n = std::int32_t(way.x_mm.size());
  m.path = traced_.scan_id;
  m.layer = traced_.layer;
  m.attempt = traced_.attempt;
  m.period_s = way.period_s;
  m.begin_utime_us = way.begin_us;
  m.x_mm = std::move(way.x_mm);
  m.y_mm = std::move(way.y_mm);
  out.send(channels::kFollowedPath, m);
}

std::unique_ptr<Node> make_stage(const std::string& config_toml, const Blobs&) {
  return std::make_unique<StageNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
