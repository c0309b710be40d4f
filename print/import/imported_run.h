// write_imported_run makes a run folder of a layer-wise record that others made. Such a run can be
// identified, tuned from, reported and exported; it has no events that a node could be replayed with.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "core/grid/grid.h"
#include "files/layer_record.h"
#include "runtime/node.h"

namespace firn {

/// Roles of the blob with a record's inputs as recorded: a NumPy array for each layer, one behind the other.
inline constexpr const char* kRecordedSpeeds = "recorded speeds";  ///< of beads, mm/s
inline constexpr const char* kRecordedInputs =
    "recorded inputs";  ///< droplets, or what was scaled to droplets

/// Begins the assumption of a run without a target.
inline constexpr const char* kNoTarget = "no target is told";

struct RecordedInputs {
  bool speeds = false;
  std::vector<Grid<double>> layers;  ///< [layer - 1]; NaN = not told
};
/// None where the run holds none, as a print does. @throws std::invalid_argument: bytes that are no such
/// arrays
std::optional<RecordedInputs> recorded_inputs(const Blobs& inputs, const GridSpec& grid);

struct ImportedRun {
  std::filesystem::path folder;
  int layers = 0;
  std::int64_t droplets = 0;
  std::vector<std::string> assumptions;  ///< the record's and those of the conversion
};

struct ImportSource {
  std::string name;                 ///< of the file or folder
  std::string sha256;               ///< of all its bytes
  double input_per_drop = 0.0;      ///< input of one droplet; 0: inputs are droplets
  std::optional<double> target_mm;  ///< height of the part; none: the record's, or the mean of the last map
};

/// @param experiment its grid is the record's
/// @param root where run folders go
/// @throws UsageError naming layer and cell: an input that is no number of droplets from 0 to 127, a record
/// without a height
ImportedRun write_imported_run(LayerRecord record, const Experiment& experiment, const ImportSource& source,
                               const std::filesystem::path& root);

/// Returns the noise of one cell from second differences along x: their median is sqrt(6) times the noise
/// over 1.4826 where the surface is smooth, and more where it is not. 0: fewer than eight differences.
double noise_of_bends_mm(const HeightMap& map);

/// Returns true if the run was imported.
bool is_imported(const std::filesystem::path& run);
/// Returns true if the run was imported with speeds of beads, not with droplets. @throws UsageError: no run
bool records_speeds(const std::filesystem::path& run);
/// @throws UsageError: such a run, which holds no droplets that `command` could work on
void refuse_beads(const std::filesystem::path& run, const std::string& command);
/// @throws UsageError "RUN is imported, not replayable: COMMAND needs the events of a print"
void refuse_imported(const std::filesystem::path& run, const std::string& command);

}  // namespace firn
