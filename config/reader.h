// TOML -> the fields of any table: what experiments and machines share.
#pragma once

#include <string>
#include <vector>

#include "config/checks.h"
#include "config/fields.h"

namespace firn {

/// Fills the fields from the text; keys that it does not name keep their values.
/// @returns where each key was set
/// @throws ConfigError naming file, line, key, value and limit; for an unknown key the nearest known one
Origins read_fields(std::vector<Field> table, const std::string& toml_text, const std::string& file_name);

}  // namespace firn
