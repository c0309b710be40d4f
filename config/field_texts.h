// Whole tables of keys as text. Fields of a section stand together.
#pragma once

#include <string>
#include <vector>

#include "config/fields.h"

namespace firn {

/// Every key with its value, as TOML.
std::string fields_toml(const std::vector<Field>& fields);

/// A Markdown table for each section: key, value as its default, unit, what is allowed, meaning.
std::string fields_markdown(const std::vector<Field>& fields);

}  // namespace firn
