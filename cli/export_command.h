// run_export writes recorded runs in formats that other programs read.
#pragma once

#include <string>
#include <vector>

namespace firn {

struct ExportOptions {
  std::vector<std::string> runs;
  std::string output;  ///< its ending names the format: .h5, .hdf5, .npz, .mcap, .csv (a folder)
  bool json = false;
};

/// @returns kOk. @throws UsageError: no run, an ending without a format, two runs of one name;
/// std::invalid_argument: damage, with file and byte; WriteError
int run_export(const ExportOptions& options);

}  // namespace firn
