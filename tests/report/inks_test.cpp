// Blocks of two inks: counts against brute force, and pictures read back pixel by pixel.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>

#include "core/grid/random.h"
#include "print/folder/run_report.h"
#include "print/labs/full_product.h"
#include "report/run/block_view.h"
#include "report/run/report_data.h"
#include "report/run/report_inks.h"
#include "report/run/voxels.h"
#include "tests/report/markup.h"

using namespace firn;
using namespace firn::report;
using firn::test::Element;
using firn::test::parse_markup;
using firn::test::ReadPicture;

namespace {

using Colour = std::array<std::uint8_t, 3>;

report::VoxelBlock random_block(RandomStream& random, int nx, int ny, int nz, double object, double support) {
  report::VoxelBlock v{{nx, ny, 0.1, 0.1}, 0.02, nz, {}};
  for (int n = 0; n < nx * ny * nz; ++n) {
    const double u = random.uniform();
    v.cells.push_back(u < object ? Material::kA : u < object + support ? Material::kB : Material::kNone);
  }
  return v;
}

// Pieces of voxels that hold together by faces, by union-find: an algorithm unlike the flood that is tested.
class Pieces {
 public:
  template <class Member>
  Pieces(const report::VoxelBlock& v, Member member) : parent_(v.cells.size()) {
    std::iota(parent_.begin(), parent_.end(), std::size_t(0));
    const auto index = [&](int i, int j, int k) { return std::size_t((k * v.grid.ny + j) * v.grid.nx + i); };
    for (int k = 0; k < v.nz; ++k)
      for (int j = 0; j < v.grid.ny; ++j)
        for (int i = 0; i < v.grid.nx; ++i) {
          if (!member(v.at(i, j, k))) continue;
          if (i + 1 < v.grid.nx && member(v.at(i + 1, j, k))) join(index(i, j, k), index(i + 1, j, k));
          if (j + 1 < v.grid.ny && member(v.at(i, j + 1, k))) join(index(i, j, k), index(i, j + 1, k));
          if (k + 1 < v.nz && member(v.at(i, j, k + 1))) join(index(i, j, k), index(i, j, k + 1));
        }
  }
  std::size_t root(std::size_t n) {
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }

 private:
  void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }
  std::vector<std::size_t> parent_;
};

// Returns the colours of the legend by their names: a reader goes by the names.
std::map<std::string, Colour> legend_of(const Element& page) {
  std::map<std::string, Colour> out;
  const Element& svg = page.only("svg");
  for (std::size_t n = 0; n + 1 < svg.children.size(); ++n) {
    const Element &rect = svg.children[n], &text = svg.children[n + 1];
    if (rect.name != "rect" || text.name != "text") continue;
    unsigned r = 0, g = 0, b = 0;
    if (std::sscanf(rect.attribute("fill").c_str(), "#%02x%02x%02x", &r, &g, &b) == 3)
      out[text.text] = {std::uint8_t(r), std::uint8_t(g), std::uint8_t(b)};
  }
  return out;
}

std::string meant(Material wanted, Material printed) {
  if (wanted == Material::kA) return printed == Material::kA ? "object" : "no object ink inside M";
  if (printed == Material::kA) return "object ink outside M";
  return printed == Material::kB ? "support" : "";
}

// The legend's name for a pixel, "" for none, "?" for a colour that it does not have.
std::string name_of(const std::map<std::string, Colour>& legend, const std::array<std::uint8_t, 4>& pixel) {
  if (pixel[3] == 0) return "";
  for (const auto& [name, c] : legend)
    if (c[0] == pixel[0] && c[1] == pixel[1] && c[2] == pixel[2]) return name;
  return "?";
}

