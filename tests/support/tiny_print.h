// tiny_print() describes an ink-jet print on nine by eight cells, which takes some milliseconds.
#pragma once

#include <string>

#include "config/experiment.h"

namespace firn::test {

inline Experiment tiny_print(const std::string& name, const std::string& scheme = "mpc") {
  Experiment e;
  e.run.name = name;
  e.grid = {9, 8, 0.263256, 0.263256, 0.0, 0.0};
  e.part.shape.kind = "cuboid";
  e.part.shape.width_mm = 1.9;
  e.part.shape.depth_mm = 1.6;
  e.part.shape.height_mm = 0.025;
  e.control.scheme = scheme;
  return e;
}

}  // namespace firn::test
