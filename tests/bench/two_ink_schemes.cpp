// Voxels of the wrong ink that each scheme leaves in the pipe junction [Lu 2015, Figs. 13, 14]: the table of
// docs/algorithms/control.md. Whole lab in simulated time, experiments/pipe-junction.toml.
//   two_ink_schemes [--seed 1] [-o FOLDER and a study's options]
#include <fmt/core.h>

#include <filesystem>
#include <string>
#include <vector>

#include "config/fields.h"
#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "report/run/voxels.h"
#include "tests/bench/bench.h"
#include "tests/bench/case_bench.h"

namespace firn::bench::two_ink_schemes {

namespace {

using namespace firn;

struct Scheme {
  const char* name;
  double alpha, judge_above_layers;
};
constexpr Scheme kSchemes[] = {{"open_loop", 0.5, 0.0}, {"open_loop", 0.5, 0.5}, {"smf", 0.5, 0.0},
                               {"mpc", 1.0, 0.0},       {"mpc", 0.8, 0.0},       {"mpc", 0.5, 0.0},
                               {"mpc", 0.3, 0.0},       {"mpc", 0.5, 0.5}};

// Wrong voxels, those of them at a boundary, standard deviation of the top [um], layers.
std::vector<double> print(const Scheme& scheme, Experiment e, const std::filesystem::path& folder) {
  e.control.scheme = scheme.name;
  e.control.mpc.alpha = {{1, scheme.alpha}};
  e.geometry.judge_above_layers = scheme.judge_above_layers;
  const Blobs inputs = make_inputs(full_product(), e, folder);
  const Geometry m = geometry_from_bytes(blob(inputs, "geometry").bytes, e.grid, "geometry");
  MemoryPrintOptions options;
  options.materials = true;
  const MemoryPrintReport r = print_in_memory(full_product(), e, inputs, options);
  const double slice_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm;
  const int nz = report::slices_for(r.materials, m, slice_mm);
  const auto wrong =
      report::count_wrong(report::voxels_of(m, slice_mm, nz), report::voxels_of(r.materials, slice_mm, nz));
  return {double(wrong.wrong()), double(wrong.boundary_wrong()), 1e3 * r.error.std_mm,
          double(r.result.layers)};
}

}  // namespace

FIRN_BENCH(two_ink_schemes) {
  int seed = 1;
  CaseBench bench("two_ink_schemes", "voxels of the wrong ink that each scheme leaves in the pipe junction");
  bench.options().option("--seed", seed, "").show_default().within(1, 1000000000);
  if (const auto code = bench.parse(argc, argv)) return *code;
  const std::filesystem::path file =
      std::filesystem::path(FIRN_SOURCE_DIR) / "experiments" / "pipe-junction.toml";
  const Experiment shipped = load_experiment(file);
  Cases cases{"two_ink_schemes", dump(shipped), {}, {std::uint64_t(seed)}, {}};
  for (const Scheme& s : kSchemes)
    cases.kinds.push_back(fmt::format("{} alpha {} judged {}", s.name, s.alpha, s.judge_above_layers));
  cases.make = [&](std::size_t kind, std::uint64_t of_case, int) {
    Experiment e = shipped;
    e.plant.seed = of_case;
    return text_of(print(kSchemes[kind], std::move(e), file.parent_path()));
  };
  int code = 0;
  const auto results = bench.results(cases, {"--seed", std::to_string(seed)}, code);
  if (!results) return code;
  fmt::print("scheme     alpha judged  wrong boundary  top std [um]  layers\n");
  for (std::size_t n = 0; n < results->size(); ++n) {
    const Scheme& s = kSchemes[n];
    if (!(*results)[n].made) {
      fmt::print("{:<10} {:5.1f} {:6.1f} {}\n", s.name, s.alpha, s.judge_above_layers, (*results)[n].reason);
      code = 1;
      continue;
    }
    const std::vector<double> of = numbers_of((*results)[n].text);
    fmt::print("{:<10} {:5.1f} {:6.1f} {:6.0f} {:8.0f} {:13.1f} {:7.0f}\n", s.name, s.alpha,
               s.judge_above_layers, of[0], of[1], of[2], of[3]);
  }
  return code;
}

}  // namespace firn::bench::two_ink_schemes