// The hue of the legend that a shaded pixel has: shading scales all channels alike.
std::string hue_of(const std::map<std::string, Colour>& legend, const std::array<std::uint8_t, 4>& pixel) {
  std::string best = "?";
  double least = 0.03;
  for (const auto& [name, c] : legend) {
    double cross = 0.0, size_c = 0.0, size_p = 0.0;
    for (std::size_t n = 0; n < 3; ++n) {
      cross += double(c[n]) * pixel[n];
      size_c += double(c[n]) * c[n];
      size_p += double(pixel[n]) * pixel[n];
    }
    const double apart = 1.0 - cross / std::sqrt(size_c * size_p);
    if (apart >= least) continue;
    least = apart;
    best = name;
  }
  return best;
}

}  // namespace

TEST_CASE("Wrong voxels of random blocks are those that a look at every voxel and its 26 neighbours finds") {
  RandomStream random(41, Purpose::kTest);
  for (int trial = 0; trial < 30; ++trial) {
    const int nx = 1 + int(random.below(6)), ny = 1 + int(random.below(6)), nz = 1 + int(random.below(6));
    const double share = random.uniform(0.05, 0.95);
    const report::VoxelBlock wanted = random_block(random, nx, ny, nz, share, 1.0 - share),
                             printed = random_block(random, nx, ny, nz, share, 0.3);
    report::WrongVoxels want;
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          std::set<bool> kinds;
          for (int n = 0; n < 27; ++n) {
            const int a = i + n % 3 - 1, b = j + n / 3 % 3 - 1, c = k + n / 9 - 1;
            if (a < 0 || b < 0 || c < 0 || a >= nx || b >= ny || c >= nz) continue;
            kinds.insert(wanted.at(a, b, c) == Material::kA);
          }
          const bool inside = wanted.at(i, j, k) == Material::kA, boundary = kinds.size() == 2;
          const bool wrong = inside != (printed.at(i, j, k) == Material::kA);
          want.object += inside && !boundary;
          want.object_boundary += inside && boundary;
          want.inside += wrong && inside && !boundary;
          want.outside += wrong && !inside && !boundary;
          want.boundary_inside += wrong && inside && boundary;
          want.boundary_outside += wrong && !inside && boundary;
        }
    const report::WrongVoxels got = report::count_wrong(wanted, printed);
    CHECK(got.object == want.object);
    CHECK(got.object_boundary == want.object_boundary);
    CHECK(got.inside == want.inside);
    CHECK(got.outside == want.outside);
    CHECK(got.boundary_inside == want.boundary_inside);
    CHECK(got.boundary_outside == want.boundary_outside);
  }
}

TEST_CASE("Washing random blocks agrees with pieces found by union-find") {
  RandomStream random(42, Purpose::kTest);
  for (int trial = 0; trial < 40; ++trial) {
    const int nx = 1 + int(random.below(7)), ny = 1 + int(random.below(7)), nz = 1 + int(random.below(7));
    const report::VoxelBlock v =
        random_block(random, nx, ny, nz, random.uniform(0.1, 0.9), random.uniform(0.0, 0.3));
    Pieces object(v, [](Material m) { return m == Material::kA; }),
        rest(v, [](Material m) { return m != Material::kA; });
    std::map<std::size_t, std::int64_t> sizes;
    std::set<std::size_t> open;
    report::Washed want;
    const auto each = [&](auto use) {
      for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
          for (int i = 0; i < nx; ++i) use(i, j, k, std::size_t((k * ny + j) * nx + i));
    };
    each([&](int i, int j, int k, std::size_t n) {
      if (v.cells[n] == Material::kA)
        want.largest_piece = std::max(want.largest_piece, ++sizes[object.root(n)]);
      const bool side = i == 0 || j == 0 || i + 1 == nx || j + 1 == ny || k + 1 == nz;
      if (v.cells[n] != Material::kA && side) open.insert(rest.root(n));
    });
    each([&](int, int, int, std::size_t n) {
      want.object += v.cells[n] == Material::kA;
      want.support += v.cells[n] == Material::kB;
      want.support_shut_in += v.cells[n] == Material::kB && !open.contains(rest.root(n));
    });
    const report::Washed got = report::wash(v);
    CAPTURE(trial, nx, ny, nz);
    CHECK(got.object == want.object);
    CHECK(got.largest_piece == want.largest_piece);
    CHECK(got.support == want.support);
    CHECK(got.support_shut_in == want.support_shut_in);
  }
}

