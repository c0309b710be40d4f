// OBJ: v lines and f lines; everything else (normals, textures, groups, materials) is passed over.
#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "files/mesh/mesh_formats.h"
#include "files/usage_error.h"

namespace firn::mesh {
namespace {

constexpr std::int64_t kMaxVertices = std::numeric_limits<std::int32_t>::max();

class ObjReader {
 public:
  ObjReader(Bytes bytes, const std::string& name) : at_(as_text(bytes), name), name_(name) {
    data_.format = "OBJ";
    const std::size_t guess = bytes.size() / 90;  // a vertex and two faces take some 90 bytes
    data_.vertices.reserve(guess);
    data_.triangles.reserve(2 * guess);
  }

  MeshData read() {
    while (!at_.ended()) {
      const std::string_view word = at_.word();
      if (word == "v")
        vertex();
      else if (word == "f")
        face();
      else
        at_.skip_line();
    }
    if (needed_ > data_.vertices.size())
      throw UsageError(fmt::format("{}:{}: a face names vertex {}, but the file has {}", name_, needed_line(),
                                   needed_, data_.vertices.size()));
    check_count(name_, 0, data_.triangles.size());
    if (thin_) data_.defects.push_back(fmt::format("{} faces have fewer than 3 corners", thin_));
    return std::move(data_);
  }

 private:
  void vertex() {
    slice::Corner p{};
    for (float& c : p) c = at_.number(at_.word_in_line(), "a coordinate");
    data_.vertices.push_back(p);
    if (std::int64_t(data_.vertices.size()) > kMaxVertices)
      at_.fail(fmt::format("more vertices than the limit of {}", kMaxVertices));
    at_.skip_line();
  }

  // "7", "7/1", "7//3"; -1 is the last vertex so far. A backslash at the end of a line goes on with the next.
  void face() {
    corners_.clear();
    for (std::string_view word = at_.word_in_line(); !word.empty(); word = at_.word_in_line()) {
      if (word == "\\") {
        at_.skip_line();
        continue;
      }
      if (word.front() == '#') break;
      const std::int64_t number = at_.whole(word.substr(0, word.find('/')), "a vertex of a face");
      const std::int64_t index = number > 0 ? number - 1 : std::int64_t(data_.vertices.size()) + number;
      if (number == 0 || index < 0 || index > kMaxVertices)
        at_.fail(fmt::format("a face names vertex {}; {} are known here", number, data_.vertices.size()));
      if (std::size_t(index) >= std::max(needed_, data_.vertices.size())) {
        needed_ = std::size_t(index) + 1;
        needed_at_ = at_.offset();
      }
      corners_.push_back(std::uint32_t(index));
    }
    at_.skip_line();
    if (corners_.size() < 3) ++thin_;
    for (std::size_t c = 2; c < corners_.size(); ++c)
      data_.triangles.push_back({corners_[0], corners_[c - 1], corners_[c]});
  }

  std::size_t needed_line() const {
    const std::string_view all(at_.rest().data() - at_.offset(), at_.offset());
    return 1 + std::size_t(std::count(all.begin(), all.begin() + std::ptrdiff_t(needed_at_), '\n'));
  }

  TextCursor at_;
  const std::string& name_;
  MeshData data_;
  std::vector<std::uint32_t> corners_;
  std::size_t thin_ = 0;
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
