// kShortHelp is the answer of firn without a command. The script ./firn reads it from here, too, so
// that it can be read before anything is built: lines that begin with two blanks and "firn" are commands.
#pragma once

namespace firn {

inline constexpr const char* kShortHelp =
    R"(Firn prints a part layer by layer, measures the surface after each layer, and decides the next layer from it.

  firn demo                           prints a cylinder in the simulated lab, replays it, writes report.html
  firn print part.png --height 0.1    prints a part, drawn black on white; a run folder keeps everything
  firn report runs/*                  shows runs beside each other on one page

firn --help lists all commands, firn COMMAND --help explains one, firn help TOPIC shows the documents.
)";

}  // namespace firn
