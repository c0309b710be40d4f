#include "files/mesh/package_3mf.h"

#include <expat.h>
#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "files/usage_error.h"

namespace firn::mesh {
namespace {

// Text of facets packs to a tenth; a thousandth is deflate's own bound.
constexpr std::uint64_t kMaxRatio = 200, kFreeBytes = std::uint64_t(64) << 20;
constexpr std::size_t kEndRecord = 22, kEntry = 46, kLocal = 30, kMaxComment = 65'535;

template <class T>
std::optional<T> number(Bytes bytes, std::size_t at) {
  if (at > bytes.size() || bytes.size() - at < sizeof(T)) return {};
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// Counts the meshes that each object places; objects name only those before them.
class Objects {
 public:
  explicit Objects(const std::string& name) : name_(name) {}

  void start(const char* element, const char** attributes) {
    const char* colon = std::strrchr(element, ':');
    const std::string_view tag = colon ? colon + 1 : element;
    if (tag == "object") {
      object_ = attribute(attributes, "id");
      placed_[object_] = {};
    } else if (tag == "component") {
      const auto inner = placed_.find(attribute(attributes, "objectid"));
      if (inner == placed_.end() || inner->first == object_) return;  // lib3mf refuses it
      Placed& outer = placed_[object_];
      outer.components += std::max<std::uint64_t>(1, inner->second.components);
      outer.depth = std::max(outer.depth, inner->second.depth + 1);
      check("object " + object_.substr(0, 20) + ": its components place", outer.components);
      if (outer.depth > kMaxComponentDepth)
        refuse(fmt::format("object {}: components within components, more than {} deep",
                           object_.substr(0, 20), kMaxComponentDepth));
    } else if (tag == "item") {
      const auto object = placed_.find(attribute(attributes, "objectid"));
      items_ += object == placed_.end() ? 1 : std::max<std::uint64_t>(1, object->second.components);
      check("the build places", items_);
    }
  }
  const std::string& problem() const { return problem_; }

 private:
  struct Placed {
    std::uint64_t components = 0;
    int depth = 0;
  };
  static std::string attribute(const char** attributes, std::string_view key) {
    for (; *attributes; attributes += 2)
      if (key == *attributes) return attributes[1];
    return "";
  }
  void check(const std::string& who, std::uint64_t count) {
    if (count > kMaxPlacements)
      refuse(fmt::format("{} more than {} objects, the limit", who, kMaxPlacements));
  }
  void refuse(const std::string& problem) {
    if (problem_.empty()) problem_ = name_ + ": " + problem;
  }

  const std::string& name_;
  std::map<std::string, Placed> placed_;
  std::string object_, problem_;
  std::uint64_t items_ = 0;
};

class ModelReader {
 public:
  explicit ModelReader(const std::string& name) : objects_(name), parser_(XML_ParserCreate(nullptr)) {
    XML_SetUserData(parser_.get(), this);
    XML_SetStartElementHandler(parser_.get(), [](void* self, const char* element, const char** attributes) {
      static_cast<ModelReader*>(self)->objects_.start(element, attributes);
    });
  }
  /// Returns false where no more can be read.
  bool read(const unsigned char* text, std::size_t bytes) {
    const bool ok =
        XML_Parse(parser_.get(), reinterpret_cast<const char*>(text), int(bytes), 0) == XML_STATUS_OK;
    if (!objects_.problem().empty()) throw UsageError(objects_.problem());
    return ok;
  }

 private:
  struct Free {
    void operator()(XML_Parser p) const { XML_ParserFree(p); }
  };
  Objects objects_;
  std::unique_ptr<XML_ParserStruct, Free> parser_;
};

struct Part {
  std::string name;
  int method = 0;  // 0 stored, 8 deflated
  Bytes packed;
};

class Package {
 public:
  Package(Bytes bytes, const std::string& name)
      : bytes_(bytes), name_(name), limit_(kFreeBytes + kMaxRatio * bytes.size()) {}

  void check() {
    const std::optional<std::size_t> end = end_record();
    if (!end) return;
    std::size_t at = number<std::uint32_t>(bytes_, *end + 16).value_or(0);
    for (int left = number<std::uint16_t>(bytes_, *end + 10).value_or(0); left > 0; --left) {
      if (number<std::uint32_t>(bytes_, at) != 0x02014b50u) return;
      const std::optional<Part> part = part_at(at);
      if (!part) return;
      if (part->name.ends_with(".model")) read(*part);
    }
  }

 private:
  std::optional<std::size_t> end_record() const {
    if (bytes_.size() < kEndRecord) return {};
    const std::size_t last = bytes_.size() - kEndRecord, first = last - std::min(last, kMaxComment);
    for (std::size_t at = last + 1; at-- > first;)
      if (number<std::uint32_t>(bytes_, at) == 0x06054b50u) return at;
    return {};
  }

  /// The entry of the directory at `at`, which moves behind it.
  std::optional<Part> part_at(std::size_t& at) const {
    const auto name_bytes = number<std::uint16_t>(bytes_, at + 28),
               extra = number<std::uint16_t>(bytes_, at + 30),
               comment = number<std::uint16_t>(bytes_, at + 32),
               method = number<std::uint16_t>(bytes_, at + 10);
    const auto packed = number<std::uint32_t>(bytes_, at + 20),
               local = number<std::uint32_t>(bytes_, at + 42);
    if (!local || bytes_.size() - at - kEntry < *name_bytes) return {};
    const auto local_name = number<std::uint16_t>(bytes_, std::size_t(*local) + 26),
               local_extra = number<std::uint16_t>(bytes_, std::size_t(*local) + 28);
    if (!local_extra) return {};
    const std::size_t begin = std::size_t(*local) + kLocal + *local_name + *local_extra;
    if (begin > bytes_.size()) return {};
    Part part{std::string(as_text(bytes_.subspan(at + kEntry, *name_bytes))), *method,
              bytes_.subspan(begin, std::min<std::size_t>(*packed, bytes_.size() - begin))};
    at += kEntry + *name_bytes + *extra + *comment;
    return part;
  }

  void count(const Part& part, std::size_t bytes) {
    unpacked_ += bytes;
    if (unpacked_ > limit_)
      throw UsageError(fmt::format("{}: {}: unpacks to more than {} bytes, the limit for a file of {}", name_,
                                   part.name.substr(0, 60), limit_, bytes_.size()));
  }

  void read(const Part& part) {
    ModelReader model(name_);
    const auto* data = reinterpret_cast<const unsigned char*>(part.packed.data());
    if (part.method == 0) {
      for (std::size_t at = 0; at < part.packed.size(); at += block_.size()) {
        const std::size_t n = std::min(block_.size(), part.packed.size() - at);
        count(part, n);
        if (!model.read(data + at, n)) return;
      }
    } else if (part.method == 8) {
      inflate_to(part, data, model);
    }
  }

  void inflate_to(const Part& part, const unsigned char* data, ModelReader& model) {
    z_stream z{};
    if (::inflateInit2(&z, -MAX_WBITS) != Z_OK) return;
    const std::unique_ptr<z_stream, int (*)(z_stream*)> ends(&z, &::inflateEnd);
    z.next_in = const_cast<unsigned char*>(data);
    z.avail_in = unsigned(part.packed.size());  // a ZIP entry has less than 4 GiB
    for (int result = Z_OK; result == Z_OK;) {
      z.next_out = block_.data();
      z.avail_out = unsigned(block_.size());
      result = ::inflate(&z, Z_NO_FLUSH);
      const std::size_t n = block_.size() - z.avail_out;
      count(part, n);
      if (n > 0 && !model.read(block_.data(), n)) return;
    }
  }

  Bytes bytes_;
  const std::string& name_;
  std::uint64_t limit_, unpacked_ = 0;
  std::array<unsigned char, 1 << 16> block_{};
};

}  // namespace

void check_3mf_package(Bytes bytes, const std::string& name) { Package(bytes, name).check(); }

}  // namespace firn::mesh
