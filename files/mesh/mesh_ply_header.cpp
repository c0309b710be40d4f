#include <fmt/core.h>

#include <utility>

#include "files/mesh/mesh_formats.h"
#include "files/mesh/mesh_ply.h"

namespace firn::mesh {
namespace {

constexpr std::size_t kMaxHeaderBytes = 100'000, kMaxElements = 100, kMaxProperties = 200;

PlyType type_named(std::string_view word) {
  static constexpr std::pair<std::string_view, PlyType> kNames[] = {
      {"char", PlyType::kInt8},     {"int8", PlyType::kInt8},     {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},   {"short", PlyType::kInt16},   {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16}, {"uint16", PlyType::kUint16}, {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},   {"uint", PlyType::kUint32},   {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat},   {"float32", PlyType::kFloat}, {"double", PlyType::kDouble},
      {"float64", PlyType::kDouble}};
  for (const auto& [name, type] : kNames)
    if (word == name) return type;
  return PlyType::kNone;
}

class HeaderReader {
 public:
  HeaderReader(std::string_view text, const std::string& name) : at_(text.substr(0, kMaxHeaderBytes), name) {}

  PlyHeader read() {
    if (at_.word() != "ply") at_.fail("is no PLY file: it does not begin with \"ply\"");
    next_line();
    for (;;) {
      const std::string_view word = at_.word_in_line();
      if (word == "end_header") break;
      if (word == "format")
        format();
      else if (word == "element")
        element();
      else if (word == "property")
        property();
      else if (word.empty() && at_.ended())
        at_.fail("the header has no end_header");
      else if (!word.empty() && word != "comment" && word != "obj_info")
        at_.fail(fmt::format("unknown word \"{}\" in the header", word.substr(0, 40)));
      next_line();
    }
    next_line();
    header_.bytes = at_.offset();
    finish();
    return std::move(header_);
  }

 private:
  void next_line() {
    at_.skip_line();
    ++header_.lines;
  }

  void format() {
    const std::string_view word = at_.word_in_line();
    if (word == "ascii")
      header_.text = true;
    else if (word == "binary_big_endian")
      header_.big_endian = true;
    else if (word != "binary_little_endian")
      at_.fail(fmt::format("format {}: must be ascii, binary_little_endian or binary_big_endian",
                           word.substr(0, 40)));
    if (has_format_) at_.fail("a second format");
    has_format_ = true;
  }

  void element() {
    if (header_.elements.size() == kMaxElements) at_.fail(fmt::format("more than {} elements", kMaxElements));
    PlyElement e;
    e.name = at_.word_in_line();
    const std::int64_t count = at_.whole(at_.word_in_line(), "the count of an element");
    if (count < 0) at_.fail(fmt::format("element {} {}: a count is 0 or more", e.name.substr(0, 40), count));
    e.count = std::size_t(count);
    for (const PlyElement& before : header_.elements)
      if (before.name == e.name) at_.fail(fmt::format("a second element {}", e.name.substr(0, 40)));
    header_.elements.push_back(std::move(e));
  }

  PlyType type() {
    const std::string_view word = at_.word_in_line();
    const PlyType type = type_named(word);
    if (type == PlyType::kNone)
      at_.fail(fmt::format("unknown type \"{}\" of a property", word.substr(0, 40)));
    return type;
  }

  void property() {
    if (header_.elements.empty()) at_.fail("a property before the first element");
    PlyElement& e = header_.elements.back();
    if (e.properties.size() == kMaxProperties)
      at_.fail(fmt::format("more than {} properties", kMaxProperties));
    PlyProperty p;
    const std::string_view word = at_.word_in_line();
    if (word == "list") {
      p.count_type = type();
      if (p.count_type >= PlyType::kFloat) at_.fail("the length of a list must be a whole number");
      p.type = type();
    } else {
      p.type = type_named(word);
      if (p.type == PlyType::kNone)
        at_.fail(fmt::format("unknown type \"{}\" of a property", word.substr(0, 40)));
    }
    p.name = at_.word_in_line();
    if (e.name == "vertex" && !p.is_list() && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z')
      p.axis = p.name[0] - 'x';
    if (e.name == "face" && p.is_list() && (p.name == "vertex_indices" || p.name == "vertex_index")) {
      if (p.type >= PlyType::kFloat) at_.fail(p.name + " must be whole numbers");
      if (header_.face_list) at_.fail("a second list of vertices of a face");
      header_.face_list = e.properties.size();
    }
    e.properties.push_back(std::move(p));
  }

  void finish() const {
    if (!has_format_) at_.fail("the header has no format");
    bool has_vertices = false, has_faces = false;
    for (const PlyElement& e : header_.elements) {
      if (e.name == "tristrips")
        at_.fail("the element tristrips (strips of triangles) is not read: write the mesh with faces");
      if (e.name == "vertex") {
        has_vertices = true;
        int axes = 0;
        for (const PlyProperty& p : e.properties)
          if (p.axis >= 0) axes += axes & (1 << p.axis) ? 8 : 1 << p.axis;
        if (axes != 7) at_.fail("vertices must have each of x, y, z once");
        if (e.count > 0xffffffffu) at_.fail(fmt::format("{} vertices are more than 32 bits count", e.count));
      } else if (e.name == "face") {
        has_faces = true;
        if (!has_vertices) at_.fail("the faces stand before the vertices");
        if (!header_.face_list) at_.fail("faces have no list vertex_indices");
      }
    }
    if (!has_vertices) at_.fail("the header declares no element vertex");
    if (!has_faces) at_.fail("the header declares no element face: a cloud of points has no inside");
  }

  TextCursor at_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat:
      return 4;
    case PlyType::kDouble:
      return 8;
    case PlyType::kNone:
      break;
  }
  return 0;
}

std::size_t min_bytes(const PlyElement& element) {
  std::size_t sum = 0;
  for (const PlyProperty& p : element.properties) sum += size_of(p.is_list() ? p.count_type : p.type);
  return sum;
}

PlyHeader read_ply_header(std::string_view text, const std::string& name) {
  return HeaderReader(text, name).read();
}

}  // namespace firn::mesh
