// execute reads and runs one of the Ensemble's ASCII commands and returns its reply line.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "plant/twins/stage.h"

namespace firn::plant {

struct StageReply {
  std::string text;             ///< with its first character and end of line
  bool started_motion = false;  ///< LINEAR or HOME was accepted
  int wait_mode = -1;           ///< WAIT MODE given: 0 NOWAIT, 1 MOVEDONE
  bool blocks = false;          ///< the interpreter waits for that motion in either mode
};

/// Executes `line` (without its end) on the device. Never throws; an unknown command is answered with
/// `!`.
StageReply execute(StageDevice& device, std::string_view line, std::int64_t now_us);

}  // namespace firn::plant
