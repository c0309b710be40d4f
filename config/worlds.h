// WorldList holds a declaration of worlds, read from TOML: the simulated labs in which schemes are compared,
// the priors from which each seed draws one, and the goals, all written down before a scheme is tuned.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/study_ranges.h"

namespace firn {

/// The labs of a world: schemes are tuned in the first kind, and judged in the second.
enum class LabSet : std::uint8_t { kTuning, kHeldOut };
inline constexpr std::array<std::string_view, 2> kLabSetWords{"tuning", "held_out"};

struct DeclaredWorld {
  std::string name;
  std::string source;                           ///< of its physics and its numbers
  std::vector<std::string> overrides;           ///< "plant.model=wu_chiu", as of --set
  bool unseen = false;                          ///< it has no labs to tune in
  std::array<std::vector<KeyRange>, 2> priors;  ///< by LabSet, those of all worlds among them
  int line = 0;
};

struct DeclaredGoal {
  std::string name, metric, says;
};

struct WorldList {
  std::string file, name;
  std::string experiment;              ///< relative to the file
  std::vector<std::string> overrides;  ///< for every print
  std::vector<std::string> metrics;    ///< the first is the primary one
  std::vector<DeclaredGoal> goals;
  std::array<std::vector<std::uint64_t>, 2> seeds;  ///< by LabSet; no seed is of both
  std::vector<DeclaredWorld> worlds;
};

/// Keys: name, experiment, set, metrics; [seeds] with tuning = [FIRST, LAST] and held_out; [tuning] and
/// [held_out], priors of every world; [[goal]] with name, metric, says; [[world]] with name, source, set,
/// unseen and its own [world.tuning] and [world.held_out], which replace ranges of the same keys.
/// @throws ConfigError naming file, line, key and limit: a world without labs of a kind, an unseen one with
/// labs to tune in, a key whose ranges of both kinds are the same, a seed of both kinds
WorldList parse_worlds(std::string_view toml_text, const std::string& file_name);
/// @throws ConfigError, also if the file cannot be read
WorldList load_worlds(const std::filesystem::path& path);

}  // namespace firn
