// member_text returns what the comments of the .lcm files say about a member of a message, unit_of the unit
// in a member's name.
#pragma once

#include <string>
#include <string_view>

namespace firn::tables {

struct MemberText {
  std::string text;    ///< the comment without its clauses for validate(), or "" without a comment
  std::string range;   ///< "[0, 100]", "" without one
  std::string values;  ///< "kPrint = 0, kEnd = 1" of an enum that the member defines or names
};
/// @param type "layer_plan_t". @param member "decision"
MemberText member_text(std::string_view type, std::string_view member);
/// Returns the comment above the struct; "" without one.
std::string type_text(std::string_view type);

/// Returns "mm" of "height_mm", "Hz" of "rate_hz", "us" of "utime_us"; "1" of a name without a unit.
std::string unit_of(std::string_view name);

}  // namespace firn::tables