TEST_CASE("Voxels of printed ink keep its volume to half a voxel a column") {
  RandomStream random(43, Purpose::kTest);
  const GridSpec grid{8, 8, 0.1, 0.1};
  MaterialColumns columns(grid);
  std::vector<double> object(grid.size(), 0.0);
  for (std::size_t c = 0; c < grid.size(); ++c)
    for (int layer = 0; layer < 6; ++layer) {
      const double thick = random.uniform(0.05, 0.2);
      const bool a = layer % 2 == int(c % 2);
      columns.add(c, thick, a ? Material::kA : Material::kB);
      if (a) object[c] += thick;
    }
  constexpr double kSlice = 0.002;
  const report::VoxelBlock v = report::voxels_of(columns, kSlice, 700);
  for (std::size_t c = 0; c < grid.size(); ++c) {
    double filled = 0.0;
    for (int k = 0; k < v.nz; ++k)
      filled += kSlice * (v.cells[std::size_t(k) * grid.size() + c] == Material::kA);
    CHECK(filled == Approx(object[c]).margin(3.5 * kSlice));  // half a slice at each change of ink
  }
}

TEST_CASE("Sections show every voxel of their plane in the legend's colour for what it is") {
  RandomStream random(44, Purpose::kTest);
  const report::VoxelBlock wanted = random_block(random, 9, 7, 5, 0.4, 0.6),
                           printed = random_block(random, 9, 7, 5, 0.4, 0.4);
  const int section = 6;
  const Element page = parse_markup(
      report::section_view(wanted, {{"wanted", &wanted}, {"printed", &printed}}, section, "inks"));
  const auto legend = legend_of(page);
  REQUIRE(legend.size() == 4);
  const auto images = page.all("image");
  REQUIRE(images.size() == 4);
  for (std::size_t row = 0; row < 2; ++row) {
    const report::VoxelBlock& block = row == 0 ? wanted : printed;
    const ReadPicture along = test::picture_of(*images[2 * row]),
                      across = test::picture_of(*images[2 * row + 1]);
    REQUIRE(along.width == 9);
    REQUIRE(across.width == 7);
    for (int k = 0; k < 5; ++k) {
      for (int i = 0; i < 9; ++i)
        CHECK(name_of(legend, along.at(i, 4 - k)) == meant(wanted.at(i, 3, k), block.at(i, 3, k)));
      for (int j = 0; j < 7; ++j)
        CHECK(name_of(legend, across.at(j, 4 - k)) ==
              meant(wanted.at(section, j, k), block.at(section, j, k)));
    }
  }
}

TEST_CASE("The scale of z beside a section is the block's height in micrometres") {
  RandomStream random(45, Purpose::kTest);
  const report::VoxelBlock block = random_block(random, 6, 6, 10, 0.5, 0.5);
  const Element page = parse_markup(report::section_view(block, {{"a", &block}}, 2, "inks"));
  const Element& image = *page.all("image").at(0);
  const test::ReadAxis z = test::y_axis_of(page);
  CHECK(z.value(image.at("y")) == Approx(10 * 0.02 * 1e3));
  CHECK(z.value(image.at("y") + image.at("height")) == Approx(0.0).margin(0.5));
  CHECK(image.at("width") / 6 == Approx(image.at("height") / 10).margin(0.02));  // square voxels
  CHECK(report::z_stretch(block) == Approx(0.1 / 0.02));
}

TEST_CASE("A printed block that is lower than the wanted one is air in its sections where ink lacks") {
  const report::VoxelBlock wanted{{3, 3, 0.1, 0.1}, 0.1, 4, std::vector<Material>(36, Material::kA)},
      low{{3, 3, 0.1, 0.1}, 0.1, 2, std::vector<Material>(18, Material::kA)};
  const Element page = parse_markup(report::section_view(wanted, {{"low", &low}}, 1, "inks"));
  const auto legend = legend_of(page);
  const ReadPicture p = test::picture_of(*page.all("image").at(0));
  for (int i = 0; i < 3; ++i) {
    CHECK(name_of(legend, p.at(i, 0)) == "no object ink inside M");
    CHECK(name_of(legend, p.at(i, 3)) == "object");
  }
}

