// fields_toml() and fields_markdown() write whole tables of fields as text. Fields of one section must be
// adjacent.
#pragma once

#include <string>
#include <vector>

#include "config/fields.h"

namespace firn {

/// Returns every key with its value, as TOML.
std::string fields_toml(const std::vector<Field>& fields);

/// Returns Markdown tables of the sections: keys, default, allowed values, meaning. Adjacent sections that
/// differ in their defaults alone share a table, keys of several axes with the same meaning share a row.
std::string fields_markdown(const std::vector<Field>& fields);

}  // namespace firn
