// Measures the accuracy of `firn calibrate` on planted offsets of the second nozzle, on the independent
// plant: rms error, bias, the standard error that it reports, coverage of its 95 % intervals.
//   registration_accuracy [SEEDS] [KEY=VALUE ...]
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "config/include.h"
#include "core/control/registration.h"
#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "estimators/registration/nozzle_offset.h"
#include "firn/height_map_t.hpp"
#include "lcmtypes/convert.h"
#include "print/inputs/targets.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "tests/bench/bench.h"

namespace firn::bench::registration_accuracy {

using namespace firn;

namespace {

registration::NozzleOffset measured(const Experiment& e) {
  const Blobs inputs = make_inputs(full_product(), e, "");
  HeightMap bare, last;
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    height_map_t m{};
    if (channel == channels::kHeightMap.name && m.decode(bytes.data(), 0, int(bytes.size())) >= 0)
      (m.layer ? last : bare) = height_of(m);
  };
  print_in_memory(full_product(), e, inputs, options);
  std::vector<registration::MarkSite> sites;
  const Mask mask = mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
  for (const control::Mark& m : control::registration_marks(mask, e.control.registration.spacing_cells))
    sites.push_back({e.grid.x_mm(m.i), e.grid.y_mm(m.j), m.material});
  return registration::measure_offset(bare, last, sites);
}

}  // namespace

FIRN_BENCH(registration_accuracy) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 200;
  const std::vector<std::string> settings(argv + std::min(argc, 2), argv + argc);
  double square = 0.0, sum = 0.0, variance = 0.0, worst = 0.0;
  int covered = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    Experiment e = load_experiment("experiments/registration.toml", settings);
    RandomStream random(std::uint64_t(seed), Purpose::kTest);
    const double planted[2] = {0.8 * (random.uniform() - 0.5), 0.8 * (random.uniform() - 0.5)};
    e.plant.seed = std::uint64_t(seed);
    e.plant.nozzle_b_x_mm = e.jet_b.offset_x_mm + planted[0];
    e.plant.nozzle_b_y_mm = e.jet_b.offset_y_mm + planted[1];
    const registration::NozzleOffset o = measured(e);
    for (const int axis : {0, 1}) {
      const registration::Interval& i = axis ? o.y : o.x;
      const double error = i.value_mm - planted[axis];
      square += error * error;
      sum += error;
      variance += i.sigma_mm * i.sigma_mm;
      worst = std::max(worst, std::abs(error));
      covered += std::abs(error) <= i.ci95_half_width_mm;
    }
  }
  const double n = 2.0 * seeds;
  std::printf(
      "%d seeds, two axes: rms error %.2f um, bias %.2f um, worst %.2f um, reported sigma %.2f um, coverage "
      "%.3f\n",
      seeds, 1e3 * std::sqrt(square / n), 1e3 * sum / n, 1e3 * worst, 1e3 * std::sqrt(variance / n),
      covered / n);
  return 0;
}

}  // namespace firn::bench::registration_accuracy
