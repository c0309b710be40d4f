// parse_types and resolve compute the types of .lcm texts. For the schema_*.cpp files.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "lcmtypes/schema.h"

namespace firn::schema {

/// Appends the structs of one text, with members and struct_hash.
/// @param file named in errors and as the origin of types; empty: the types of the house
/// @throws std::invalid_argument with line and cause
void parse_types(std::string_view text, std::string_view file, std::deque<Type>& types);

using Names = std::map<std::string, const Type*, std::less<>>;

/// Computes fields, smallest_bytes and fingerprint.
/// @throws std::invalid_argument: unknown type, a type that holds itself without a counted array between
void resolve(const Names& names, Type& type);

}  // namespace firn::schema
