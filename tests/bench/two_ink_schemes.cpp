// Voxels of the wrong ink that each scheme leaves in the pipe junction [Lu 2015, Figs. 13, 14]: the table of
// docs/algorithms/control.md. Whole lab in simulated time, experiments/pipe-junction.toml, seed 1.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "report/run/voxels.h"
#include "tests/bench/bench.h"

namespace firn::bench::two_ink_schemes {

using namespace firn;

FIRN_BENCH(two_ink_schemes) {
  struct Case {
    const char* scheme;
    double alpha, judge_above_layers;
  };
  const std::vector<Case> cases = {{"open_loop", 0.5, 0.0}, {"open_loop", 0.5, 0.5}, {"smf", 0.5, 0.0},
                                   {"mpc", 1.0, 0.0},       {"mpc", 0.8, 0.0},       {"mpc", 0.5, 0.0},
                                   {"mpc", 0.3, 0.0},       {"mpc", 0.5, 0.5}};
  const std::filesystem::path file =
      std::filesystem::path(FIRN_SOURCE_DIR) / "experiments" / "pipe-junction.toml";
  std::printf("scheme     alpha judged  wrong boundary  top std [um]  layers\n");
  for (const Case& c : cases) {
    Experiment e = load_experiment(file);
    e.control.scheme = c.scheme;
    e.control.mpc.alpha = {{1, c.alpha}};
    e.geometry.judge_above_layers = c.judge_above_layers;
    const Blobs inputs = make_inputs(full_product(), e, file.parent_path());
    const Geometry m = geometry_from_bytes(blob(inputs, "geometry").bytes, e.grid, "geometry");
    MemoryPrintOptions options;
    options.materials = true;
    const MemoryPrintReport r = print_in_memory(full_product(), e, inputs, options);
    const double slice_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm;
    const int nz = report::slices_for(r.materials, m, slice_mm);
    const auto wrong =
        report::count_wrong(report::voxels_of(m, slice_mm, nz), report::voxels_of(r.materials, slice_mm, nz));
    std::printf("%-10s %5.1f %6.1f %6lld %8lld %13.1f %7d\n", c.scheme, c.alpha, c.judge_above_layers,
                (long long)wrong.wrong(), (long long)wrong.boundary_wrong(), r.error.std_mm * 1e3,
                r.result.layers);
  }
  return 0;
}

}  // namespace firn::bench::two_ink_schemes
