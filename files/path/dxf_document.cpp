#include "files/path/dxf_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <optional>
#include <utility>

#include "core/options/number.h"
#include "files/lowercase.h"
#include "files/trimmed.h"
#include "files/usage_error.h"

namespace firn::dxf {
namespace {

constexpr std::size_t kMaxDxfLineBytes = 4096;

struct Unit {
  int code;
  double mm;
  const char* name;
};
constexpr Unit kUnits[] = {
    {1, 25.4, "inch"},  {2, 304.8, "foot"},  {4, 1.0, "mm"},
    {5, 10.0, "cm"},    {6, 1000.0, "m"},    {8, 25.4e-6, "microinch"},
    {9, 0.0254, "mil"}, {10, 914.4, "yard"}, {12, 1e-6, "nm"},
    {13, 1e-3, "um"},   {14, 100.0, "dm"},   {21, 1200000.0 / 3937.0, "US survey foot"}};

std::string known_units() {
  std::string out = "0 (none: mm)";
  for (const Unit& unit : kUnits) out += fmt::format(", {} ({})", unit.code, unit.name);
  return out;
}

/// The place of a number's last decimal.
double last_place(std::string_view number) {
  const std::size_t e = number.find_first_of("eE"), point = number.find('.');
  double places = point == number.npos ? 0.0 : double(std::min(e, number.size()) - point) - 1.0;
  if (e != number.npos) places -= whole_number<double>(number.substr(e + 1)).value_or(0.0);
  return std::pow(10.0, -places);
}

class DocumentReader {
 public:
  DocumentReader(std::istream& in, const std::string& name) : in_(in), name_(name) {}

  Document read() {
    for (next(); !at("EOF"); next()) {
      if (!at("SECTION")) continue;
      next();
      if (code_ != 2) continue;
      const std::string section = value_;
      next();
      if (section == "HEADER") header();
      if (section == "TABLES") tables();
      if (section == "BLOCKS") blocks();
      if (section == "ENTITIES") entities("ENDSEC", document_.entities);
      while (!section_ends()) next();
      if (at("EOF")) break;
    }
    document_.imperial = imperial_ && !unit_given_;
    return std::move(document_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, line_, problem));
  }

  bool line(std::string& text) {
    if (!std::getline(in_, text)) return false;
    ++line_;
    if (text.size() > kMaxDxfLineBytes)
      fail(fmt::format("a line longer than the limit of {} bytes", kMaxDxfLineBytes));
    return true;
  }

