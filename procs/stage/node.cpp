#include "procs/stage/node.h"

#include "lcmtypes/convert.h"

namespace firn {
namespace {

drivers::StageOptions stage_config(const Experiment& e) {
  drivers::StageOptions c{e.stage};
  c.raster_speed_mm_s = e.process.pass_speed_mm_s;
  c.move_speed_mm_s = e.process.pass_speed_mm_s;
  c.max_pulse_rate_hz = e.jet.max_rate_hz;
  c.host_latency_s = host_latency_s(e.run.time_scale);
  return c;
}

}  // namespace

StageNode::StageNode(const Experiment& e) : DriverNode(NodeId::kStage, stage_config(e)) {
  subscribe(channels::kStageCommand, this);
}

void StageNode::on(const stage_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  using drivers::Stage;
  switch (StageVerb(c.verb)) {
    case StageVerb::kPass:
      return perform(c, true, now, out, [&](Stage& stage, std::int64_t now_us, Effects& fx) {
        stage.run_pass(fires_of(c), 0, c.z_mm, c.speed_mm_s, now_us, fx);
      });
    case StageVerb::kScan:
      return perform(c, false, now, out, [&](Stage& stage, std::int64_t now_us, Effects& fx) {
        stage.scan(c.x_mm, c.y_mm, c.z_mm, c.grid.pitch_y_mm, c.rows, c.speed_mm_s, now_us, fx);
      });
    case StageVerb::kMove:
      return perform(c, false, now, out, [&](Stage& stage, std::int64_t now_us, Effects& fx) {
        stage.move_to(c.x_mm, c.y_mm, c.z_mm, c.speed_mm_s, now_us, fx);
      });
    case StageVerb::kHome:
      return perform(c, false, now, out,
                     [](Stage& stage, std::int64_t now_us, Effects& fx) { stage.home(now_us, fx); });
  }
}

std::unique_ptr<Node> make_stage(const std::string& config_toml, const Blobs&) {
  return std::make_unique<StageNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
