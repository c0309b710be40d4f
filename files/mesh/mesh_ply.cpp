// PLY: a text header that declares elements and their properties, then text or binary rows of either byte
// order.
#include "files/mesh/mesh_ply.h"

#include <fmt/core.h>

#include <bit>
#include <concepts>

#include "files/mesh/mesh_builder.h"
#include "files/mesh/mesh_formats.h"
#include "files/usage_error.h"

namespace firn::mesh {
namespace {

static_assert(std::endian::native == std::endian::little);

template <class T>
T load(const std::byte* at, bool swap) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), at, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

template <class Value>
Value load_as(PlyType type, const std::byte* at, bool swap) {
  switch (type) {
    case PlyType::kInt8:
      return Value(load<std::int8_t>(at, swap));
    case PlyType::kUint8:
      return Value(load<std::uint8_t>(at, swap));
    case PlyType::kInt16:
      return Value(load<std::int16_t>(at, swap));
    case PlyType::kUint16:
      return Value(load<std::uint16_t>(at, swap));
    case PlyType::kInt32:
      return Value(load<std::int32_t>(at, swap));
    case PlyType::kUint32:
      return Value(load<std::uint32_t>(at, swap));
    case PlyType::kFloat:
      if constexpr (std::floating_point<Value>)
        return Value(load<float>(at, swap));
      else
        return Value{};
    case PlyType::kDouble:
      if constexpr (std::floating_point<Value>)
        return Value(load<double>(at, swap));
      else
        return Value{};
    case PlyType::kNone:
      break;
  }
  return Value{};
}

class BinaryRows {
 public:
  BinaryRows(Bytes bytes, std::size_t at, const PlyHeader& header, const std::string& name,
             MeshBuilder& build)
      : bytes_(bytes), at_(at), swap_(header.big_endian), name_(name), build_(build) {}

  void vertices(const PlyElement& element) {
    if (element.has_list()) return vertices_with_lists(element);
    const std::size_t stride = min_bytes(element);
    std::array<std::size_t, 3> offset{};
    std::array<PlyType, 3> type{};
    std::size_t here = 0;
    for (const PlyProperty& p : element.properties) {
      if (p.axis >= 0) {
        offset[std::size_t(p.axis)] = here;
        type[std::size_t(p.axis)] = p.type;
      }
      here += size_of(p.type);
    }
    const bool floats = type == std::array{PlyType::kFloat, PlyType::kFloat, PlyType::kFloat};
    const bool plain = !swap_ && floats && offset[1] == offset[0] + 4 && offset[2] == offset[0] + 8;
    std::vector<slice::Corner>& vertices = build_.data().vertices;
    vertices.reserve(element.count);
    for (std::size_t n = 0; n < element.count; ++n, at_ += stride) {
      const std::byte* row = bytes_.data() + at_;
      slice::Corner p;
      std::array<double, 3> exact;
      if (plain)
        std::memcpy(p.data(), row + offset[0], sizeof p);
      else
        for (std::size_t a = 0; a < 3; ++a)
          p[a] = float(exact[a] = load_as<double>(type[a], row + offset[a], swap_));
      if (floats)  // what the file has lost, no origin brings back
        vertices.push_back(p);
      else
        build_.add_vertex(exact);
    }
  }

  /// @param to_the_end rows as long as there are bytes, whatever the header claims
  void faces(const PlyElement& element, std::size_t list, bool to_the_end) {
    const PlyProperty& p = element.properties[list];
    const std::size_t width = size_of(p.type);
    const bool plain =
        !swap_ && element.properties.size() == 1 && p.count_type == PlyType::kUint8 && width == 4;
    if (!to_the_end) build_.data().triangles.reserve(element.count);
    for (std::size_t n = 0; to_the_end ? at_ < bytes_.size() : n < element.count; ++n) {
      if (plain && bytes_.size() - at_ >= 13 &&
          bytes_[at_] == std::byte(3)) {  // nearly every face of nearly every file
        std::array<std::uint32_t, 3> t;
        std::memcpy(t.data(), bytes_.data() + at_ + 1, sizeof t);
        for (const std::uint32_t v : t)
          if (v >= vertex_count()) fail_index(n, std::int32_t(v));
        build_.add_facet(t, n);
        at_ += 13;
        continue;
      }
      for (std::size_t k = 0; k < list; ++k) skip(element.properties[k]);
      const std::size_t corners = list_length(p);
      polygon_.resize(corners);
      for (std::size_t c = 0; c < corners; ++c, at_ += width) {
        const auto index = load_as<std::int64_t>(p.type, bytes_.data() + at_, swap_);
        if (index < 0 || std::size_t(index) >= vertex_count()) fail_index(n, index);
        polygon_[c] = std::uint32_t(index);
      }
      build_.add_facet(polygon_, n);
      for (std::size_t k = list + 1; k < element.properties.size(); ++k) skip(element.properties[k]);
    }
  }

