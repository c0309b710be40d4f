// PLY: a text header that declares elements and their properties, then text or binary rows of either byte
// order.
#include "files/mesh/mesh_ply.h"

#include <fmt/core.h>

#include <bit>
#include <concepts>

#include "files/mesh/mesh_formats.h"

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
  BinaryRows(Bytes bytes, std::size_t at, const PlyHeader& header, const std::string& name, PlySink& sink)
      : bytes_(bytes), at_(at), swap_(header.big_endian), name_(name), sink_(sink) {}

  void vertices(const PlyElement& element) {
    const std::size_t stride = least_bytes(element);
    if (element.has_list()) fail("vertices with lists are not supported");
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
    const bool plain = !swap_ && type == std::array{PlyType::kFloat, PlyType::kFloat, PlyType::kFloat} &&
                       offset[1] == offset[0] + 4 && offset[2] == offset[0] + 8;
    sink_.vertices.resize(element.count);
    for (slice::Corner& p : sink_.vertices) {
      const std::byte* row = bytes_.data() + at_;
      if (plain)
        std::memcpy(p.data(), row + offset[0], sizeof p);
      else
        for (std::size_t a = 0; a < 3; ++a) p[a] = load_as<float>(type[a], row + offset[a], swap_);
      at_ += stride;
    }
  }

  void faces(const PlyElement& element, std::size_t list) {
    const PlyProperty& p = element.properties[list];
    const std::size_t width = size_of(p.type);
    const bool plain =
        !swap_ && element.properties.size() == 1 && p.count_type == PlyType::kUint8 && width == 4;
    sink_.begin_faces(element.count);
    for (std::size_t n = 0; n < element.count; ++n) {
      if (plain && bytes_.size() - at_ >= 13 &&
          bytes_[at_] == std::byte(3)) {  // nearly every face of nearly every file
        std::array<std::uint32_t, 3> t;
        std::memcpy(t.data(), bytes_.data() + at_ + 1, sizeof t);
        if (!sink_.add(t)) fail_face(n, t);
        at_ += 13;
        continue;
      }
      for (std::size_t k = 0; k < list; ++k) skip(element.properties[k]);
      const std::size_t corners = list_length(p);
      sink_.polygon.resize(corners);
      for (std::size_t c = 0; c < corners; ++c, at_ += width) {
        const auto index = load_as<std::int64_t>(p.type, bytes_.data() + at_, swap_);
        if (index < 0 || std::size_t(index) >= sink_.vertices.size()) fail_index(n, index);
        sink_.polygon[c] = std::uint32_t(index);
      }
      sink_.add_polygon();
      for (std::size_t k = list + 1; k < element.properties.size(); ++k) skip(element.properties[k]);
    }
  }

  void pass_over(const PlyElement& element) {
    if (!element.has_list()) {
      at_ += least_bytes(element) * element.count;
      return;
    }
    for (std::size_t n = 0; n < element.count; ++n)
      for (const PlyProperty& p : element.properties) skip(p);
  }

  /// The rows must fit the file before anything is allocated for them.
  void check(const PlyElement& element) const {
    const std::size_t least = least_bytes(element);
    if (least == 0 && element.count > 0) fail(fmt::format("element {} has rows without bytes", element.name));
    if (least > 0 && element.count > (bytes_.size() - at_) / least)
      fail(fmt::format("the header claims {} rows of {}, which take {} bytes or more each; {} bytes are left",
                       element.count, element.name, least, bytes_.size() - at_));
  }
  void end() const {
    if (at_ < bytes_.size())
      sink_.defects.push_back(fmt::format("{} bytes stand behind the last element", bytes_.size() - at_));
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { fail_at_byte(name_, at_, problem); }
  [[noreturn]] void fail_index(std::size_t face, std::int64_t index) const {
    fail(fmt::format("face {} names vertex {}; there are {}", face, index, sink_.vertices.size()));
  }
  [[noreturn]] void fail_face(std::size_t face, const std::array<std::uint32_t, 3>& t) const {
    for (std::uint32_t v : t)
      if (v >= sink_.vertices.size()) fail_index(face, std::int32_t(v));
    fail_index(face, 0);
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
  PlySink& sink_;
};

class TextRows {
 public:
  TextRows(Bytes bytes, const PlyHeader& header, const std::string& name, PlySink& sink)
      : at_(as_text(bytes).substr(header.bytes), name, header.lines + 1), sink_(sink) {}

  void vertices(const PlyElement& element) {
    sink_.vertices.resize(element.count);
    for (slice::Corner& v : sink_.vertices)
      for (const PlyProperty& p : element.properties) {
        if (p.is_list())
          skip(p);
        else if (p.axis >= 0)
          v[std::size_t(p.axis)] = at_.number(at_.word(), "a coordinate");
        else
          value();
      }
  }

  void faces(const PlyElement& element, std::size_t list) {
    sink_.begin_faces(element.count);
    for (std::size_t n = 0; n < element.count; ++n)
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        if (k != list) {
          skip(element.properties[k]);
          continue;
        }
        sink_.polygon.resize(list_length());
        for (std::uint32_t& corner : sink_.polygon) {
          const std::int64_t index = at_.whole(at_.word(), "a vertex of a face");
          if (index < 0 || std::size_t(index) >= sink_.vertices.size())
            at_.fail(fmt::format("face {} names vertex {}; there are {}", n, index, sink_.vertices.size()));
          corner = std::uint32_t(index);
        }
        sink_.add_polygon();
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
  void end() {
    if (!at_.word().empty()) sink_.defects.push_back("text stands behind the last element");
  }

 private:
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
  PlySink& sink_;
};

template <class Rows>
void read_rows(Rows& rows, const PlyHeader& header) {
  for (const PlyElement& element : header.elements) {
    rows.check(element);
    if (element.name == "vertex")
      rows.vertices(element);
    else if (element.name == "face")
      rows.faces(element, *header.face_list);
    else
      rows.pass_over(element);
  }
  rows.end();
}

}  // namespace

MeshData read_ply(Bytes bytes, const std::string& name) {
  const PlyHeader header = read_ply_header(as_text(bytes), name);
  PlySink sink;
  if (header.text) {
    TextRows rows(bytes, header, name, sink);
    read_rows(rows, header);
  } else {
    BinaryRows rows(bytes, header.bytes, header, name, sink);
    read_rows(rows, header);
  }
  check_count(name, header.bytes, sink.triangles.size());
  MeshData data;
  data.format = header.text ? "ASCII PLY" : header.big_endian ? "big-endian PLY" : "binary PLY";
  data.vertices = std::move(sink.vertices);
  data.triangles = std::move(sink.triangles);
  data.defects = std::move(sink.defects);
  if (sink.thin_faces)
    data.defects.push_back(fmt::format("{} faces have fewer than 3 corners", sink.thin_faces));
  return data;
}

}  // namespace firn::mesh
