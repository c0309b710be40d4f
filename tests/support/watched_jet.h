// watch_jet() gives an ink-jet print a camera that sees its jet in small pictures before every layer.
#pragma once

#include "config/experiment.h"

namespace firn::test {

inline void watch_jet(Experiment& e) {
  e.camera.use = e.watch.gate = e.watch.placement = OnOff::kOn;
  e.watch.every_layers = 1;
  e.watch.frames = 6;
  e.watch.step_us = 20.0;
  e.watch.um_per_px = e.plant.camera.um_per_px;
  e.plant.camera.drop_speed_m_s = 2.0;
  e.plant.camera.width_px = 96;
  e.plant.camera.height_px = 200;
}

}  // namespace firn::test
