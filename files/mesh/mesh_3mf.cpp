// 3MF: the solids of the build items, each at its place (core specification 1.3). Marks of a solid
// beyond its triangles are followed, left out with a remark, or refused by name.
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

#include "files/lowercase.h"
#include "files/mesh/mesh_builder.h"
#include "files/mesh/model_3mf.h"
#include "files/mesh/slicer_roles.h"
#include "files/mesh/xml_reader.h"
#include "files/usage_error.h"

namespace firn::mesh {
namespace {

constexpr std::size_t kMaxPlacements = 100'000;  // objects placed by the build and its components
constexpr int kMaxDepth = 32;                    // of components within components
constexpr std::size_t kFreeMemory = std::size_t(512) << 20, kMemoryPerByte = 64;
constexpr std::size_t kMaxRemarks = 20, kShownWord = 40;
constexpr const char* kRootModel = "3D/3dmodel.model";

using Point = std::array<double, 3>;

/// First `inner`, then `outer`.
Transform3mf after(const Transform3mf& inner, const Transform3mf& outer) {
  Transform3mf t{};
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t c = 0; c < 3; ++c) {
      t[row][c] = row == 3 ? outer[3][c] : 0.0;
      for (std::size_t k = 0; k < 3; ++k) t[row][c] += inner[row][k] * outer[k][c];
    }
  return t;
}

Point moved(const Point& p, const Transform3mf& t) {
  Point out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = p[0] * t[0][c] + p[1] * t[1][c] + p[2] * t[2][c] + t[3][c];
  return out;
}

double determinant(const Transform3mf& t) {
  return t[0][0] * (t[1][1] * t[2][2] - t[1][2] * t[2][1]) -
         t[0][1] * (t[1][0] * t[2][2] - t[1][2] * t[2][0]) +
         t[0][2] * (t[1][0] * t[2][1] - t[1][1] * t[2][0]);
}

std::uint64_t hash_of(const Point& p) {
  std::uint64_t h = 0;
  for (const double c : p) h = (h ^ std::bit_cast<std::uint64_t>(c + 0.0)) * 0x9e3779b97f4a7c15ull;
  return (h ^ h >> 32) * 0xd6e8feb86659fd93ull;
}

/// True if a surface is closed and faces inward. Edges cancel as in docs/algorithms/slicing.md.
bool is_inside_out(const Object3mf& object, const Volume3mf& volume) {
  std::uint64_t border = 0;
  double volume_sum = 0.0;
  if (volume.first >= volume.behind) return false;
  const Point& about = object.vertices[object.triangles[volume.first][0]];
  for (std::size_t n = volume.first; n < volume.behind; ++n) {
    std::array<Point, 3> p;
    std::array<std::uint64_t, 3> h;
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = object.vertices[object.triangles[n][c]];
      h[c] = hash_of(p[c]);
      for (std::size_t axis = 0; axis < 3; ++axis) p[c][axis] -= about[axis];
    }
    border += (h[0] - h[1]) * (h[1] - h[2]) * (h[2] - h[0]);
    volume_sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) -
                  p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
                  p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return border == 0 && volume_sum < 0.0;
}

// The root model, by the relationships of the package.
class RootFinder final : public XmlHandler {
 public:
  explicit RootFinder(const std::string& source) : reader(source, *this) {}
  void begin(const XmlName& element, const XmlAttributes& a) override {
    if (element.local == "Relationship" && a.find("Type").value_or("").ends_with("/3dmodel"))
      target = a.find("Target").value_or("");
  }
  XmlReader reader;
  std::string target;
};

class Reader {
 public:
  Reader(Bytes bytes, const std::string& name)
      : name_(name), package_(bytes, name), max_bytes_(kFreeMemory + kMemoryPerByte * bytes.size()) {}

