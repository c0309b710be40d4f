// read_fields reads TOML into the fields of any table; experiments and machines share this reader.
#pragma once

#include <string>
#include <vector>

#include "config/checks.h"
#include "config/fields.h"

namespace firn {

/// Fills the fields from the text, then from the overrides; keys absent from both keep their values.
/// @param overrides KEY=VALUE of --set; words need no quotes
/// @returns file and line of each key that was set
/// @throws ConfigError naming file, line, key, value and limit; for an unknown key the nearest known one
Origins read_fields(std::vector<Field> table, const std::string& toml_text, const std::string& file_name,
                    const std::vector<std::string>& overrides = {});

}  // namespace firn
