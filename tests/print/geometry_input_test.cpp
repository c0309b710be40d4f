#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "config/error.h"
#include "config/include.h"
#include "print/inputs/geometry_input.h"
#include "print/inputs/targets.h"
#include "print/labs/full_product.h"
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
  for (const Blob& b : make_inputs(full_product(), e, "")) CHECK(b.role != "geometry");
  e.geometry.solid.kind = "ellipsoid";
  e.geometry.solid.outer_diameter_mm = 2.0;
  e.geometry.solid.height_mm = 0.06;
  e.geometry.solid.centre_z_mm = 0.05;
  const Geometry g =
      geometry_from_bytes(blob(make_inputs(full_product(), e, ""), "geometry").bytes, e.grid, "geometry");
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
  const Geometry g = geometry_from_bytes(
      blob(make_inputs(full_product(), e, folder.parent_path()), "geometry").bytes, e.grid, "geometry");
  for (int i = 0; i < 3; ++i) {
    REQUIRE(g.spans(grid.index(i, 0)).size() == 1);
    CHECK(g.spans(grid.index(i, 0))[0].from_mm == Approx(0.02 * i).margin(1e-7));
    CHECK(g.spans(grid.index(i, 0))[0].to_mm == Approx(0.02 * (i + 1)).margin(1e-7));
  }
  CHECK(g.spans(grid.index(3, 0)).empty());
  CHECK(g.spans(grid.index(0, grid.ny - 1)).empty());
  fs::remove_all(folder);
}

TEST_CASE("Layers of pictures keep their size and aspect in the middle of the grid, whatever the pitch is") {
  // Pictures of 2.4 x 1.6 mm with a white disc of 0.6 mm radius at (0.9, 0.7) mm from the low corner.
  const fs::path folder = fresh_folder("test-geometry-sizes");
  cv::Mat image = cv::Mat::zeros(160, 240, CV_8U);
  for (int row = 0; row < 160; ++row)
    for (int col = 0; col < 240; ++col)
      if (std::hypot((col + 0.5) * 0.01 - 0.9, 1.6 - (row + 0.5) * 0.01 - 0.7) < 0.6)
        image.at<std::uint8_t>(row, col) = 255;
  cv::imwrite((folder / "a.png").string(), image);
  cv::imwrite((folder / "b.png").string(), cv::Mat::zeros(160, 240, CV_8U));  // a layer without object
  cv::imwrite((folder / "c.png").string(), image);
  Experiment e = block();
  e.geometry.solid.kind = "images";
  e.geometry.images = folder.string();
  e.geometry.image_pitch_z_mm = 0.02;
  for (const GridSpec spec : {GridSpec{12, 10, 0.25, 0.25, 0.0, 0.0}, GridSpec{40, 25, 0.1, 0.1, 1.0, -3.0},
                              GridSpec{30, 60, 0.2, 0.05, 0.0, 0.0}}) {
    e.grid = spec;
    for (const bool by_width : {true, false}) {
      e.part.shape.width_mm = by_width ? 2.4 : 2.9;  // of the block
      e.part.um_per_px = by_width ? 0.0 : 10.0;
      const Geometry g =
          geometry_from_bytes(blob(make_inputs(full_product(), e, ""), "geometry").bytes, spec, "geometry");
      const double x0 = 0.5 * (spec.x_mm(0) + spec.x_mm(spec.nx - 1)) - 1.2 + 0.9,
                   y0 = 0.5 * (spec.y_mm(0) + spec.y_mm(spec.ny - 1)) - 0.8 + 0.7;
      for (std::size_t c = 0; c < spec.size(); ++c) {
        const double r = std::hypot(spec.x_mm(int(c) % spec.nx) - x0, spec.y_mm(int(c) / spec.nx) - y0);
        const double slack = 0.75 * std::max(spec.pitch_x_mm, spec.pitch_y_mm);
        CAPTURE(c, r, spec.nx);
        if (r < 0.6 - slack) CHECK(g.spans(c).size() == 2);
        if (r > 0.6 + slack) CHECK(g.spans(c).empty());
      }
    }
  }
  fs::remove_all(folder);
}

TEST_CASE("A stack of pictures without one size, of different sizes or beyond the grid is refused by name") {
  const fs::path folder = fresh_folder("test-geometry-no-size");
  cv::imwrite((folder / "a.png").string(), cv::Mat(10, 12, CV_8U, cv::Scalar(255)));
  Experiment e = block();
  e.geometry.solid.kind = "images";
  e.geometry.images = folder.string();
  CHECK_NOTHROW(make_inputs(full_product(), e, ""));  // as wide as the block
  PartConfig mesh;
  mesh.shape.kind = "mesh";
  const std::vector<std::byte> bytes = read_bytes(folder / "a.png", "geometry.images");
  CHECK_THROWS_WITH(layer_pixel_size(mesh, bytes, "a.png"),
                    Catch::Contains("a.png: geometry.images") && Catch::Contains("part.um_per_px"));
  e.part.um_per_px = 260.0;
  CHECK_THROWS_WITH(make_inputs(full_product(), e, ""),
                    Catch::Contains("a.png: geometry.images") && Catch::Contains("along x"));
  e.part.um_per_px = 250.0;
  cv::imwrite((folder / "b.png").string(), cv::Mat(10, 11, CV_8U, cv::Scalar(255)));
  CHECK_THROWS_WITH(make_inputs(full_product(), e, ""),
                    Catch::Contains("b.png: geometry.images: 11 x 10 pixels") && Catch::Contains("12 x 10"));
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
  const Geometry g =
      geometry_from_bytes(blob(make_inputs(full_product(), e, folder), "geometry").bytes, e.grid, "geometry");
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
  CHECK_THROWS_WITH(make_inputs(full_product(), e, folder), Catch::Contains("geometry.mesh"));
  fs::remove_all(folder);
}

TEST_CASE("A geometry that cannot be made is refused by file and key") {
  Experiment e = block();
  e.geometry.solid.kind = "pipe";
  e.geometry.solid.outer_diameter_mm = 2.0;
  CHECK_THROWS_WITH(make_inputs(full_product(), e, ""), Catch::Contains("inner_diameter_mm"));
  e.geometry.solid = {};
  e.geometry.solid.kind = "ellipsoid";
  e.geometry.solid.outer_diameter_mm = 2.0;
  e.geometry.solid.height_mm = 0.02;
  e.geometry.solid.centre_z_mm = 5.0;
  CHECK_THROWS_WITH(make_inputs(full_product(), e, ""), Catch::Contains("no part of the object"));
  e.geometry.solid.kind = "images";
  e.geometry.images = "no-such-folder";
  CHECK_THROWS_WITH(make_inputs(full_product(), e, ""),
                    Catch::Contains("geometry.images") && Catch::Contains("no such folder"));
  const fs::path folder = fresh_folder("test-geometry-empty");
  e.geometry.images = folder.string();
  CHECK_THROWS_WITH(make_inputs(full_product(), e, ""), Catch::Contains("no *.png"));
  cv::imwrite((folder / "a.png").string(), cv::Mat::zeros(4, 4, CV_8UC3));
  CHECK_THROWS_WITH(make_inputs(full_product(), e, ""),
                    Catch::Contains("a.png") && Catch::Contains("must be grey"));
  fs::remove_all(folder);
}
