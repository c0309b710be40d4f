// shipped_program() returns the V+ text of drivers/robot/vplus for the robot's second twin.
#pragma once

#include "files/text_file.h"
#include "plant/config/ice_config.h"

namespace firn::plant {

inline IceRobotProgram shipped_program(int statements_per_tick = 160) {
  IceRobotProgram p;
  for (const char* file : {"firn.v2", "lines.v2", "motion.v2", "paths.v2"})
    p.texts.push_back({file, read_file(std::string(FIRN_SOURCE_DIR) + "/drivers/robot/vplus/" + file)});
  p.statements_per_tick = statements_per_tick;
  return p;
}

}  // namespace firn::plant
