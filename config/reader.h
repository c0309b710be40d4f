// TOML -> the fields of any table: what experiments and machines share.
#pragma once

#include <string>
#include <vector>

#include "config/checks.h"
#include "config/fields.h"

namespace firn {

/// Fills the fields from the text, then from the overrides; keys that they do not name keep their values.
/// @param overrides KEY=VALUE of --set; words need no quotes
/// @returns where each key was set
/// @throws ConfigError naming file, line, key, value and limit; for an unknown key the nearest known one
Origins read_fields(std::vector<Field> table, const std::string& toml_text, const std::string& file_name,
                    const std::vector<std::string>& overrides = {});

}  // namespace firn
