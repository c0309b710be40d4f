// LayerRecord holds a layer-wise record that others made: heights after each layer and the input commanded
// for it. read_layer_table reads one CSV table of points, read_layer_files a file for each layer.
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
  std::vector<HeightMap> heights;        ///< [layer], 0 = ground [mm]; kNotMeasured where nothing was seen
  std::vector<Grid<double>> inputs;      ///< [layer - 1], as recorded; NaN = not told
  std::vector<std::string> assumptions;  ///< one line for each value that the record does not tell
  std::int64_t points = 0;               ///< cells with a height that the record tells
  std::int64_t missing = 0;              ///< cells without one, of layers that have some
};

/// Which edges of a matrix in text are no heights, but names or numbers of columns and rows.
enum class MatrixLabels { kDetect, kNone, kRow, kColumn, kBoth };

struct LayerRecordOptions {
  std::map<std::string, std::string>
      columns;  ///< role ("layer", "x", "y", "segment", "height", "increment",
                ///< "input") to the column's name, where it is not found by name
  double pitch_x_mm = 0.0, pitch_y_mm = 0.0;  ///< 0 = from the positions, else 1 mm
  std::string unit;                           ///< of lengths whose column names none; "" = mm
  MatrixLabels labels = MatrixLabels::kDetect;
  int layer_number =
      0;  ///< number in the files' names that is the layer: 1 = the first, -1 = the last, 0 = detect
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
/// @param inputs folder of the same for the commanded input; empty = none
/// @throws UsageError naming the file, and line where it has lines
LayerRecord read_layer_files(const std::filesystem::path& heights, const std::filesystem::path& inputs,
                             const LayerRecordOptions& options);

}  // namespace firn
