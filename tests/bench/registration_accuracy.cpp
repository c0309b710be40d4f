// Measures the accuracy of `firn calibrate` on planted offsets of the second nozzle, on the independent
// plant: rms error, bias, the standard error that it reports, coverage of its 95 % intervals.
//   registration_accuracy [SEEDS] [KEY=VALUE ...] [-o FOLDER and a study's options]
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "config/fields.h"
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
#include "tests/bench/case_bench.h"

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
  int seeds = 200;
  std::vector<std::string> settings;
  CaseBench bench("registration_accuracy", "planted offsets of the second nozzle through firn calibrate");
  bench.options().option("SEEDS", seeds, "").show_default().within(1, 1000000);
  bench.options().option("SETTING", settings, "KEY=VALUE of the experiment");
  if (const auto code = bench.parse(argc, argv)) return *code;
  const Experiment experiment = load_experiment(FIRN_SOURCE_DIR "/experiments/registration.toml", settings);
  Cases cases{"registration_accuracy", dump(experiment), {"offset"}, {}, {}};
  for (int n = 1; n <= seeds; ++n) cases.seeds.push_back(std::uint64_t(n));
  cases.make = [&](std::size_t, std::uint64_t seed, int) {
    Experiment e = experiment;
    RandomStream random(seed, Purpose::kTest);
    const double planted[2] = {0.8 * (random.uniform() - 0.5), 0.8 * (random.uniform() - 0.5)};
    e.plant.seed = seed;
    e.plant.nozzle_b_x_mm = e.jet_b.offset_x_mm + planted[0];
    e.plant.nozzle_b_y_mm = e.jet_b.offset_y_mm + planted[1];
    const registration::NozzleOffset o = measured(e);
    std::vector<double> numbers;
    for (const int axis : {0, 1}) {
      const registration::Interval& i = axis ? o.y : o.x;
      numbers.insert(numbers.end(), {i.value_mm - planted[axis], i.sigma_mm, i.ci95_half_width_mm});
    }
    return text_of(numbers);
  };
  std::vector<std::string> words{std::to_string(seeds)};
  words.insert(words.end(), settings.begin(), settings.end());
  int code = 0;
  const auto results = bench.results(cases, words, code);
  if (!results) return code;
  double square = 0.0, sum = 0.0, variance = 0.0, worst = 0.0, n = 0.0;
  int covered = 0;
  for (std::size_t s = 0; s < results->size(); ++s) {
    const CaseBench::Result& r = (*results)[s];
    if (!r.made) {
      std::printf("seed %zu: %s\n", s + 1, r.reason.c_str());
      continue;
    }
    const std::vector<double> numbers = numbers_of(r.text);
    for (const std::size_t axis : {0, 1}) {
      const double error = numbers[3 * axis], sigma = numbers[3 * axis + 1];
      square += error * error;
      sum += error;
      variance += sigma * sigma;
      worst = std::max(worst, std::abs(error));
      covered += std::abs(error) <= numbers[3 * axis + 2];
      n += 1.0;
    }
  }
  std::printf(
      "%d seeds, two axes: rms error %.2f um, bias %.2f um, worst %.2f um, reported sigma %.2f um, coverage "
      "%.3f\n",
      seeds, 1e3 * std::sqrt(square / n), 1e3 * sum / n, 1e3 * worst, 1e3 * std::sqrt(variance / n),
      covered / n);
  return 0;
}

}  // namespace firn::bench::registration_accuracy
