// message_from_json() encodes a message that a person or a script wrote as a JSON object.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "lcmtypes/schema.h"

namespace firn {

/// Encodes `json`, an object with the members of `type` by name. The header may be missing, and so may a
/// member that counts an array; both are filled in (the header with zeros). NaN is null.
/// @param optional texts that may be missing too, and are empty then
/// @throws std::invalid_argument naming the member and the cause: no JSON, a member that is missing, unknown,
/// of another kind or out of its integer's range, arrays of one count with unlike lengths. Ranges of values
/// are not checked here (validate.h)
std::vector<std::byte> message_from_json(const schema::Type& type, std::string_view json,
                                         std::initializer_list<std::string_view> optional = {});

}  // namespace firn