  MeshData read() {
    const std::string root = root_part();
    roles_ = read_slicer_roles(package_);
    const Model3mf& model = model_of(root);
    build_.data().format = "3MF";
    build_.data().mm_per_unit = model.mm_per_unit;
    for (std::size_t n = 0; n < model.items.size(); ++n) {
      const Placed3mf& item = model.items[n];
      if (item.printable)
        place(item, root, kNoTransform, 0, nullptr);
      else
        remark(
            fmt::format("item {} of the build (object {}) is not to be printed (printable=\"0\"): left out",
                        n + 1, shown(item.object)));
    }
    if (roles_.plates > 1)
      remark(fmt::format("its objects lie on {} plates of the slicer: all are read", roles_.plates));
    MeshData data = build_.finish([](std::size_t n) { return fmt::format("triangle {} of its object", n); });
    if (remarks_.size() > kMaxRemarks) {
      const std::size_t more = remarks_.size() - kMaxRemarks;
      remarks_.resize(kMaxRemarks);
      remarks_.push_back(fmt::format("... and {} more remarks", more));
    }
    data.defects.insert(data.defects.begin(), remarks_.begin(), remarks_.end());
    return data;
  }

 private:
  static std::string shown(const std::string& text) { return text.substr(0, kShownWord); }
  [[noreturn]] void fail(const std::string& problem) const { throw UsageError(name_ + ": " + problem); }
  void remark(std::string text) {
    if (std::ranges::find(remarks_, text) == remarks_.end()) remarks_.push_back(std::move(text));
  }

  std::string root_part() {
    constexpr const char* kRelations = "_rels/.rels";
    if (!package_.has(kRelations)) return kRootModel;
    RootFinder finder(name_ + ": " + kRelations);
    package_.read(kRelations, [&](std::string_view piece) { finder.reader.read(piece); });
    finder.reader.finish();
    if (finder.target.empty()) return kRootModel;
    return finder.target.substr(finder.target.starts_with('/'));
  }

  const Model3mf& model_of(const std::string& part) {
    const std::string key = lowercase(part.starts_with('/') ? part.substr(1) : part);
    const auto at = models_.find(key);
    if (at != models_.end()) return at->second;
    return models_.emplace(key, read_model_3mf(package_, part, max_bytes_)).first->second;
  }

  /// @param role of a component, as the slicer has it
  void place(const Placed3mf& placed, const std::string& part, const Transform3mf& outer, int depth,
             const Volume3mf* role) {
    if (depth > kMaxDepth)
      fail(fmt::format("object {}: components within components, more than {} deep", shown(placed.object),
                       kMaxDepth));
    if (++placements_ > kMaxPlacements)
      fail(fmt::format("its items and components place more than {} objects, the limit", kMaxPlacements));
    const std::string& home = placed.path.empty() ? part : placed.path;
    const Model3mf& model = model_of(home);
    const auto found = model.objects.find(placed.object);
    if (found == model.objects.end())
      fail(fmt::format("{}: there is no object {}, which {} names", shown(home), shown(placed.object),
                       depth == 0 ? "the build" : "a component"));
    const Object3mf& object = found->second;
    const std::string who = "object " + shown(placed.object);
    if (role && !is_printed(*role, who)) return;
    if (object.type != "model") {
      remark(fmt::format("{} is of type {}, no part of the model: left out", who, shown(object.type)));
      return;
    }
    if (!object.refused.empty())
      fail(fmt::format("{} cannot be read: {}. Export the part as triangles from the program that made it",
                       who, object.refused));
    for (const std::string& what : object.not_read) remark(fmt::format("{}: {} is not read", who, what));
    const Transform3mf at = after(placed.at, outer);
    const auto of_object = depth == 0 ? roles_.objects.find(placed.object) : roles_.objects.end();
    const SlicerRoles::OfObject* roles = of_object == roles_.objects.end() ? nullptr : &of_object->second;
    if (object.has_mesh) add_mesh(object, at, who, roles);
    for (const Placed3mf& component : object.components) {
      const Volume3mf* of_component = nullptr;
      if (roles)
        if (const auto r = roles->components.find(component.object); r != roles->components.end())
          of_component = &r->second;
      place(component, home, at, depth + 1, of_component);
    }
  }

