#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "config/error.h"
#include "config/include.h"
#include "print/inputs/geometry_input.h"
#include "print/labs/print_labs.h"
#include "tests/support/mesh_samples.h"

using namespace firn;
namespace fs = std::filesystem;

namespace {

Experiment block() {
  Experiment e;
  e.grid = {12, 10, 0.25, 0.25, 0.0, 0.0};
  e.part.shape = ShapeSpec{};
  e.part.shape.kind = "cuboid";
  e.part.shape.width_mm = 3.0;
  e.part.shape.depth_mm = 2.5;
  e.part.shape.height_mm = 0.1;
  return e;
}

fs::path fresh_folder(const char* name) {
  const fs::path folder = fs::path(FIRN_BINARY_DIR) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

}  // namespace

TEST_CASE("One ink has no geometry among its inputs, two inks have one that reads back") {
  Experiment e = block();
  for (const Blob& b : make_inputs(e, "")) CHECK(b.role != "geometry");
  e.geometry.solid.kind = "ellipsoid";
  e.geometry.solid.outer_diameter_mm = 2.0;
  e.geometry.solid.height_mm = 0.06;
  e.geometry.solid.centre_z_mm = 0.05;
  const Geometry g = geometry_from_bytes(blob(make_inputs(e, ""), "geometry").bytes, e.grid, "geometry");
  CHECK(g.height_mm() == 0.1);
  CHECK(g.at(e.grid.index(5, 5), 0.05) == Material::kA);
  CHECK(g.at(e.grid.index(5, 5), 0.01) == Material::kB);
  CHECK(g.at(e.grid.index(0, 0), 0.05) == Material::kB);
}

TEST_CASE("A folder of pictures becomes layers in the order of their names, white being the object") {
  const fs::path folder = fresh_folder("test-geometry-images");
  const GridSpec grid = block().grid;
  for (int layer = 0; layer < 3; ++layer) {
    cv::Mat image = cv::Mat::zeros(grid.ny, grid.nx, CV_8U);
    image.at<std::uint8_t>(grid.ny - 1, layer) = 255;  // the picture's last row is y = 0
    image.at<std::uint8_t>(0, 0) = 120;                // less than half white
    cv::imwrite((folder / ("layer-" + std::to_string(layer) + ".png")).string(), image);
  }
  Experiment e = block();
  e.geometry.solid.kind = "images";
  e.geometry.images = "test-geometry-images";
  e.geometry.image_pitch_z_mm = 0.02;
  const Geometry g =
      geometry_from_bytes(blob(make_inputs(e, folder.parent_path()), "geometry").bytes, e.grid, "geometry");
  for (int i = 0; i < 3; ++i) {
    REQUIRE(g.spans(grid.index(i, 0)).size() == 1);
    CHECK(g.spans(grid.index(i, 0))[0].from_mm == Approx(0.02 * i).margin(1e-7));
    CHECK(g.spans(grid.index(i, 0))[0].to_mm == Approx(0.02 * (i + 1)).margin(1e-7));
  }
  CHECK(g.spans(grid.index(3, 0)).empty());
  CHECK(g.spans(grid.index(0, grid.ny - 1)).empty());
  fs::remove_all(folder);
}

TEST_CASE("A mesh in a file becomes the columns inside it, in the middle of the grid") {
  const fs::path folder = fresh_folder("test-geometry-mesh");
  const auto bytes = test::mesh_bytes::binary_stl(test::prism(
      4, 1.0f, 7.0f, 7.0f, [](std::uint32_t) { return std::sqrt(0.5); }));  // 1 mm square on its tip
  std::ofstream(folder / "square.stl", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  Experiment e = block();
  e.geometry.solid.kind = "mesh";
  e.geometry.mesh = "square.stl";
  e.geometry.mesh_scale_z = 0.04;
  e.geometry.mesh_z_mm = 0.02;
  const Geometry g = geometry_from_bytes(blob(make_inputs(e, folder), "geometry").bytes, e.grid, "geometry");
  std::size_t inside = 0;
  for (std::size_t c = 0; c < e.grid.size(); ++c) {
    const double x = std::abs(e.grid.x_mm(int(c) % e.grid.nx) - 1.375),
                 y = std::abs(e.grid.y_mm(int(c) / e.grid.nx) - 1.125);
    REQUIRE(g.spans(c).size() == (x + y < std::sqrt(0.5) ? 1u : 0u));
    if (g.spans(c).empty()) continue;
    ++inside;
    CHECK(g.spans(c)[0].from_mm == Approx(0.02).margin(1e-9));
    CHECK(g.spans(c)[0].to_mm == Approx(0.06).margin(1e-9));
  }
  CHECK(inside == 12);
  e.geometry.mesh = "none.stl";
  CHECK_THROWS_WITH(make_inputs(e, folder), Catch::Contains("geometry.mesh"));
  fs::remove_all(folder);
}

TEST_CASE("A geometry that cannot be made is refused by file and key") {
  Experiment e = block();
  e.geometry.solid.kind = "pipe";
  e.geometry.solid.outer_diameter_mm = 2.0;
  CHECK_THROWS_WITH(make_inputs(e, ""), Catch::Contains("inner_diameter_mm"));
  e.geometry.solid = {};
  e.geometry.solid.kind = "ellipsoid";
  e.geometry.solid.outer_diameter_mm = 2.0;
  e.geometry.solid.height_mm = 0.02;
  e.geometry.solid.centre_z_mm = 5.0;
  CHECK_THROWS_WITH(make_inputs(e, ""), Catch::Contains("no part of the object"));
  e.geometry.solid.kind = "images";
  e.geometry.images = "no-such-folder";
  CHECK_THROWS_WITH(make_inputs(e, ""),
                    Catch::Contains("geometry.images") && Catch::Contains("no such folder"));
  const fs::path folder = fresh_folder("test-geometry-empty");
  e.geometry.images = folder.string();
  CHECK_THROWS_WITH(make_inputs(e, ""), Catch::Contains("no *.png"));
  cv::imwrite((folder / "a.png").string(), cv::Mat::zeros(4, 4, CV_8UC3));
  CHECK_THROWS_WITH(make_inputs(e, ""), Catch::Contains("a.png") && Catch::Contains("must be grey"));
  fs::remove_all(folder);
}
