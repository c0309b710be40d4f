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

namespace firn {

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
  std::optional<double> target_mm;  ///< height of the part; none: the mean of the last map
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
/// @throws UsageError "RUN is imported, not replayable: COMMAND needs the events of a print"
void refuse_imported(const std::filesystem::path& run, const std::string& command);

}  // namespace firn