  void pass_over(const PlyElement& element) {
    if (!element.has_list()) {
      at_ += min_bytes(element) * element.count;
      return;
    }
    for (std::size_t n = 0; n < element.count; ++n)
      for (const PlyProperty& p : element.properties) skip(p);
  }

  /// The rows must fit the file before anything is allocated for them.
  void check(const PlyElement& element) const {
    const std::size_t least = min_bytes(element);
    if (least == 0 && element.count > 0) fail(fmt::format("element {} has rows without bytes", element.name));
    if (least > 0 && element.count > (bytes_.size() - at_) / least)
      fail(fmt::format("the header claims {} rows of {}, which take {} bytes or more each; {} bytes are left",
                       element.count, element.name, least, bytes_.size() - at_));
  }
  /// The text behind the last row: "" = less than a row of the element.
  std::string rest(const PlyElement& last) const {
    const std::size_t left = bytes_.size() - at_;
    std::size_t row = min_bytes(last);
    for (const PlyProperty& p : last.properties)
      if (p.is_list()) row += 3 * size_of(p.type);  // of a triangle
    if (left > 0)
      build_.data().defects.push_back(fmt::format("{} bytes stand behind the last element", left));
    return left < row ? std::string() : fmt::format("{} bytes", left);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { fail_at_byte(name_, at_, problem); }
  [[noreturn]] void fail_index(std::size_t face, std::int64_t index) const {
    fail(fmt::format("face {} names vertex {}; there are {}", face, index, vertex_count()));
  }
  std::size_t vertex_count() const { return build_.data().vertices.size(); }
  void vertices_with_lists(const PlyElement& element) {
    for (std::size_t n = 0; n < element.count; ++n) {
      std::array<double, 3> point{};
      for (const PlyProperty& p : element.properties) {
        const std::size_t at = at_;
        skip(p);
        if (p.axis >= 0) point[std::size_t(p.axis)] = load_as<double>(p.type, bytes_.data() + at, swap_);
      }
      build_.add_vertex(point);
    }
  }
  std::size_t list_length(const PlyProperty& p) {
    need(size_of(p.count_type));
    const auto n = load_as<std::int64_t>(p.count_type, bytes_.data() + at_, swap_);
    if (n < 0) fail(fmt::format("a list of {} entries", n));
    at_ += size_of(p.count_type);
    if (std::size_t(n) > (bytes_.size() - at_) / size_of(p.type))
      fail(fmt::format("ends within a list of {} entries", n));
    return std::size_t(n);
  }
  void skip(const PlyProperty& p) {
    std::size_t n = 1;
    if (p.is_list())
      n = list_length(p);
    else
      need(size_of(p.type));
    at_ += n * size_of(p.type);
  }
  void need(std::size_t bytes) const {
    if (bytes_.size() - at_ < bytes) fail("ends within an element");
  }

  Bytes bytes_;
  std::size_t at_;
  bool swap_;
  const std::string& name_;
  MeshBuilder& build_;
  std::vector<std::uint32_t> polygon_;
};

class TextRows {
 public:
  TextRows(Bytes bytes, const PlyHeader& header, const std::string& name, MeshBuilder& build)
      : at_(as_text(bytes).substr(header.bytes), name, header.lines + 1), build_(build) {}

