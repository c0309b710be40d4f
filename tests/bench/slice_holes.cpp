// Measures slicing of a flat plate with many round holes, and how its time grows with their number:
//   build/bench/slice_holes [HOLES [LAYERS [SEED]]] [--write FILE.stl]
// Plates with HOLES / 4, HOLES / 2 and HOLES holes (10,000) of 1.5 mm, each within 0.01 mm of the middle of a
// cell of 3 mm; layers of 0.25 mm (50); no support. --write also writes the largest plate for other slicers.
// One thread, user time.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/slice/mesh/slicer.h"
#include "core/slice/paths/path_plan.h"
#include "tests/bench/bench.h"

namespace firn::bench::slice_holes {

namespace {

using namespace firn;

constexpr float kCell_mm = 3.0f, kRadius_mm = 0.75f, kPlay_mm = 0.02f, kLayer_mm = 0.25f;
constexpr int kCorners = 24;  // of a hole; a multiple of four

using Facet = std::array<std::array<float, 3>, 3>;

// A closed surface: each cell has its own square with its hole, from z = 0 to `top`.
std::vector<Facet> plate(int side, float top, std::uint64_t seed) {
  std::vector<Facet> facets;
  RandomStream random(seed, Purpose::kTest);
  using Place = std::array<float, 2>;
  const auto at = [](Place p, float z) { return std::array<float, 3>{p[0], p[1], z}; };
  const auto floor_and_lid = [&](Place a, Place b, Place c) {
    facets.push_back({at(a, top), at(b, top), at(c, top)});
    facets.push_back({at(c, 0), at(b, 0), at(a, 0)});
  };
  const auto wall = [&](Place a, Place b) {  // material lies left
    facets.push_back({at(a, 0), at(b, 0), at(b, top)});
    facets.push_back({at(a, 0), at(b, top), at(a, top)});
  };
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const auto corner = [&](int k) {  // 0: upper right, then counter-clockwise
        return Place{float(column + (k % 4 == 0 || k % 4 == 3)) * kCell_mm,
                     float(row + (k % 4 < 2)) * kCell_mm};
      };
      const float x = (float(column) + 0.5f) * kCell_mm + float(random.uniform(-0.5, 0.5)) * kPlay_mm,
                  y = (float(row) + 0.5f) * kCell_mm + float(random.uniform(-0.5, 0.5)) * kPlay_mm;
      const auto rim = [&](int k) {
        const double turn = 2 * std::numbers::pi * (k % kCorners) / kCorners;
        return Place{x + kRadius_mm * float(std::cos(turn)), y + kRadius_mm * float(std::sin(turn))};
      };
      for (int k = 0; k < kCorners; ++k) {
        const int quarter = 4 * k / kCorners;
        floor_and_lid(corner(quarter), rim(k + 1), rim(k));
        wall(rim(k + 1), rim(k));
        if (4 * (k + 1) % kCorners == 0) floor_and_lid(corner(quarter), corner(quarter + 1), rim(k + 1));
      }
      if (row == 0) wall(corner(2), corner(3));
      if (row + 1 == side) wall(corner(0), corner(1));
      if (column == 0) wall(corner(1), corner(2));
      if (column + 1 == side) wall(corner(3), corner(0));
    }
  return facets;
}

void write_stl(const std::string& file, const std::vector<Facet>& facets) {
  std::ofstream out(file, std::ios::binary);
  const std::array<char, 80> heading{};
  const auto count = std::uint32_t(facets.size());
  out.write(heading.data(), heading.size());
  out.write(reinterpret_cast<const char*>(&count), sizeof count);
  for (const Facet& facet : facets) {
    std::array<char, 50> record{};  // 12 bytes of normal, 36 of corners, 2 of attributes
    std::memcpy(&record[12], &facet, sizeof facet);
    out.write(record.data(), record.size());
  }
  if (!out.flush()) throw std::runtime_error(file + ": cannot be written");
}

double cpu_s() { return double(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

FIRN_BENCH(slice_holes) try {
  std::vector<int> numbers;
  std::string file;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--write" && i + 1 < argc)
      file = argv[++i];
    else
      numbers.push_back(std::atoi(argv[i]));
  }
  numbers.resize(std::max<std::size_t>(numbers.size(), 3));
  const int holes = numbers[0] > 0 ? numbers[0] : 10'000, layers = numbers[1] > 0 ? numbers[1] : 50;
  const std::uint64_t seed = numbers[2] > 0 ? std::uint64_t(numbers[2]) : 1;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  double before_s = 0;
  std::size_t before_paths = 0;
  for (const int part : {4, 2, 1}) {
    const int side = int(std::lround(std::sqrt(double(holes) / part)));
    const std::vector<Facet> facets = plate(side, kLayer_mm * float(layers), seed);
    if (part == 1 && !file.empty()) write_stl(file, facets);
    const double begin_s = cpu_s();
    slice::FacetView view;
    view.soup = reinterpret_cast<const std::byte*>(facets.data());
    view.stride = sizeof(Facet);
    view.soup_facets = facets.size();
    slice::SliceOptions options;
    options.layer_height_mm = kLayer_mm;
    slice::Sliced sliced = slice::slice(view, {}, options, serially);
    const double sliced_s = cpu_s();
    slice::PathWork work;
    std::size_t paths = 0;
    double transit_mm = 0;
    for (std::size_t n = 0; n < sliced.layers.size(); ++n) {
      slice::LayerRegions regions;
      regions.layer = std::int32_t(n) + 1;
      regions.height = std::int32_t(std::lround(kLayer_mm * geometry::kUnitsPerMm));
      regions.by_material.push_back(std::move(sliced.layers[n]));
      const slice::LayerPaths planned = slice::plan_layer(regions, {}, work);
      paths += planned.info.size();
      transit_mm += slice::transit_mm(planned);
    }
    const double end_s = cpu_s();
    std::printf(
        "%6d holes, %zu facets, %zu layers: %.2f s to regions, %.2f s to paths in order; %zu paths, travel "
        "%.1f m",
        side * side, facets.size(), sliced.layers.size(), sliced_s - begin_s, end_s - sliced_s, paths,
        1e-3 * transit_mm);
    if (before_s > 0)
      std::printf("; exponent in paths %.2f",
                  std::log((end_s - sliced_s) / before_s) / std::log(double(paths) / double(before_paths)));
    std::printf("\n");
    before_s = end_s - sliced_s;
    before_paths = paths;
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s: %s\n", argv[0], e.what());
  return 1;
}

}  // namespace firn::bench::slice_holes
