// Solids of boxes that overlap, lie far away, and in 3MF are mirrored and nested: every reader gives
// them the area of each layer and the volume that they were built with.
#include <catch2/catch.hpp>

#include "core/geometry/planar.h"
#include "core/slice/mesh/slicer.h"
#include "files/mesh/mesh_file.h"
#include "tests/support/box_solids.h"

namespace firn::test {
namespace {

constexpr int kFiles = 200;
constexpr double kLayer_mm = 0.5;  // faces lie on multiples of it, planes between them

std::vector<BoxBody> drawn_bodies(RandomStream& random) {
  std::vector<BoxBody> bodies(1 + random.below(4));
  for (BoxBody& body : bodies) body = transformed(drawn_body(random), drawn_transform(random));
  return bodies;
}

/// Most files lie near the origin, some on a map.
Vec3 drawn_shift(RandomStream& random) {
  if (random.below(2)) return {};
  return {500'123.25 - random.below(2) * 1e6, 4'512'345.5, 300.125};
}

void check_solid(const mesh_bytes::Bytes& bytes, const std::string& name,
                 const std::vector<BoxBody>& bodies) {
  const MeshData data = read_mesh(bytes, name);
  CHECK(data.defects.empty());
  slice::Placement onto_platform;
  for (slice::AxisPlace& axis : onto_platform.translation) axis = {slice::AxisPlace::Mode::kNumber, 0.0};
  slice::SliceOptions options;
  options.layer_height_mm = kLayer_mm;
  options.chord_tolerance_mm = 0.0;
  const slice::Sliced sliced = slice::slice(data.facets(), onto_platform, options, serially);
  CHECK(sliced.facts.closed);
  CHECK(sliced.facts.volume_mm3 == Approx(volume_of(bodies)).epsilon(1e-9));
  for (const slice::Defect& d : sliced.defects) CHECK(d.kind == slice::DefectKind::kOverlap);
  if (bodies.size() == 1) CHECK(sliced.defects.empty());
  const double low = lowest_of(bodies);
  for (std::size_t n = 0; n < sliced.layers.size(); ++n) {
    INFO("layer " << n + 1);
    CHECK(geometry::area_mm2(sliced.layers[n]) ==
          Approx(area_at(bodies, low + kLayer_mm * (double(n) + 0.5))).epsilon(1e-9).margin(1e-6));
  }
}

template <class Write>
void check_format(const std::string& name, const Write& write) {
  for (std::uint64_t seed = 0; seed < kFiles; ++seed) {
    INFO(name << ", seed " << seed);
    RandomStream random(seed, Purpose::kTest);
    const std::vector<BoxBody> bodies = drawn_bodies(random);
    check_solid(write(bodies, random), name, bodies);
  }
}

}  // namespace

TEST_CASE("200 drawn binary STL files have the area and volume that they were built with") {
  check_format("a.stl", [](const auto& bodies, RandomStream&) { return box_bytes::binary_stl(bodies); });
}

TEST_CASE("200 drawn ASCII STL files have the area and volume that they were built with, however far away") {
  check_format("a.stl", [](const auto& bodies, RandomStream& random) {
    return box_bytes::ascii_stl(bodies, drawn_shift(random));
  });
}

TEST_CASE("200 drawn OBJ files have the area and volume that they were built with, concave faces included") {
  check_format("a.obj", [](const auto& bodies, RandomStream& random) {
    const Vec3 shift = drawn_shift(random);
    return box_bytes::obj(bodies, shift, random);
  });
}

TEST_CASE("200 drawn PLY files of each form have the area and volume that they were built with") {
  for (const char* form : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    INFO(form);
    check_format("a.ply", [&](const auto& bodies, RandomStream& random) {
      const Vec3 shift = drawn_shift(random);
      return box_bytes::ply(bodies, shift, form, random);
    });
  }
}

TEST_CASE("200 drawn 3MF files have their area and volume, mirrored, nested and in several parts") {
  for (std::uint64_t seed = 0; seed < kFiles; ++seed) {
    INFO("seed " << seed);
    RandomStream random(seed, Purpose::kTest);
    std::string here, elsewhere, items;
    std::vector<BoxBody> bodies;
    int id = 0;
    const auto object = [&](const std::string& inner) {
      return "<object id=\"" + std::to_string(++id) + "\">" + inner + "</object>";
    };
    for (std::uint32_t n = 1 + random.below(4); n > 0; --n) {
      BoxBody body = drawn_body(random);
      const bool apart = random.below(2);
      (apart ? elsewhere : here) += object(box_bytes::threemf_mesh(body));
      std::string path = apart ? "p:path=\"/3D/Objects/more.model\" " : "";
      for (std::uint32_t level = random.below(3); level > 0; --level) {
        const BoxTransform t = drawn_transform(random);
        const int inner = id;
        here += object("<components><component " + path + "objectid=\"" + std::to_string(inner) +
                       "\" transform=\"" + t.text() + "\"/></components>");
        path.clear();
        body = transformed(body, t);
      }
      const BoxTransform t = drawn_transform(random);
      items += "<item " + path + "objectid=\"" + std::to_string(id) + "\" transform=\"" + t.text() + "\"/>";
      bodies.push_back(transformed(body, t));
    }
    check_solid(mesh_bytes::threemf_with(
                    "<resources>" + here + "</resources><build>" + items + "</build>",
                    {{"3D/Objects/more.model",
                      mesh_bytes::threemf_model("<resources>" + elsewhere + "</resources><build/>")}},
                    "requiredextensions=\"p\""),
                "a.3mf", bodies);
  }
}

}  // namespace firn::test
