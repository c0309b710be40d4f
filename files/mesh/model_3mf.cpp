#include "files/mesh/model_3mf.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/options/number.h"
#include "files/lowercase.h"
#include "files/mesh/xml_reader.h"
#include "files/trimmed.h"
#include "files/usage_error.h"

namespace firn::mesh {
namespace {

constexpr std::string_view kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
constexpr std::string_view kProduction = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
constexpr std::string_view kSlice = "http://schemas.microsoft.com/3dmanufacturing/slice/2015/07";
constexpr std::string_view kBeams = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/";
constexpr std::string_view kTriangleSets =
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07";
// Extensions whose effect on the solid Firn knows: nothing (colours, paths, sets), or it is seen at
// the object that uses them (slices, beams).
constexpr std::string_view kKnown[] = {"http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
                                       kProduction, kSlice, kBeams, kTriangleSets};
constexpr std::size_t kShown = 60;
constexpr const char* kBlanks = " \t\r\n";

constexpr std::pair<std::string_view, double> kUnits[] = {{"micron", 0.001},    {"millimeter", 1.0},
                                                          {"centimeter", 10.0}, {"inch", 25.4},
                                                          {"foot", 304.8},      {"meter", 1000.0}};

struct RowShape {
  std::string_view begin;
  std::array<std::string_view, 3> keys;
};
constexpr RowShape kVertexRow{"<vertex", {"x", "y", "z"}}, kTriangleRow{"<triangle", {"v1", "v2", "v3"}};

/// Reads rows of one shape from a text.
class RowText {
 public:
  explicit RowText(std::string_view text) : text_(text) {}
  /// @returns the place behind the blanks
  std::size_t skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    return at_;
  }
  /// Takes an element that has the keys of the shape, in their order, and nothing else.
  bool take(const RowShape& shape, std::array<std::string_view, 3>& words) {
    if (!literal(shape.begin)) return false;
    for (std::size_t n = 0; n < 3; ++n)
      if (!blank() || !literal(shape.keys[n]) || !word(words[n])) return false;
    skip_blanks();
    return literal("/>");
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  bool blank() {
    const std::size_t from = at_;
    return skip_blanks() > from;
  }
  bool literal(std::string_view wanted) {
    if (!text_.substr(at_).starts_with(wanted)) return false;
    at_ += wanted.size();
    return true;
  }
  bool word(std::string_view& to) {
    if (text_.size() - at_ < 2 || text_[at_] != '=') return false;
    const char quote = text_[at_ + 1];
    if (quote != '"' && quote != '\'') return false;
    const std::size_t from = at_ += 2;
    while (at_ < text_.size() && text_[at_] != quote) ++at_;
    to = text_.substr(from, at_ - from);
    return at_ < text_.size() && text_[at_++] == quote;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

class ModelHandler final : public XmlHandler {
 public:
  ModelHandler(const std::string& source, std::size_t max_bytes)
      : reader_(source, *this), max_bytes_(max_bytes) {}

  XmlReader& reader() { return reader_; }
  Model3mf take() { return std::move(model_); }

  bool expects_rows() const override { return object_ && depth_ == rows_depth_; }

  // <vertex x="1.5" y="0" z="2"/>, <triangle v1="0" v2="1" v3="2"/>: a real mesh has little else.
  std::size_t read_rows(std::string_view text) override {
    const RowShape& shape = rows_are_triangles_ ? kTriangleRow : kVertexRow;
    RowText row(text);
    std::size_t read = row.skip_blanks();
    std::array<std::string_view, 3> words;
    while (row.take(shape, words) && add_row(words)) read = row.skip_blanks();
    return read;
  }

  void begin(const XmlName& element, const XmlAttributes& a) override {
    ++depth_;
    const bool core = is_core(element);
    if (core && (element.local == "vertices" || element.local == "triangles")) {
      rows_are_triangles_ = element.local == "triangles";
      rows_depth_ = depth_;
    }
    if (core && element.local == "vertex")
      vertex(a);
    else if (core && element.local == "triangle")
      triangle(a);
    else if (core && element.local == "model")
      model(a);
    else if (core && element.local == "object")
      object(a);
    else if (core && element.local == "component" && object_)
      object_->components.push_back(placed(a));
    else if (core && element.local == "item")
      model_.items.push_back(placed(a));
    else if (core && element.local == "mesh" && object_)
      object_->has_mesh = true;
    else if (core && element.local == "metadata")
      metadata(a);
    else if (!core && object_)
      foreign(element, a);
  }

  void text(std::string_view piece) override {
    if (!key_.empty() && value_.size() < kShown) value_ += piece;
  }

  void end(const XmlName& element) override {
    if (depth_-- == rows_depth_) rows_depth_ = kNoRows;
    if (!is_core(element)) return;
    if (element.local == "metadata" && !key_.empty()) end_metadata();
    if (element.local == "object") end_object();
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { reader_.fail(problem); }
  static bool is_core(const XmlName& element) { return element.space == kCore || element.space.empty(); }
  static std::string shown(std::string_view text) { return std::string(text.substr(0, kShown)); }

  std::string_view needed(const XmlAttributes& a, std::string_view key) const {
    const std::optional<std::string_view> value = a.find(key);
    if (!value) fail(fmt::format("the attribute {} is missing", key));
    return *value;
  }

  double number(std::string_view text, std::string_view key) const {
    const std::optional<double> value = whole_number<double>(trimmed(text));
    if (!value)
      fail(fmt::format("{}=\"{}\": is not a number{}", key, shown(text),
                       text.find(',') == text.npos ? "" : "; its decimal mark must be a point"));
    return *value;
  }

  std::uint32_t index(std::string_view text, std::string_view key) const {
    const std::optional<std::uint32_t> value = whole_number<std::uint32_t>(trimmed(text));
    if (!value) fail(fmt::format("{}=\"{}\": is not the number of a vertex", key, shown(text)));
    return *value;
  }

  void take_bytes(std::size_t bytes) {
    bytes_ += bytes;
    if (bytes_ > max_bytes_)
      fail(fmt::format("its meshes take more than {} bytes of memory, the limit for this file", max_bytes_));
  }

  void model(const XmlAttributes& a) {
    if (const auto unit = a.find("unit")) {
      const auto* const known = std::ranges::find(kUnits, *unit, &std::pair<std::string_view, double>::first);
      if (known == std::end(kUnits)) fail(fmt::format("unit=\"{}\": an unknown unit", shown(*unit)));
      model_.mm_per_unit = known->second;
    }
    const std::string required(a.find("requiredextensions").value_or(""));
    for (std::size_t at = 0; (at = required.find_first_not_of(kBlanks, at)) != required.npos;) {
      const std::size_t end = std::min(required.find_first_of(kBlanks, at), required.size());
      const std::string prefix = required.substr(at, end - at), space = reader_.space_of(prefix);
      at = end;
      const bool known = std::ranges::any_of(
          kKnown, [&](std::string_view k) { return k == kBeams ? space.starts_with(k) : space == k; });
      if (!known)
        fail(
            fmt::format("requires the extension {} ({}), which Firn does not read: export the part as "
                        "triangles alone",
                        shown(prefix), space.empty() ? "its namespace is not declared" : shown(space)));
    }
  }

  void object(const XmlAttributes& a) {
    id_ = std::string(needed(a, "id"));
    const auto [at, is_new] = model_.objects.try_emplace(id_);
    if (!is_new) fail(fmt::format("a second object {}", shown(id_)));
    object_ = &at->second;
    if (const auto type = a.find("type")) object_->type = *type;
    if (a.find(kSlice, "meshresolution").value_or("") == "lowres")
      object_->refused = "its solid is a stack of slices, and its mesh only a likeness (slice extension)";
  }

  void end_object() {
    if (!object_) return;
    Object3mf& o = *object_;
    for (std::size_t t = 0; t < o.triangles.size(); ++t)
      for (const std::uint32_t v : o.triangles[t])
        if (v >= o.vertices.size())
          fail(fmt::format("object {}: triangle {} names vertex {}; its mesh has {}", shown(id_), t + 1, v,
                           o.vertices.size()));
    if (!o.has_mesh && o.components.empty() && o.refused.empty())
      o.refused = "it has neither a mesh nor components" +
                  (o.not_read.empty() ? std::string() : ", but " + o.not_read.front());
    if (!role_.empty()) o.volumes.push_back({0, o.triangles.size(), std::exchange(role_, {}), {}});
    object_ = nullptr;
  }

  void vertex(const XmlAttributes& a) {
    if (!object_) return;
    take_bytes(sizeof(std::array<double, 3>));
    std::array<double, 3> p;
    const auto& axes = kVertexRow.keys;
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = number(needed(a, axes[axis]), axes[axis]);
    object_->vertices.push_back(p);
  }

  // @returns false where the words are no numbers
  bool add_row(const std::array<std::string_view, 3>& words) {
    const auto add = [&]<class T>(std::vector<std::array<T, 3>>& to) {
      std::array<T, 3> numbers;
      for (std::size_t n = 0; n < 3; ++n) {
        const std::optional<T> value = whole_number<T>(words[n]);
        if (!value) return false;
        numbers[n] = *value;
      }
      take_bytes(sizeof numbers);
      to.push_back(numbers);
      return true;
    };
    return rows_are_triangles_ ? add(object_->triangles) : add(object_->vertices);
  }

  void triangle(const XmlAttributes& a) {
    if (!object_) return;
    take_bytes(sizeof(std::array<std::uint32_t, 3>));
    object_->triangles.push_back(
        {index(needed(a, "v1"), "v1"), index(needed(a, "v2"), "v2"), index(needed(a, "v3"), "v3")});
  }

  Placed3mf placed(const XmlAttributes& a) const {
    Placed3mf p;
    p.object = std::string(needed(a, "objectid"));
    p.path = std::string(a.find(kProduction, "path").value_or(""));
    const std::string_view printable = a.find("printable").value_or("1");
    p.printable = printable != "0" && lowercase(printable) != "false";
    const std::optional<std::string_view> transform = a.find("transform");
    if (!transform) return p;
    std::string_view rest = *transform;
    for (std::size_t n = 0; n < 12; ++n) {
      rest = trimmed(rest);
      const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
      if (word.empty()) fail(fmt::format("a transform of {} numbers instead of 12", n));
      p.at[n / 3][n % 3] = number(word, "transform");
      rest.remove_prefix(word.size());
    }
    if (!trimmed(rest).empty()) fail("a transform of more than 12 numbers");
    return p;
  }

  // Cura writes the role of a mesh as the object's metadata: cura:infill_mesh = True.
  void metadata(const XmlAttributes& a) {
    const std::string_view name = a.find("name").value_or("");
    if (object_ && name.starts_with("cura:")) key_ = std::string(name.substr(5));
  }
  void end_metadata() {
    static constexpr std::string_view kRoles[] = {"support_mesh", "anti_overhang_mesh", "infill_mesh",
                                                  "cutting_mesh"};
    const std::string key = std::exchange(key_, {}), value = lowercase(trimmed(std::exchange(value_, {})));
    if (std::ranges::find(kRoles, key) != std::end(kRoles) && (value == "true" || value == "1")) role_ = key;
  }

  void foreign(const XmlName& element, const XmlAttributes& a) {
    if (element.space.starts_with(kBeams) && element.local == "beamlattice") {
      object_->refused = "it has a beam lattice, which is no mesh of triangles";
    } else if (element.local == "volume" && a.find("ts")) {  // Slic3r: triangles ts to te
      if (a.find("modifier").value_or("0") == "1")
        object_->volumes.push_back(
            {index(*a.find("ts"), "ts"), std::size_t(index(needed(a, "te"), "te")) + 1, "modifier", {}});
    } else if (element.local != "volumes" && element.space != kTriangleSets &&
               !element.space.starts_with(kBeams)) {
      const std::string what = fmt::format("<{}> of {}", shown(element.local), shown(element.space));
      if (std::ranges::find(object_->not_read, what) == object_->not_read.end() &&
          object_->not_read.size() < kMaxNotRead)
        object_->not_read.push_back(what);
    }
  }

  static constexpr int kNoRows = -1;
  static constexpr std::size_t kMaxNotRead = 5;  // of one object, each named once

  XmlReader reader_;
  Model3mf model_;
  Object3mf* object_ = nullptr;
  std::string id_, role_, key_, value_;
  std::size_t bytes_ = 0, max_bytes_;
  int depth_ = 0, rows_depth_ = kNoRows;  // elements that are open; the one that has rows
  bool rows_are_triangles_ = false;
};

}  // namespace

Model3mf read_model_3mf(ZipPackage& package, const std::string& part, std::size_t max_bytes) {
  ModelHandler handler(package.name() + ": " + part, max_bytes);
  package.read(part, [&](std::string_view piece) { handler.reader().read(piece); });
  handler.reader().finish();
  return handler.take();
}

}  // namespace firn::mesh
