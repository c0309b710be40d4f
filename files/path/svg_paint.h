// svg::Painting says whether the shapes of an element are painted at all [SVG 2, 13].
#pragma once

#include <string_view>

#include "files/path/svg_document.h"
#include "files/path/svg_style.h"

namespace firn::svg {

/// The inherited properties that decide it.
struct Painting {
  enum class Paint { kNone, kSome, kCurrentColor };
  Paint fill = Paint::kSome, stroke = Paint::kNone;
  bool color_shows = true;                                      ///< currentColor is not transparent
  bool fill_opacity_shows = true, stroke_opacity_shows = true;  ///< above 0
  bool stroke_is_wide = true;                                   ///< stroke-width is above 0
  bool is_visible = true;

  bool fills() const { return fill_opacity_shows && shows(fill); }
  bool strokes() const { return stroke_opacity_shows && stroke_is_wide && shows(stroke); }
  bool paints() const { return is_visible && (fills() || strokes()); }

 private:
  bool shows(Paint paint) const {
    return paint == Paint::kSome || (paint == Paint::kCurrentColor && color_shows);
  }
};

/// Returns the painting of an element within one that is painted as `outer`.
/// @throws SyntaxError naming property and value
Painting painting(const Painting& outer, const Properties& properties, const Document& document);

/// False where display or opacity hides an element with all that it holds.
bool is_shown(const Properties& properties);

/// The id in a reference such as url(#a) or, of href, #a; empty for another one.
std::string_view referenced_id(std::string_view reference);

}  // namespace firn::svg
