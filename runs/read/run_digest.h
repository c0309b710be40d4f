// RunDigest holds the numbers of one run that lists and sums over runs need.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace firn::runs {

struct RunDigest {
  struct Error {
    double rms_um = 0.0, mean_um = 0.0;
    int layers = 0;
  };
  std::optional<Error> last;  ///< of the last layer
  std::string lamp;           ///< its port, "simulated" or an address; empty: the lab has none
  double lamp_open_s = 0.0;   ///< commanded
};

/// Holds how long a lamp was open in the earlier runs whose lamp had the same port.
struct LampSum {
  std::string lamp;  ///< as of RunDigest
  double open_s = 0.0;
  int runs = 0;
};

/// Reads it from the run's log, or from its scheduler's write-ahead file where the log is not whole. An
/// unreadable run has an empty digest: firn log verify names the damage.
RunDigest digest_run(const std::filesystem::path& run);

/// Returns the port of the run's lamp, as in RunDigest.
std::string lamp_of(const std::filesystem::path& run);

}  // namespace firn::runs