TEST_CASE(
    "The view of a block shows three faces of a cube, its top the lightest, and nothing of an empty block") {
  const GridSpec grid{8, 8, 0.1, 0.1};
  const report::VoxelBlock cube{grid, 0.1, 8, std::vector<Material>(512, Material::kA)},
      none{grid, 0.1, 8, std::vector<Material>(512, Material::kNone)};
  const ReadPicture p =
      test::picture_of(parse_markup(report::block_view(cube, cube, {}, "cube")).only("image"));
  std::map<std::array<std::uint8_t, 4>, int> colours;
  for (const auto& c : p.pixels)
    if (c[3]) ++colours[c];
  REQUIRE(colours.size() == 3);
  const auto lightest = colours.rbegin()->first;
  for (const auto& [c, count] : colours) CHECK(c[2] <= lightest[2]);
  int first_row = 0, last_row = 0;
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      if (p.at(x, y) != lightest) continue;
      if (first_row == 0) first_row = y + 1;
      last_row = y + 1;
    }
  CHECK(first_row == 1);
  CHECK(last_row < p.height);
  const ReadPicture empty =
      test::picture_of(parse_markup(report::block_view(none, none, {}, "none")).only("image"));
  CHECK(empty.pixels.size() == 1);
  CHECK(empty.at(0, 0)[3] == 0);
}

TEST_CASE("The shares of a cube's faces in its picture are the cosines of the angles of view") {
  const GridSpec grid{20, 20, 0.1, 0.1};
  const report::VoxelBlock cube{grid, 0.1, 20, std::vector<Material>(8000, Material::kA)};
  const ReadPicture p =
      test::picture_of(parse_markup(report::block_view(cube, cube, {}, "cube")).only("image"));
  std::map<std::array<std::uint8_t, 4>, double> count;
  double all = 0.0;
  for (const auto& c : p.pixels)
    if (c[3]) {
      count[c] += 1.0;
      all += 1.0;
    }
  REQUIRE(count.size() == 3);
  // Seen from (s cd, -c cd, sd): each face shows in proportion to its part of that direction.
  const double s = std::sin(0.62), c = std::cos(0.62), down = std::sin(0.60), flat = std::cos(0.60);
  std::vector<double> wanted{s * flat, c * flat, down}, got;
  const double sum = wanted[0] + wanted[1] + wanted[2];
  for (double& w : wanted) w /= sum;
  for (const auto& [colour, n] : count) got.push_back(n / all);
  std::sort(wanted.begin(), wanted.end());
  std::sort(got.begin(), got.end());
  for (std::size_t n = 0; n < 3; ++n) CHECK(got[n] == Approx(wanted[n]).margin(0.01));
}

TEST_CASE("Object ink outside M stands out in the view, and support shows only where it is asked for") {
  const GridSpec grid{6, 6, 0.1, 0.1};
  report::VoxelBlock wanted{grid, 0.1, 6, std::vector<Material>(216, Material::kB)};
  report::VoxelBlock printed = wanted;
  for (std::size_t n = 0; n < 72; ++n) wanted.cells[n] = printed.cells[n] = Material::kA;
  printed.cells[5 * 36 + grid.index(3, 3)] = Material::kA;  // on top, not wanted
  const auto hues = [&](bool support) {
    report::BlockViewOptions o;
    o.support = support;
    const Element page = parse_markup(report::block_view(wanted, printed, o, "b"));
    const auto legend = legend_of(page);
    std::set<std::string> out;
    for (const auto& c : test::picture_of(page.only("image")).pixels)
      if (c[3]) out.insert(hue_of(legend, c));
    return out;
  };
  CHECK(hues(false) == std::set<std::string>{"object", "object ink outside M"});
  CHECK(hues(true) == std::set<std::string>{"object", "object ink outside M", "support"});
}

