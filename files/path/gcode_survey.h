// survey_gcode() finds out which moves of a G-code file deposit: a printer's axis E or a beam's power says
// so, or nothing does.
#pragma once

#include <istream>
#include <string>

#include "files/path/gcode_block.h"

namespace firn {

/// Longest line of G-code with its comment: slicers write their settings as comments, some of 20 kB.
inline constexpr std::size_t kMaxGcodeLineBytes = std::size_t(1) << 20;

struct GcodeSurvey {
  enum class Material {
    kMoves,     ///< every G1, G2, G3 and G5 deposits
    kExtruder,  ///< moves with a growing E
    kBeam,      ///< moves while M3 or M4 holds and S, if the file has it, is above 0
  };
  Material material = Material::kMoves;
  GcodeExponent exponent = GcodeExponent::kExponent;
  bool switched = false;   ///< M3 or M4 switches the beam on, not S alone
  bool has_power = false;  ///< S commands the beam's power
  int decimals = 0;        ///< the most of a coordinate
};

/// Reads the whole stream. @throws UsageError naming file and line
GcodeSurvey survey_gcode(std::istream& in, const std::string& name);

}  // namespace firn
