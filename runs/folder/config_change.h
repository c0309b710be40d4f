// Computes the configuration with which a recorded run is replayed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace firn::runs {

/// Holds the changes of the nodes' recorded configuration by the run's experiment.toml and the overrides of
/// --set.
struct ConfigChange {
  /// For ReplayOptions::change_config; empty if nothing changes.
  std::function<std::string(const std::string& recorded_toml)> change;
  std::vector<std::string> settings;  ///< "control.smf.kp: recorded 1, now 1.5"
  std::vector<std::string> unread;    ///< "control.smf.kp is of scheme smf, and this print has scheme mpc"
};

/// Computes the changes.
/// @param recorded_toml the configuration in the write-ahead files
/// @throws ConfigError
ConfigChange config_change(const std::filesystem::path& run, const std::string& recorded_toml,
                           const std::vector<std::string>& overrides);

/// Returns the configuration in the first readable head of nodes/*.wal; empty if no head is readable.
std::string recorded_config(const std::filesystem::path& run);

}  // namespace firn::runs
