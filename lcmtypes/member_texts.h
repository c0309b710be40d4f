// MemberText and TypeText hold what the comments of the .lcm files say to people: generated.
#pragma once

#include <span>
#include <string_view>

namespace firn {

struct MemberText {
  std::string_view type, member;
  std::string_view text;    ///< the comment without its clauses for validate()
  std::string_view range;   ///< "[0, 100]", "" without one
  std::string_view values;  ///< "kPrint = 0, kEnd = 1" of an enum that the member defines or names
};
std::span<const MemberText> member_texts();

struct TypeText {
  std::string_view type, text;  ///< the comment above the struct
};
std::span<const TypeText> type_texts();

}  // namespace firn
