// LayerRecord holds a layer-wise record that others made: heights after each layer, the input commanded for
// it and the height wanted after it. read_layer_table reads one CSV table of points, read_layer_files a file
// for each layer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid/grid.h"

namespace firn {

struct LayerRecord {
  GridSpec grid;
  std::vector<HeightMap> heights;    ///< [layer], 0 = ground [mm]; kNotMeasured where nothing was seen
  std::vector<Mask> bridged;         ///< [layer], 1 where an increment was interpolated; empty: none
  std::vector<Grid<double>> inputs;  ///< [layer - 1], as recorded, speeds in mm/s; NaN = not told
  bool input_is_speed = false;     ///< of the nozzle or torch, else droplets or what --input-per-drop scales
  std::vector<HeightMap> targets;  ///< [layer] [mm], kNotMeasured where none is told; empty: none told
  int base = 0;  ///< layer whose surface heights count from: nothing is told of the layers up to it
  std::vector<std::string> assumptions;  ///< one line for each value that the record does not tell
  std::int64_t points = 0;               ///< cells with a height that the record tells
  std::int64_t bridges = 0;              ///< cells whose increment is interpolated
  std::int64_t missing = 0;              ///< cells without a height, of layers that have some
};

/// Which edges of a matrix in text are no heights, but names or numbers of columns and rows.
enum class MatrixLabels { kDetect, kNone, kRow, kColumn, kBoth };

struct LayerRecordOptions {
  std::map<std::string, std::string>
      columns;  ///< role ("layer", "x", "y", "segment", "height", "increment", "input", "speed", "target",
                ///< "error") to the column's name, where it is not found by name
  double pitch_x_mm = 0.0, pitch_y_mm = 0.0;  ///< 0 = from the positions, else 1 mm
  std::string unit;                           ///< of lengths whose column names none; "" = mm
  bool increments = false;                    ///< files hold increments, not heights
  MatrixLabels labels = MatrixLabels::kDetect;
  int layer_number =
      0;  ///< number in the files' names that is the layer: 1 = the first, -1 = the last, 0 = detect
};

/// Folders with a file a layer; empty = none.
struct LayerFolders {
  std::filesystem::path heights = {};  ///< after the layer
  std::filesystem::path inputs = {};   ///< commanded: droplets
  std::filesystem::path speeds = {};   ///< commanded: mm/s
  std::filesystem::path targets = {};  ///< heights wanted after the layer; a single number is of all cells
  std::filesystem::path errors = {};   ///< height - target, the same
};

/// Returns millimetres per unit of a length: "mm", "um", "µm", "micron", "nm", "cm", "m", "in", "mil".
/// @throws UsageError naming the known units
double millimetres(std::string_view unit, const std::string& place);

/// Reads a table with a row for each point, as files/separated_values.h reads it.
/// @param name of the file, for errors
/// @throws UsageError naming file, line and column
LayerRecord read_layer_table(std::string_view text, const std::string& name,
                             const LayerRecordOptions& options);

/// Reads the files of a folder whose names hold a number: the layer (files/layer_file_names.h). Each is a
/// matrix of heights, .npy, .csv or .txt, with rows along x; rows may have different lengths.
/// @throws UsageError naming the file, and line where it has lines
LayerRecord read_layer_files(const LayerFolders& folders, const LayerRecordOptions& options);

}  // namespace firn
