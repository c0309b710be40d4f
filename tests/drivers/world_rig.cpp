#include "tests/drivers/world_rig.h"

namespace firn::drivers::test {

StageOptions WorldRig::fast_stage() {
  StageOptions c;
  c.z_max_mm = 40.0;
  c.raster_speed_mm_s = 100.0;
  c.move_speed_mm_s = 150.0;
  return c;
}

plant::WorldConfig WorldRig::small_world(int nx, int ny) {
  plant::WorldConfig c;
  c.grid.nx = nx;
  c.grid.ny = ny;
  c.droplet.missed_probability = 0.0;
  c.stage.abort_rate_mm_s2 = fast_stage().acceleration_mm_s2;  // as plant/world/setup.cpp has it
  return c;
}

WorldRig::WorldRig(const plant::WorldConfig& config, StageOptions stage_config, LampOptions lamp_config,
                   LaserProfilerOptions profiler_config)
    : PortRig(config),
      stage(std::move(stage_config)),
      jet(JetOptions{}),
      profiler(std::move(profiler_config)),
      lamp(std::move(lamp_config)) {
  add("stage", stage);
  add("jet", jet);
  add("laser_profiler", profiler);
  add("lamp", lamp);
}

std::int64_t WorldRig::fired() const { return world.truth().droplets_fired; }

int WorldRig::sent(std::string_view name, std::string_view text) const {
  const auto it = written.find(name);
  if (it == written.end()) return 0;
  int n = 0;
  for (std::size_t at = it->second.find(text); at != std::string::npos; at = it->second.find(text, at + 1))
    ++n;
  return n;
}

}  // namespace firn::drivers::test
