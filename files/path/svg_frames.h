// svg::transform and the functions beside it read the lengths, transforms and viewports that place the shapes
// of an SVG file [CSS Transforms Level 1; SVG 2, 8].
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "files/path/plane_transform.h"
#include "files/path/svg_style.h"

namespace firn::svg {

inline constexpr double kPixel_mm = 25.4 / 96.0;

/// Base of percentages, in user units; absent where the file gives the page no size.
struct Viewport {
  std::optional<double> width, height;
  std::optional<double> diagonal() const;  ///< for lengths that are neither across nor down
};

struct Length {
  enum class Unit { kNone, kMillimetre, kPercent, kRelative };  ///< kRelative: em, vw and their like
  double value = 0.0;
  Unit unit = Unit::kNone;

  /// @param whole base of a percentage @throws SyntaxError for a percentage without it and a relative unit
  double user(std::optional<double> whole) const;
};

/// @throws SyntaxError for a text that is no length, with the text; of CSS also for one without a unit
Length length(const Value& value);

/// As many numbers as `out` has, with blanks or commas between them. @throws SyntaxError
void numbers(std::string_view text, std::span<double> out);

/// The transform of an element about its origin. @throws SyntaxError for functions of space and for a
/// transform-box
PlaneTransform transform(const Properties& properties, const Viewport& viewport);

/// From the user's units of a viewBox to a rectangle at 0, 0 of this size, y downwards in both.
/// @param how preserveAspectRatio @throws SyntaxError
PlaneTransform fit(std::span<const double, 4> view_box, double width, double height, std::string_view how);

}  // namespace firn::svg
