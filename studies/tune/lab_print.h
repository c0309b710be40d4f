// print_in_lab runs a recorded experiment, perhaps with other settings, in a laboratory drawn from a class:
// the nodes of firn print against the simulated world.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/random.h"
#include "print/folder/observed_run.h"
#include "print/simulated/memory_print.h"
#include "runtime/node.h"
#include "studies/tune/lab_class.h"

namespace firn::tune {

/// Source of the maps' noise. The maps of an imported record hold no report of it.
enum class MapNoise : std::uint8_t { kReported, kFromMaps };

/// A run that the laboratory is learned from.
struct RecordedRun {
  std::string name;
  Experiment experiment;  ///< as recorded
  Blobs inputs;
  std::vector<double> features;
  int layers = 0;
  MapNoise noise = MapNoise::kReported;  ///< kFromMaps: the run is imported

  /// An imported run counts as printed by the scheme of its experiment; the check refuses it where it was
  /// not.
  /// @throws UsageError naming the run: of lines, two inks, unfinished, too few layers or intervals
  static RecordedRun read(const std::filesystem::path& run);
  /// The same of a print in memory. @throws std::invalid_argument: too few layers
  static RecordedRun of(std::string name, const Experiment& experiment, const Blobs& inputs,
                        const ObservedRun& run, MapNoise noise = MapNoise::kReported);
};

/// Returns a draw as the seed of a print: below the largest that a configuration holds.
inline std::uint64_t print_seed(const DrawKey& key) { return random_bits(key) >> 2; }

/// A laboratory, and the seed of everything random in it.
struct LabDraw {
  const LabClass* lab = nullptr;
  std::vector<double> z;
  std::uint64_t seed = 1;
};

/// Signs of a controller at its limits, of one print.
struct PrintTraits {
  double saturated = 0.0;  ///< share of the part's cells and layers at SMF's most droplets, or largest action
  double alternation = 0.0;  ///< lag-1 correlation of the layers' droplets or actions, before the last fifth
  double swing = 0.0;        ///< their relative standard deviation
  double overspill = 0.0;    ///< volume beside the part over that inside it
};

struct LabPrint {
  bool finished = false;
  std::string reason;            ///< where not finished
  std::vector<double> metrics;   ///< of the true surface, in the order of study_lab_of()
  std::vector<double> features;  ///< empty unless asked for, or where the print has too few layers
  PrintTraits traits;
};

class PrintJournal;

struct LabPrintOptions {
  bool features = false;
  MapNoise noise = MapNoise::kReported;  ///< of the features
  PrintJournal* journal = nullptr;       ///< prints on its record are not made again
};

/// Thread-safe. A print that fails is a result. @param experiment without_plant()
LabPrint print_in_lab(const Experiment& experiment, const Blobs& inputs, const LabDraw& draw,
                      const LabPrintOptions& options);

}  // namespace firn::tune
