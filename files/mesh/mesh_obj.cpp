// OBJ: v lines and f lines. Normals, textures, groups and materials do not change the solid; free-form
// surfaces do, and are reported.
#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "files/mesh/mesh_builder.h"
#include "files/mesh/mesh_formats.h"
#include "files/usage_error.h"

namespace firn::mesh {
namespace {

constexpr std::int64_t kMaxVertices = std::numeric_limits<std::int32_t>::max();

class ObjReader {
 public:
  ObjReader(Bytes bytes, const std::string& name) : at_(as_text(bytes), name), name_(name) {
    MeshData& data = build_.data();
    data.format = "OBJ";
    const std::size_t guess = bytes.size() / 90;  // a vertex and two faces take some 90 bytes
    data.vertices.reserve(guess);
    data.triangles.reserve(2 * guess);
  }

  MeshData read() {
    while (!at_.ended()) {
      const std::string_view word = at_.word();
      if (word == "v") {
        vertex();
      } else if (word == "f" || word == "fo") {  // fo: the same in files of old
        face();
      } else {
        surfaces_ += word == "surf";
        at_.skip_line();  // a remark may end with a backslash, as paths do
      }
    }
    if (needed_ > vertices())
      throw UsageError(fmt::format("{}:{}: a face names vertex {}, but the file has {}", name_,
                                   at_.line_of(needed_at_), needed_, vertices()));
    check_count(name_, 0, build_.data().triangles.size());
    MeshData data = build_.finish([&](std::size_t at) { return fmt::format("line {}", at_.line_of(at)); });
    if (surfaces_)
      data.defects.push_back(fmt::format("{} free-form surfaces (surf) are not read", surfaces_));
    return data;
  }

 private:
  std::size_t vertices() { return build_.data().vertices.size(); }

  /// The next word of this line, or of the next one where a backslash ends this one; empty at the end.
  std::string_view next_word() {
    for (;;) {
      std::string_view word = at_.word_in_line();
      if (word.empty() || word.back() != '\\') return word;
      TextCursor ahead = at_;
      if (!ahead.word_in_line().empty()) return word;
      at_.skip_line();
      word.remove_suffix(1);
      if (!word.empty()) return word;
    }
  }
  void vertex() {
    std::array<double, 3> p;
    for (double& c : p) c = at_.number(next_word(), "a coordinate");
    build_.add_vertex(p);
    if (std::int64_t(vertices()) > kMaxVertices)
      at_.fail(fmt::format("more vertices than the limit of {}", kMaxVertices));
    for (std::string_view word = next_word(); !word.empty() && word.front() != '#';) word = next_word();
    at_.skip_line();
  }

  // "7", "7/1", "7//3"; -1 is the last vertex so far.
  void face() {
    const std::size_t begin = at_.offset();
    corners_.clear();
    for (std::string_view word = next_word(); !word.empty(); word = next_word()) {
      if (word.front() == '#') break;
      const std::int64_t number = at_.whole(word.substr(0, word.find('/')), "a vertex of a face");
      const std::int64_t index = number > 0 ? number - 1 : std::int64_t(vertices()) + number;
      if (number == 0 || index < 0 || index > kMaxVertices)
        at_.fail(fmt::format("a face names vertex {}; {} are known here", number, vertices()));
      if (std::size_t(index) >= std::max(needed_, vertices())) {
        needed_ = std::size_t(index) + 1;
        needed_at_ = begin;
      }
      corners_.push_back(std::uint32_t(index));
    }
    build_.add_facet(corners_, begin);
    at_.skip_line();
  }

  TextCursor at_;
  const std::string& name_;
  MeshBuilder build_;
  std::vector<std::uint32_t> corners_;
  std::size_t surfaces_ = 0;
  std::size_t needed_ = 0, needed_at_ = 0;  // vertices used before their lines, and the face's place
};

}  // namespace

MeshData read_obj(Bytes bytes, const std::string& name) {
  check_encoding(as_text(bytes), name);
  bytes = without_byte_order_mark(bytes);
  check_text_form(as_text(bytes), name);
  return ObjReader(bytes, name).read();
}

}  // namespace firn::mesh
