// load_experiment reads an experiment with its includes: `include = "../labs/x.toml"` at the head of a file
// sets the lab's fields first, then the experiment's own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/experiment.h"
#include "config/meta.h"

namespace firn {

/// Returns the path that the text includes, as written; "" if the text has no include. @throws ConfigError
std::string include_of(const std::string& toml_text, const std::string& file_name);

/// Returns the file and all its includes, from base to leaf, as {name, text}; names are the paths as reached
/// from `path`.
/// @throws ConfigError: unreadable file, an include that comes back to a file already open, more than 8
/// levels.
std::vector<std::pair<std::string, std::string>> read_with_includes(const std::filesystem::path& path);

/// Returns the bytes of a file. @throws ConfigError naming it: not a file, cannot be read.
std::string read_config_text(const std::filesystem::path& path, const std::string& included_by = "");

/// kAlone: one instrument at a time, so that a real one may stand beside simulated ones that a trigger line
/// couples to it in a print.
enum class LabUse : std::uint8_t { kWhole, kAlone };

/// As parse_experiment of experiment.h.
Experiment parse_experiment(const std::vector<std::pair<std::string, std::string>>& named_texts,
                            const std::vector<std::string>& overrides, LabUse use);

/// parse_experiment of the file at `path` with its includes and the overrides of --set.
Experiment load_experiment(const std::filesystem::path& path, const std::vector<std::string>& overrides = {},
                           LabUse use = LabUse::kWhole);

/// parse_meta of the file at `path` with its includes and the overrides of --set and --meta.
PrintMeta load_meta(const std::filesystem::path& path, const std::vector<std::string>& overrides = {});

}  // namespace firn
