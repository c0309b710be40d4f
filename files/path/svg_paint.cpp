#include "files/path/svg_paint.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>

#include "core/options/number.h"
#include "files/lowercase.h"
#include "files/path/svg_frames.h"
#include "files/path/svg_shapes.h"
#include "files/trimmed.h"

namespace firn::svg {
namespace {

using Paint = Painting::Paint;

/// A share, as 0.5 or 50%.
double share(std::string_view property, std::string_view text) {
  const bool percent = text.ends_with('%');
  const auto value = whole_number<double>(text.substr(0, text.size() - (percent ? 1 : 0)));
  if (!value)
    throw SyntaxError(
        fmt::format("{} = \"{}\": a number or a percentage is needed", property, text.substr(0, 40)));
  return percent ? 0.01 * *value : *value;
}

/// Says whether a colour in the notation of CSS is wholly transparent.
bool is_transparent(std::string_view color) {
  if (color == "transparent") return true;
  if (color.starts_with('#'))
    return (color.size() == 5 && color[4] == '0') || (color.size() == 9 && color.ends_with("00"));
  const std::size_t open = color.find('(');
  if (open == color.npos || !color.ends_with(')')) return false;
  std::string_view inside = color.substr(open + 1, color.size() - open - 2);
  std::size_t alpha = inside.rfind('/');
  if (alpha == inside.npos && std::count(inside.begin(), inside.end(), ',') == 3) alpha = inside.rfind(',');
  return alpha != inside.npos && share("the alpha of a colour", trimmed(inside.substr(alpha + 1))) <= 0.0;
}

Paint paint(std::string_view property, std::string_view text, const Document& document) {
  const std::string value = lowercase(text);
  if (value == "none" || is_transparent(value)) return Paint::kNone;
  if (value == "currentcolor") return Paint::kCurrentColor;
  if (!value.starts_with("url(")) return Paint::kSome;
  constexpr std::array<std::string_view, 4> kServers{"linearGradient", "radialGradient", "pattern",
                                                     "solidColor"};
  const std::size_t end = text.find(')');
  const auto found = document.by_id.find(referenced_id(text));
  if (found != document.by_id.end() &&
      std::find(kServers.begin(), kServers.end(), found->second->name) != kServers.end())
    return Paint::kSome;
  const std::string_view otherwise = end == text.npos ? "" : trimmed(text.substr(end + 1));
  if (!otherwise.empty() && !otherwise.starts_with("url(")) return paint(property, otherwise, document);
  throw SyntaxError(fmt::format("{} = {}: no gradient or pattern of the file", property, text.substr(0, 40)));
}

/// Meanings of a property beside its values: kInherited, kInitial, or kValue.
enum class Said { kInherited, kInitial, kValue };

Said said(const Value* value) {
  if (value == nullptr) return Said::kInherited;
  const std::string word = lowercase(value->text);
  if (word == "initial") return Said::kInitial;
  return word == "inherit" || word == "unset" || word.starts_with("revert") ? Said::kInherited : Said::kValue;
}

}  // namespace

std::string_view referenced_id(std::string_view text) {
  text = trimmed(text);
  if (lowercase(text.substr(0, 4)) == "url(") text = trimmed(text.substr(4, text.find(')') - 4));
  if (text.size() > 1 && (text[0] == '"' || text[0] == '\'')) text = trimmed(text.substr(1, text.size() - 2));
  return text.starts_with('#') ? text.substr(1) : std::string_view();
}

Painting painting(const Painting& outer, const Properties& properties, const Document& document) {
  Painting out = outer;
  const Painting initial;
  const auto take = [&](const char* name, auto Painting::*member, const auto& read) {
    const Value* const value = properties.find(name);
    const Said how = said(value);
    if (how == Said::kInitial) out.*member = initial.*member;
    if (how == Said::kValue) out.*member = read(std::string_view(value->text), *value);
  };
  for (const auto& [name, member] : {std::pair{"fill", &Painting::fill}, {"stroke", &Painting::stroke}})
    take(name, member,
         [&, name = name](std::string_view text, const Value&) { return paint(name, text, document); });
  take("color", &Painting::color_shows,
       [](std::string_view text, const Value&) { return !is_transparent(lowercase(text)); });
  take("visibility", &Painting::is_visible, [](std::string_view text, const Value&) {
    const std::string word = lowercase(text);
    return word != "hidden" && word != "collapse";
  });
  take("fill-opacity", &Painting::fill_opacity_shows,
       [](std::string_view text, const Value&) { return share("fill-opacity", text) > 0.0; });
  take("stroke-opacity", &Painting::stroke_opacity_shows,
       [](std::string_view text, const Value&) { return share("stroke-opacity", text) > 0.0; });
  take("stroke-width", &Painting::stroke_is_wide, [](std::string_view text, const Value&) {
    return length({std::string(text), false}).value > 0.0;  // programs write stroke-width:1 in styles, too
  });
  return out;
}

bool is_shown(const Properties& properties) {
  const Value* const display = properties.find("display");
  const Value* const opacity = properties.find("opacity");
  if (display && lowercase(display->text) == "none") return false;
  return said(opacity) != Said::kValue || opacity == nullptr || share("opacity", opacity->text) > 0.0;
}

}  // namespace firn::svg
