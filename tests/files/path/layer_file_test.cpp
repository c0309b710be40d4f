// Path files: written layer by layer, read back to the same numbers, and never read past damage.
#include "files/path/layer_file.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "core/grid/random.h"
#include "files/path/path_file.h"
#include "files/usage_error.h"

using namespace firn;
using slice::LayerPaths;

namespace {

namespace fs = std::filesystem;

fs::path scratch(const std::string& name) {
  const fs::path f = fs::path(FIRN_BINARY_DIR) / "tests" / "layer_file";
  fs::create_directories(f);
  return f / name;
}

LayerPaths some_layer(std::int32_t layer, std::uint64_t seed, int paths) {
  RandomStream random(seed, Purpose::kTest);
  LayerPaths l;
  l.layer = layer;
  l.z = 2'500 * layer;
  l.height = 2'500;
  l.clipper_rings = std::uint32_t(layer) % 3;
  for (int p = 0; p < paths; ++p) {
    std::vector<geometry::Point> line;
    const double span =
        p % 3 == 0 ? slice::kMaxPathUnits : 5e5;  // also steps from one end of the range to the other
    for (int n = 0; n <= p * 7 % 20; ++n)
      line.push_back({std::int32_t(random.uniform(-span, span)), std::int32_t(random.uniform(-span, span))});
    l.lines.add(line);
    l.info.push_back({PathKind(p % 4), std::uint8_t(p % 2), p % 5 == 0, p % 4 == 3 ? 0 : 15'000});
  }
  return l;
}

const slice::PathFileHead kHead{
    "firn test", 4, {{"part", "water"}, {"scaffold", "scaffold"}}, "laser", "[layer]\nheight_mm = 0.25\n"};

std::vector<std::byte> file_bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}

std::vector<LayerPaths> layers(int paths = 9) {
  std::vector<LayerPaths> all;
  for (std::int32_t n = 1; n <= 4; ++n)
    all.push_back(some_layer(n, std::uint64_t(n), n == 3 ? 0 : paths));  // one is empty
  return all;
}

std::vector<std::byte> written(const fs::path& file, const std::vector<LayerPaths>& all) {
  LayerWriter out(file, kHead);
  for (const LayerPaths& l : all) out.add(slice::encode(l), l, {{1.0, 2.0}, {3.0, 4.0}});
  out.finish();
  return file_bytes(file);
}

void read_all(std::span<const std::byte> bytes) {
  LayerReader reader(bytes);
  while (reader.next()) {
  }
}

}  // namespace

TEST_CASE("A path file reads back layer by layer, to the same integers, with its totals") {
  const std::vector<LayerPaths> all = layers();
  const fs::path file = scratch("whole.paths");
  written(file, all);
  LayerReader reader(file);
  CHECK(reader.head() == kHead);
  for (const LayerPaths& want : all) {
    const auto layer = reader.next();
    REQUIRE(layer);
    CHECK(*layer == want);
  }
  CHECK_FALSE(reader.next());
  CHECK(reader.totals().layers == 4);
  CHECK(reader.totals().paths == 27);
  REQUIRE(reader.totals().use.size() == 2);
  CHECK(reader.totals().use[1].volume_mm3 == 16.0);
}

TEST_CASE("Smooth paths take two to three bytes a coordinate") {
  LayerPaths l = some_layer(1, 1, 0);
  std::vector<geometry::Point> line;
  for (int n = 0; n < 1'000; ++n) line.push_back({n * 2'000, (n % 50) * 1'000});
  l.lines.add(line);
  l.info.push_back({PathKind::kFill, 0, false, 30'000});
  CHECK(slice::encode(l).size() < 5'000);
}

TEST_CASE("A path file cut at any byte, or with any byte changed, is refused") {
  const std::vector<std::byte> whole = written(scratch("cut.paths"), layers(4));
  CHECK_NOTHROW(read_all(whole));
  for (std::size_t n = 0; n < whole.size(); ++n) {
    INFO("cut to " << n << " of " << whole.size() << " bytes");
    CHECK_THROWS_AS(read_all({whole.data(), n}), FormatError);
  }
  for (std::size_t n = 0; n < whole.size(); ++n) {
    std::vector<std::byte> changed = whole;
    changed[n] ^= std::byte(1 << (n % 8));
    INFO("byte " << n << " changed");
    CHECK_THROWS_AS(read_all(changed), FormatError);
  }
}

TEST_CASE("Layers must ascend and the totals must agree") {
  std::vector<LayerPaths> all = layers();
  std::swap(all[1], all[2]);
  CHECK_THROWS_WITH(read_all(written(scratch("order.paths"), all)),
                    Catch::Contains("layer 2 behind layer 3"));
}

TEST_CASE("Decoders name the byte and the limit of what they refuse") {
  const LayerPaths l = some_layer(1, 5, 6);
  const std::vector<std::byte> good = slice::encode(l);
  const auto with = [&](std::size_t at, std::uint32_t value) {
    std::vector<std::byte> bytes = good;
    std::memcpy(bytes.data() + at, &value, 4);
    return bytes;
  };
  CHECK(slice::decode_layer_paths(good, kHead) == l);
  CHECK_THROWS_WITH(slice::decode_layer_paths(with(0, 0), kHead), "byte 4: layer 0; layers count from 1");
  CHECK_THROWS_WITH(slice::decode_layer_paths(with(8, 0), kHead),
                    Catch::Contains("a layer height that is not above 0"));
  CHECK_THROWS_WITH(slice::decode_layer_paths(with(16, 0xffffffffu), kHead),
                    Catch::Contains("4294967295 paths of"));
  CHECK_THROWS_WITH(slice::decode_layer_paths(with(24, 0xffu), kHead),
                    Catch::Contains("has the unknown kind 255"));
  std::vector<std::byte> longer = good;
  longer.push_back(std::byte(0));
  CHECK_THROWS_WITH(slice::decode_layer_paths(longer, kHead), Catch::Contains("1 bytes are left over"));
  slice::PathFileHead one = kHead;
  one.materials.pop_back();
  CHECK_THROWS_WITH(slice::decode_layer_paths(good, one), Catch::Contains("material 1; the head names 1"));
}

TEST_CASE("What does not fit a path file is not written") {
  LayerPaths l = some_layer(1, 5, 2);
  l.lines.points[0].x = slice::kMaxPathUnits + 1;
  CHECK_THROWS_AS(slice::encode(l), std::invalid_argument);
  l = some_layer(1, 5, 2);
  l.info.pop_back();
  CHECK_THROWS_AS(slice::encode(l), std::invalid_argument);
  const fs::path file = scratch("unfinished.paths");
  fs::remove(file);
  { LayerWriter out(file, kHead); }
  CHECK_FALSE(fs::exists(file));
}

TEST_CASE("firn plan takes the paths of a path file with material, kind, height and tool") {
  const std::vector<LayerPaths> all = layers();
  const fs::path file = scratch("plan.paths");
  const std::vector<std::byte> whole = written(file, all);
  std::vector<InputPath> paths;
  read_paths(file, [&](InputPath&& p) { paths.push_back(std::move(p)); });
  REQUIRE(paths.size() == 27);
  const InputPath& p = paths[10];  // second of layer 2
  CHECK(p.number == 11);
  CHECK(p.place == file.string() + ": layer 2, path 2");
  CHECK(p.tool == "scaffold");
  CHECK(p.path.layer == 2);
  CHECK(p.path.material == 1);
  CHECK(p.path.kind == PathKind::kFill);
  CHECK(p.path.width_mm == 1.5);
  CHECK(p.path.z_mm == 0.5);
  CHECK(paths[3].tool == "laser");
  REQUIRE(p.path.points.size() == all[1].lines[1].size());
  CHECK(p.path.points[0].x_mm == all[1].lines[1][0].x * geometry::kMmPerUnit);

  std::ofstream(scratch("torn.paths"), std::ios::binary)
      .write(reinterpret_cast<const char*>(whole.data()), std::streamsize(whole.size() / 2));
  CHECK_THROWS_WITH(read_paths(scratch("torn.paths"), [](InputPath&&) {}),
                    Catch::Contains("torn.paths: byte "));
  CHECK_THROWS_AS(read_paths(scratch("none.paths"), [](InputPath&&) {}), UsageError);
}
