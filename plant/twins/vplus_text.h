// vplus_texts() returns the V+ programs of drivers/robot/vplus as they were when the program was built.
#pragma once

#include <vector>

#include "plant/config/ice_config.h"

namespace firn::plant {

std::vector<IceProgramText> vplus_texts();

}  // namespace firn::plant