  bool is_printed(const Volume3mf& volume, const std::string& who) {
    const VolumeUse use = use_of_role(volume.role);
    if (use == VolumeUse::kPrinted) return true;
    const std::string what =
        who + (volume.name.empty() ? std::string() : ", volume \"" + shown(volume.name) + "\"") + ": ";
    if (use == VolumeUse::kRefused)
      fail(fmt::format(
          "{}its role is {}, which changes the solid in a way that Firn does not read. Cut it out "
          "of the part, or leave it out, in the program that made the file, and export again",
          what, shown(volume.role)));
    remark(fmt::format("{}its role is {}, which is no material: left out", what, shown(volume.role)));
    return false;
  }

  /// Which triangles have which role: all of the mesh, in order.
  std::vector<Volume3mf> volumes_of(const Object3mf& object, const std::string& who,
                                    const SlicerRoles::OfObject* roles) const {
    std::vector<Volume3mf> named = object.volumes, all;
    if (roles) named.insert(named.end(), roles->volumes.begin(), roles->volumes.end());
    std::ranges::stable_sort(named, {}, &Volume3mf::first);
    std::size_t done = 0;
    for (Volume3mf& v : named) {
      if (v.behind > object.triangles.size() || v.first > v.behind)
        fail(fmt::format("{}: the slicer's volume \"{}\" has the triangles {} to {}; the mesh has {}", who,
                         shown(v.name), v.first, v.behind, object.triangles.size()));
      if (v.first < done) fail(fmt::format("{}: two of the slicer's volumes have triangle {}", who, v.first));
      if (v.first > done) all.push_back({done, v.first, {}, {}});
      done = v.behind;
      all.push_back(std::move(v));
    }
    if (done < object.triangles.size()) all.push_back({done, object.triangles.size(), {}, {}});
    return all;
  }

  void add_mesh(const Object3mf& object, const Transform3mf& at, const std::string& who,
                const SlicerRoles::OfObject* roles) {
    const std::size_t v0 = build_.data().vertices.size();
    bytes_ += object.vertices.size() * sizeof(slice::Corner) +
              object.triangles.size() * sizeof(object.triangles[0]);
    if (v0 + object.vertices.size() > 0xffffffffu || bytes_ > max_bytes_)
      fail(fmt::format("its placed meshes take more than {} bytes of memory, the limit for this file",
                       max_bytes_));
    const double scale = determinant(at);
    if (scale == 0.0) {
      remark(who + ": its transform makes it flat: left out");
      return;
    }
    for (const Point& p : object.vertices) build_.add_vertex(moved(p, at));
    for (const Volume3mf& volume : volumes_of(object, who, roles)) {
      if (!is_printed(volume, who)) continue;
      const bool inside_out = is_inside_out(object, volume);
      if (inside_out) remark(who + ": its triangles face inward: they were turned");
      const bool turn = (scale < 0.0) != inside_out;
      for (std::size_t n = volume.first; n < volume.behind; ++n) {
        const auto& t = object.triangles[n];
        const auto v = [&](std::size_t c) { return std::uint32_t(v0 + t[c]); };
        const std::array<std::uint32_t, 3> facet{v(0), v(turn ? 2 : 1), v(turn ? 1 : 2)};
        build_.add_facet(facet, n + 1);
      }
    }
  }

  const std::string& name_;
  ZipPackage package_;
  std::size_t max_bytes_, bytes_ = 0, placements_ = 0;
  SlicerRoles roles_;
  std::map<std::string, Model3mf> models_;
  MeshBuilder build_;
  std::vector<std::string> remarks_;
};

}  // namespace

MeshData read_3mf(Bytes bytes, const std::string& name) { return Reader(bytes, name).read(); }

}  // namespace firn::mesh