  void next() {
    if (!line(text_)) fail("ends before EOF");
    if (line_ == 1 && text_.starts_with("AutoCAD Binary DXF")) fail("is a binary DXF: save it as ASCII");
    if (line_ == 1 && text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
    const auto code = whole_number<std::int32_t>(trimmed(text_));
    if (!code) fail(fmt::format("{} is not a group code: a whole number", shown(trimmed(text_))));
    code_ = *code;
    if (!line(text_)) fail("ends inside of a group");
    value_ = std::string(trimmed(text_));
  }

  bool at(std::string_view keyword) const { return code_ == 0 && value_ == keyword; }
  bool section_ends() const { return at("ENDSEC") || at("EOF"); }

  static std::string shown(std::string_view text) {
    std::string out = "\"" + std::string(text.substr(0, 40)) + "\"";
    std::replace_if(
        out.begin(), out.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return out;
  }

  double number() const {
    if (const auto value = whole_number<double>(value_)) return *value;
    fail(fmt::format("group {}: {} is not a finite number", code_, shown(value_)));
  }

  void header() {
    std::string variable;
    for (; !section_ends(); next()) {
      if (code_ == 9) variable = value_;
      if (code_ != 70) continue;
      if (variable == "$MEASUREMENT") imperial_ = number() == 0.0;
      if (variable != "$INSUNITS" || number() == 0.0) continue;
      const auto* const unit = std::find_if(std::begin(kUnits), std::end(kUnits),
                                            [&](const Unit& u) { return u.code == number(); });
      if (unit == std::end(kUnits)) fail(fmt::format("$INSUNITS = {}: must be {}", number(), known_units()));
      document_.unit_mm = unit->mm;
      unit_given_ = true;
    }
  }

  void tables() {
    while (!section_ends()) {
      const bool is_layer = at("LAYER");
      next();
      if (is_layer) layer();
    }
  }

  void layer() {
    std::string name;
    Layer layer;
    for (; code_ != 0; next()) {
      if (code_ == 2) name = lowercase(value_);
      if (code_ == 62 && number() < 0.0) layer.off = true;
      if (code_ == 70 && std::fmod(number(), 2.0) == 1.0) layer.frozen = true;
      if (code_ == 290 && number() == 0.0) layer.off = true;
    }
    if (name == "defpoints") layer.off = true;  // is never plotted
    document_.layers[name] = layer;
  }

  void blocks() {
    while (!section_ends()) {
      if (!at("BLOCK")) {
        next();
        continue;
      }
      constexpr int kExternal = 4 | 8;
      Block block;
      std::string name;
      for (next(); code_ != 0; next()) {
        if (code_ == 2) name = lowercase(value_);
        if (code_ == 10) block.base.x_mm = number();
        if (code_ == 20) block.base.y_mm = number();
        if (code_ == 30) block.z = number();
        if (code_ == 70) block.external = (whole_number<std::int32_t>(value_).value_or(0) & kExternal) != 0;
      }
      entities("ENDBLK", block.entities);
      document_.blocks.insert_or_assign(name, std::move(block));
    }
  }

  static bool holds_number(int code) {
    return (code >= 10 && code <= 79) || code == 90 || (code >= 210 && code <= 239);
  }

  /// From the first entity to the end of the section or block.
  void entities(std::string_view end, std::vector<Entity>& out) {
    if (code_ != 0) fail("an entity is needed");
    bool polyline = false;  // whose vertices come
    while (!section_ends() && !at(end)) {
      Entity entity = this->entity();
      if (polyline && entity.type == "VERTEX") {
        constexpr int kFrame = 16;  // of a spline through the polyline
        if (!entity.flag(70, kFrame))
          out.back().vertices.push_back(
              {{entity(10, 0.0), entity(20, 0.0)}, entity(30, 0.0), entity(42, 0.0)});
      } else if (entity.type == "SEQEND") {
        polyline = false;
      } else {
        if (polyline) break;
        polyline = entity.type == "POLYLINE";
        out.push_back(std::move(entity));
      }
    }
    if (polyline) fail("a POLYLINE without SEQEND");
  }

  Entity entity() {
    Entity e{value_, {}, {}, {}, {}, line_};
    const bool curve = e.type == "VERTEX" || std::find(kDrawn.begin(), kDrawn.end(), e.type) != kDrawn.end();
    for (next(); code_ != 0; next()) {
      const bool shows = code_ == 60 || code_ == 67;
      if (code_ == 8)
        e.layer = lowercase(value_);
      else if (code_ == 2 && e.type == "INSERT")
        e.block = lowercase(value_);
      else if (shows || (curve && holds_number(code_)))
        e.groups.push_back({code_, number(), last_place(value_)});
    }
    return e;
  }

  std::istream& in_;
  const std::string& name_;
  Document document_;
  std::string text_, value_;
  std::size_t line_ = 0;
  int code_ = 0;
  bool imperial_ = false, unit_given_ = false;
};

}  // namespace

double Entity::operator()(int code, double otherwise) const {
  for (const Group& g : groups)
    if (g.code == code) return g.value;
  return otherwise;
}

bool Entity::flag(int code, int bit) const {
  const double value = (*this)(code, 0.0);
  return value >= 0.0 && value < 65536.0 && (int(value) & bit) != 0;
}

double Entity::place(int code) const {
  for (const Group& g : groups)
    if (g.code == code) return g.place;
  return 0.0;
}

Document read_document(std::istream& in, const std::string& name) { return DocumentReader(in, name).read(); }

}  // namespace firn::dxf
