// member_text returns the texts of a member of a message from the .lcm files, unit_of the unit in its name.
#pragma once

#include <string>
#include <string_view>

#include "lcmtypes/member_texts.h"

namespace firn::report {

/// Returns the row of a member; without texts for a type of others.
/// @param type "layer_plan_t". @param member "decision"
MemberText member_text(std::string_view type, std::string_view member);
/// Returns the comment above the struct; "" without one.
std::string_view type_text(std::string_view type);

/// Returns "mm" of "height_mm", "Hz" of "rate_hz", "us" of "utime_us"; "1" of a name without a unit.
std::string unit_of(std::string_view name);

}  // namespace firn::report