TEST_CASE("Ink of a recorded run is wanted in the whole part, and planned nowhere beside it") {
  const report::RunData run = run_data(
      full_product(), std::filesystem::path(FIRN_SOURCE_DIR) / "tests" / "replay" / "golden" / "v2-two-inks");
  REQUIRE(run.inks);
  REQUIRE(!run.inks->layers.empty());
  for (const report::InkLayer& l : run.inks->layers)
    for (std::size_t c = 0; c < l.wanted.size(); ++c) {
      CHECK((l.wanted.of(c) != Material::kNone) == (run.mask.cells[c] != 0));
      if (l.planned.of(c) != Material::kNone) CHECK(run.mask.cells[c] != 0);
    }
}

TEST_CASE("The columns of a recorded block end at the surface that was measured last") {
  const report::RunData run = run_data(
      full_product(), std::filesystem::path(FIRN_SOURCE_DIR) / "tests" / "replay" / "golden" / "v2-two-inks");
  REQUIRE(run.inks);
  const report::InkLayer& last = run.inks->layers.back();
  int cells = 0;
  for (std::size_t c = 0; c < run.mask.size(); ++c) {
    if (last.planned.of(c) == Material::kNone || !std::isfinite(run.height.cells[c])) continue;
    const double top = run.inks->printed.top_mm(c);
    CHECK(top >= run.height.cells[c] - 1e-6);  // a surface that sank takes no ink away
    ++cells;
  }
  CHECK(cells > 0);
}

TEST_CASE("The page's count of cells against the mask is that of the layer's own maps") {
  const report::RunData run = run_data(
      full_product(), std::filesystem::path(FIRN_SOURCE_DIR) / "tests" / "replay" / "golden" / "v2-two-inks");
  report::InkData data = *run.inks;
  report::InkLayer& layer = data.layers.front();
  int object = 0, support = 0, against = 0;
  RandomStream random(46, Purpose::kTest);
  for (std::size_t c = 0; c < layer.planned.size(); ++c) {
    layer.planned.set(c, Material(random.below(3)));
    const Material m = layer.planned.of(c);
    object += m == Material::kA;
    support += m == Material::kB;
    against += m != Material::kNone && m != layer.wanted.of(c);
  }
  data.layers.resize(1);
  const Element page = parse_markup("<div>" + report::ink_sections({{"run <1>", &data}}) + "</div>");
  const std::string caption = page.all("figcaption").at(0)->text;
  CAPTURE(caption);
  CHECK(caption.find(": " + std::to_string(object) + " cells of object ink, " + std::to_string(support) +
                     " of support, " + std::to_string(against) + " against the mask") != std::string::npos);
  CHECK(page.all("h3").at(0)->text == "run <1>");
  CHECK(report::ink_sections({}).empty());
}

TEST_CASE("A geometry of another grid or of damaged bytes is refused before any layer is read") {
  const std::filesystem::path folder =
      std::filesystem::path(FIRN_SOURCE_DIR) / "tests" / "replay" / "golden" / "v2-two-inks";
  const runs::RunMessages messages(folder, {"HEIGHT_MAP", "LAYER_PLAN"});
  const report::RunData run = run_data(full_product(), folder);
  std::vector<std::byte> bytes = to_bytes(run.inks->geometry);
  CHECK(report::read_ink_data(messages, bytes, run.mask));
  const Mask other({run.mask.spec.nx + 1, run.mask.spec.ny, 0.1, 0.1}, 1);
  CHECK_THROWS_AS(report::read_ink_data(messages, bytes, other), std::invalid_argument);
  for (const std::size_t keep : {std::size_t(0), std::size_t(7), bytes.size() / 2, bytes.size() - 1}) {
    const std::span<const std::byte> cut(bytes.data(), keep);
    CHECK_THROWS_AS(report::read_ink_data(messages, cut, run.mask), std::invalid_argument);
  }
  bytes[0] ^= std::byte{1};
  CHECK_THROWS_AS(report::read_ink_data(messages, bytes, run.mask), std::invalid_argument);
}
