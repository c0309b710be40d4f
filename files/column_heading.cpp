#include "files/column_heading.h"

#include <algorithm>

#include "files/lowercase.h"
#include "files/trimmed.h"

namespace firn {
namespace {

struct LengthUnit {
  std::string_view name;
  double mm;
};
constexpr LengthUnit kUnits[] = {
    {"mm", 1},         {"um", 1e-3},    {"\xc2\xb5m", 1e-3}, {"\xce\xbcm", 1e-3}, {"micron", 1e-3},
    {"microns", 1e-3}, {"nm", 1e-6},    {"cm", 10},          {"m", 1000},         {"in", 25.4},
    {"inch", 25.4},    {"mil", 0.0254}, {"thou", 0.0254}};

bool is_unit(std::string_view unit) {
  return unit == "deg" || unit == "rad" || length_unit_mm(unit) || speed_unit_mm_s(unit);
}

std::string plain_unit(std::string_view unit) {
  std::string plain(trimmed(unit));
  std::ranges::replace(plain, '/', '_');
  return plain;
}

}  // namespace

ColumnHeading heading_of(std::string_view name) {
  ColumnHeading h;
  h.word = lowercase(trimmed(name));
  if (const std::size_t open = h.word.find_first_of("[("); open != h.word.npos) {
    h.unit = plain_unit(h.word.substr(open + 1, h.word.find_first_of("])", open) - open - 1));
    h.word.resize(open);
    h.bracketed = true;
  } else {
    for (std::size_t at = h.word.find_first_of("_ /"); at != h.word.npos;
         at = h.word.find_first_of("_ /", at + 1)) {
      const std::string last = plain_unit(std::string_view(h.word).substr(at + 1));
      if (!is_unit(last)) continue;
      h.unit = last;
      h.word.resize(at);
      break;
    }
  }
  while (!h.word.empty() && (h.word.back() == ' ' || h.word.back() == '_')) h.word.pop_back();
  return h;
}

std::optional<double> length_unit_mm(std::string_view unit) {
  const auto found = std::ranges::find(kUnits, unit, &LengthUnit::name);
  if (found == std::end(kUnits)) return std::nullopt;
  return found->mm;
}

std::optional<double> speed_unit_mm_s(std::string_view unit) {
  const std::size_t per = unit.rfind('_');
  if (per == unit.npos) return std::nullopt;
  const auto length = length_unit_mm(unit.substr(0, per));
  const std::string_view time = unit.substr(per + 1);
  if (!length || (time != "s" && time != "min")) return std::nullopt;
  return time == "s" ? *length : *length / 60.0;
}

}  // namespace firn
