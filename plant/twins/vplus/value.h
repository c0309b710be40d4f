// Value holds a value of V+: a real of 32 bits, a string of at most 128 characters, or a precision point.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

namespace firn::plant::vplus {

inline constexpr std::size_t kMaxString = 128;  ///< characters of a V+ string [V+ Language User's Guide]

/// Joint values as V+ shows them: deg, deg, mm, deg; joint 3 counts down from the highest end of its stroke.
using PrecisionPoint = std::array<float, 4>;

enum class Type : std::uint8_t { kReal, kString, kPoint };

struct Value {
  Type type = Type::kReal;
  bool defined = false;
  float real = 0.0F;
  PrecisionPoint point{};
  std::string text;

  static Value of(float real) { return {Type::kReal, true, real, {}, {}}; }
  static Value of(bool truth) { return of(truth ? -1.0F : 0.0F); }
  static Value of(std::string text) { return {Type::kString, true, 0.0F, {}, std::move(text)}; }
  static Value of(const PrecisionPoint& point) { return {Type::kPoint, true, 0.0F, point, {}}; }
};

/// Index of an array's element, 0 to 32767 in each of at most three dimensions; kScalar: no array.
using Element = std::uint64_t;
inline constexpr Element kScalar = ~Element(0);

/// Variable holds a scalar and the elements of an array of the same name. V+ needs no declaration of a global
/// array: elements exist once they are assigned.
struct Variable {
  Value scalar;
  std::map<Element, float> reals;
  std::map<Element, std::string> texts;
};

}  // namespace firn::plant::vplus
