// The configuration with which a recorded run is replayed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace firn {

/// How the run's experiment.toml and the overrides of --set change what the nodes were started with.
struct ConfigChange {
  /// Hand to ReplayOptions::change_config; empty if nothing changes.
  std::function<std::string(const std::string& recorded_toml)> change;
  std::vector<std::string> settings;  ///< "control.smf.kp: recorded 1, now 1.5"
};

/// @param recorded_toml the configuration that stands in the write-ahead files
/// @throws ConfigError
ConfigChange config_change(const std::filesystem::path& run, const std::string& recorded_toml,
                           const std::vector<std::string>& overrides);

/// The configuration in the first readable head of nodes/*.wal; empty if there is none.
std::string recorded_config(const std::filesystem::path& run);

}  // namespace firn