  void vertices(const PlyElement& element) {
    build_.data().vertices.reserve(element.count);
    for (std::size_t n = 0; n < element.count; ++n) {
      std::array<double, 3> v{};
      for (const PlyProperty& p : element.properties) {
        if (p.is_list())
          skip(p);
        else if (p.axis >= 0)
          v[std::size_t(p.axis)] = at_.number(at_.word(), "a coordinate");
        else
          value();
      }
      build_.add_vertex(v);
    }
  }

  void faces(const PlyElement& element, std::size_t list, bool to_the_end) {
    if (!to_the_end) build_.data().triangles.reserve(element.count);
    for (std::size_t n = 0; to_the_end ? has_more() : n < element.count; ++n)
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        if (k != list) {
          skip(element.properties[k]);
          continue;
        }
        polygon_.resize(list_length());
        const std::size_t vertices = build_.data().vertices.size();
        for (std::uint32_t& corner : polygon_) {
          const std::int64_t index = at_.whole(at_.word(), "a vertex of a face");
          if (index < 0 || std::size_t(index) >= vertices)
            at_.fail(fmt::format("face {} names vertex {}; there are {}", n, index, vertices));
          corner = std::uint32_t(index);
        }
        build_.add_facet(polygon_, n);
      }
  }

  void pass_over(const PlyElement& element) {
    for (std::size_t n = 0; n < element.count; ++n)
      for (const PlyProperty& p : element.properties) skip(p);
  }

  void check(const PlyElement& element) const {
    const std::size_t least =
        2 * element.properties.size();  // a digit and a blank each, but for the last of the file
    if (element.count > 0 && (least == 0 || element.count > (at_.left() + 1) / least))
      at_.fail(fmt::format("the header claims {} rows of {}; {} bytes are left for them", element.count,
                           element.name, at_.left()));
  }
  std::string rest(const PlyElement&) const {
    if (!has_more()) return {};
    build_.data().defects.push_back("text stands behind the last element");
    return "text";
  }

 private:
  bool has_more() const {
    TextCursor ahead = at_;
    return !ahead.word().empty();
  }
  void value() {
    if (at_.word().empty()) at_.fail("the file ends within an element");
  }
  std::size_t list_length() {
    const std::int64_t n = at_.whole(at_.word(), "the length of a list");
    if (n < 0 || std::size_t(n) > at_.left())
      at_.fail(fmt::format("a list of {} entries; {} bytes are left for them", n, at_.left()));
    return std::size_t(n);
  }
  void skip(const PlyProperty& p) {
    std::size_t n = p.is_list() ? list_length() : 1;
    while (n-- > 0) value();
  }

  TextCursor at_;
  MeshBuilder& build_;
  std::vector<std::uint32_t> polygon_;
};

template <class Rows>
void read_rows(Rows& rows, const PlyHeader& header, const std::string& name, FacetCount choice) {
  const PlyElement& last = header.elements.back();
  const bool to_the_end = choice == FacetCount::kFile && last.name == "face";
  for (const PlyElement& element : header.elements) {
    if (!to_the_end || &element != &last) rows.check(element);
    if (element.name == "vertex")
      rows.vertices(element);
    else if (element.name == "face")
      rows.faces(element, *header.face_list, to_the_end);
    else
      rows.pass_over(element);
  }
  const std::string rest = rows.rest(last);
  if (!rest.empty() && choice != FacetCount::kHeader)
    throw UsageError(fmt::format("{}: the header claims {} rows of {}; behind them stand {} more: {}", name,
                                 last.count, last.name, rest, kChooseCount));
}

}  // namespace

MeshData read_ply(Bytes bytes, const std::string& name, FacetCount choice) {
  const PlyHeader header = read_ply_header(as_text(bytes), name);
  MeshBuilder build;
  if (header.text) {
    TextRows rows(bytes, header, name, build);
    read_rows(rows, header, name, choice);
  } else {
    BinaryRows rows(bytes, header.bytes, header, name, build);
    read_rows(rows, header, name, choice);
  }
  check_count(name, header.bytes, build.data().triangles.size());
  build.data().format = header.text ? "ASCII PLY" : header.big_endian ? "big-endian PLY" : "binary PLY";
  return build.finish([](std::size_t n) { return fmt::format("face {}", n); });
}

}  // namespace firn::mesh
