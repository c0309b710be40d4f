// run_import makes a run of a layer-wise record that others made.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace firn {

struct ImportOptions {
  std::string record;                ///< a CSV table, or a folder with a file for each layer
  std::string input;                 ///< folder of the commanded inputs; empty = in the table, or none
  std::string speed;                 ///< folder of commanded speeds, mm/s
  std::string target, error;         ///< folder of wanted heights, or of height - wanted
  bool increments = false;           ///< the folder's files hold increments
  std::vector<std::string> columns;  ///< "height=NAME"
  std::string unit;
  std::string labels = "detect";  ///< first row and column of matrix files
  int layer_number = 0;           ///< number of the files' names that is the layer; 0 = detect
  std::optional<double> pitch_mm, pitch_y_mm, target_mm, input_per_drop;
  std::string experiment;  ///< model and settings; empty = the defaults
  std::vector<std::string> overrides;
  std::string name = "imported";
  std::string runs = "runs";
  bool json = false;
};

/// @returns kOk. @throws UsageError naming file, line and column, or layer and cell; ConfigError
int run_import(const ImportOptions& options);

}  // namespace firn
