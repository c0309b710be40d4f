// PrintPreview holds the facts about a print that are known before its first droplet: the part, its cost, its
// misfits.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/experiment.h"
#include "core/grid/grid.h"
#include "print/preview/foretell.h"
#include "runtime/node.h"

namespace firn {

struct PrintPreview {
  std::string part;                 ///< "cylinder", "mesh gear.stl"
  std::array<double, 3> size_mm{};  ///< of the part, with its scaffold or support
  GridSpec grid;                    ///< of droplets, or of the last interval's map
  std::int64_t cells = 0;           ///< of the part on it
  int layers = 0;                   ///< nominal
  std::int64_t amount = 0;          ///< droplets, or pulses, of the nominal layers
  std::string amount_name;
  double volume_mm3 = 0.0;
  double time_s = 0.0;         ///< node time, without heating and decisions
  std::string simulated = {};  ///< scheme by whose simulation layers, amount and time are; empty: nominal
  std::vector<std::pair<std::string, double>> materials;  ///< volume of each [mm^3]
  std::vector<std::string> outside;                       ///< of reach or grid: the print would be refused
  std::vector<std::string> remarks;                       ///< it would be printed, and may not be meant
  HeightMap picture;                                      ///< of the finished part; NaN beside it
};

/// Computes the preview of an experiment from its inputs (make_inputs). Prints nothing.
/// @param folder of the experiment file
/// @throws UsageError, ConfigError: files that cannot be read
PrintPreview preview_print(const Experiment& experiment, const Blobs& inputs,
                           const std::filesystem::path& folder);

/// Puts what the scheme takes in a simulation in the place of nominal layers, amount and time.
void take_foretold(const Foretold& foretold, const Experiment& experiment, PrintPreview& preview);

/// Two lines, then one for each remark and each thing outside.
std::string preview_text(const PrintPreview& preview);
std::string preview_json(const PrintPreview& preview);
/// A heat map of the finished part, as a file of its own.
std::string preview_svg(const PrintPreview& preview);

}  // namespace firn
