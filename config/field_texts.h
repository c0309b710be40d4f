// Whole tables of keys as text. Fields of a section stand together.
#pragma once

#include <string>
#include <vector>

#include "config/fields.h"

namespace firn {

/// Every key with its value, as TOML.
std::string fields_toml(const std::vector<Field>& fields);

/// Markdown tables of the sections: keys, default, allowed values, meaning. Adjacent sections that differ in
/// their defaults alone share a table, keys that say the same of another axis a row.
std::string fields_markdown(const std::vector<Field>& fields);

}  // namespace firn
