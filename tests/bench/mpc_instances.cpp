#include "tests/bench/mpc_instances.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <vector>

#include "core/control/mpc/mpc.h"
#include "core/grid/npy.h"
#include "core/grid/random.h"

namespace firn::bench {
namespace {

// Layers printed by the greedy MPC until less than one layer is missing on the average.
HeightMap printed(const control::Setup& setup, std::uint64_t seed) {
  const GridSpec& g = setup.grid;
  HeightMap height(g);
  deposition::HeightChange<1> model(g, deposition::stencil_of(setup.model), setup.border);
  control::Mpc mpc(setup, {});
  std::vector<deposition::Stencil<1>> droplets(g.size());
  for (int layer = 0;; ++layer) {
    double missing_mm = 0.0;
    for (const double h : height.cells) missing_mm += kTarget_mm - h;
    if (missing_mm < setup.model.layer_height_mm() * double(g.size())) return height;
    RandomStream random(seed, Purpose::kInstance, std::uint32_t(layer));
    for (auto& d : droplets) {
      const double size = random.uniform(0.65, 1.35);
      d = deposition::stencil_of(
          {size * setup.model.h1_mm, size * setup.model.h2_mm, size * setup.model.h3_mm});
    }
    const control::Decision d = mpc.decide({height, layer, 0, 0.0});
    if (d.drops.total() == 0) return height;
    model.step(height.data(), d.drops.data(), 0, droplets);
  }
}

}  // namespace

control::Setup setup_of(int n) {
  const GridSpec g{n, n};
  return {g, HeightMap(g, kTarget_mm), Mask(g, 1), {}, deposition::Border::kLose, 1};
}

HeightMap make_instance(const std::string& name, int n, std::uint64_t seed) {
  const control::Setup setup = setup_of(n);
  HeightMap h(setup.grid);
  RandomStream random(seed, Purpose::kInstance);
  if (name == "loop") {
    h = printed(setup, seed);
  } else {
    for (std::size_t c = 0; c < h.size(); ++c) {
      double short_mm = 0.0;
      if (name == "half3.8")
        short_mm = 0.0038;
      else if (name == "half2.2")
        short_mm = 0.0022;
      else if (name == "ramp")
        short_mm = 0.0076 * double(c % std::size_t(n)) / double(n - 1);
      else if (name == "rough")
        short_mm = random.uniform(0.0028, 0.0048);
      else if (name == "uniform")
        short_mm = random.uniform(0.0, 0.0076);
      else
        throw std::invalid_argument("no instance '" + name + "'");
      h.cells[c] = kTarget_mm - short_mm;
    }
  }
  for (double& x : h.cells) x = float(x);
  return h;
}

std::vector<std::byte> instance_bytes(const std::string& folder, const std::string& file) {
  const std::string path = folder + "/" + file;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be read");
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
  return {first, first + bytes.size()};
}

HeightMap read_instance(const std::string& folder, const std::string& name) {
  const auto bytes = instance_bytes(folder, name + ".npy");
  const NpyShape shape = npy_shape(bytes, name);
  return height_map_from_npy(bytes, {shape.nx, shape.ny}, name);
}

DropletPattern best_known(const std::string& folder, const std::string& name) {
  const auto bytes = instance_bytes(folder, "best/" + name + ".npy");
  const NpyShape shape = npy_shape(bytes, name);
  const Mask drops = mask_from_npy(bytes, {shape.nx, shape.ny}, name);
  DropletPattern u(drops.spec);
  u.cells = drops.cells;
  return u;
}

std::vector<std::byte> float32_npy(const HeightMap& map) {
  std::vector<std::byte> bytes = to_npy(map);  // '<f8'; the header's length does not change
  const std::size_t head = bytes.size() - map.size() * sizeof(double);
  for (std::size_t i = 0; i + 2 < head; ++i)
    if (std::memcmp(bytes.data() + i, "<f8", 3) == 0) bytes[i + 2] = std::byte{'4'};
  bytes.resize(head + map.size() * sizeof(float));
  for (std::size_t c = 0; c < map.size(); ++c) {
    const float v = float(map.cells[c]);
    std::memcpy(bytes.data() + head + c * sizeof(float), &v, sizeof v);
  }
  return bytes;
}

double mean_error_um(const control::Setup& setup, const HeightMap& height, const DropletPattern& drops) {
  HeightMap h = height;
  deposition::HeightChange<1>(setup.grid, deposition::stencil_of(setup.model), setup.border)
      .step(h.data(), drops.data(), 0);
  double sum = 0.0;
  for (std::size_t c = 0; c < h.size(); ++c) sum += std::abs(h.cells[c] - setup.target.cells[c]);
  return 1e3 * sum / double(h.size());
}

control::Setup transposed(const control::Setup& setup) {
  control::Setup t = setup;
  t.grid = GridSpec{setup.grid.ny, setup.grid.nx};
  t.target = transposed(setup.target);
  t.mask = transposed(setup.mask);
  return t;
}

}  // namespace firn::bench
