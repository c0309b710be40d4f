// Instances of 100 x 100: layers against the best known ones and against the bound; and the long run that
// found these.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <vector>

#include "core/control/mpc/bound/bound.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "core/grid/npy.h"
#include "files/digest.h"
#include "files/json.h"
#include "tests/bench/mpc_instances.h"
#include "tests/bench/mpc_tables.h"

namespace firn::bench {
namespace {

using namespace firn::control::mpc;

struct Timed {
  double um = 0.0, seconds = 0.0;
};

Timed timed_layer(const control::Setup& setup, const HeightMap& h, const LayerSolverOptions& o) {
  std::vector<double> seconds;
  Timed t;
  for (int n = 0; n < 5; ++n) {
    const double start = thread_cpu_s();
    LayerProblem problem(setup, h, {});
    problem.set_drops(DropletPattern(setup.grid, 1));
    solve_layer(problem, o, serially);
    seconds.push_back(thread_cpu_s() - start);
    t.um = mean_error_um(setup, h, problem.drops(setup.grid));
  }
  std::sort(seconds.begin(), seconds.end());
  t.seconds = seconds[seconds.size() / 2];
  return t;
}

void write(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

// Betters `best` from every height of the strips, rows and columns exchanged too.
void better(const control::Setup& setup, const HeightMap& h, int sweeps, DropletPattern& best) {
  for (int round = 0; round < 2; ++round)
    for (const bool turned : {false, true}) {
      const control::Setup s = turned ? transposed(setup) : setup;
      for (int rows = 1; rows <= 4; ++rows) {
        LayerProblem problem(s, turned ? transposed(h) : h, {});
        problem.set_drops(turned ? transposed(best) : best);
        solve_layer(problem, {4, rows, rows < 4 ? sweeps : sweeps / 4, 2e-7}, serially);
        const DropletPattern u = problem.drops(s.grid);
        best = turned ? transposed(u) : u;
      }
    }
}

}  // namespace

int print_layers(const std::string& folder) {
  const auto table = nlohmann::json::parse(instance_bytes(folder, "best.json"));
  const control::Setup setup = setup_of(100);
  std::printf("             best known | 1 sweep, m = 2         | 16 sweeps, m = 2        | bound, m = 2\n");
  for (const char* name : kInstances) {
    const HeightMap h = read_instance(folder, name);
    const double best = table[name]["best_um"];
    const Timed quick = timed_layer(setup, h, {2, 2, 1, 1e-6}),
                slow = timed_layer(setup, h, {3, 2, 16, 1e-6});
    const double start = thread_cpu_s();
    const LowerBound b = lower_bound(setup, h, {}, 1e-3 * best * double(h.size()), {2, 60, 1e-6}, serially);
    const double bound = 1e3 * b.total_mm / double(h.size());
    std::printf(
        "%-8s %9.6f um | %.6f +%.3f %% %5.1f ms | %.6f +%.3f %% %5.0f ms | %.6f um, gap %.4f %%, %2d sweeps, "
        "%.2f s\n",
        name, best, quick.um, 100.0 * (quick.um / best - 1.0), 1e3 * quick.seconds, slow.um,
        100.0 * (slow.um / best - 1.0), 1e3 * slow.seconds, bound, 100.0 * (best - bound) / best, b.sweeps,
        thread_cpu_s() - start);
  }
  return 0;
}

int search_best(const std::string& folder, int sweeps) {
  const control::Setup setup = setup_of(100);
  const std::filesystem::path at = folder;
  nlohmann::ordered_json table;
  const auto target = float32_npy(setup.target);
  write(at / "target.npy", target);
  table["target"]["sha256"] = sha256_hex(target);
  for (const char* name : kInstances) {
    const HeightMap h = make_instance(name);
    const auto bytes = float32_npy(h);
    write(at / (std::string(name) + ".npy"), bytes);
    DropletPattern best(setup.grid, 1);
    if (std::filesystem::exists(at / "best" / (std::string(name) + ".npy")))
      best = best_known(folder, name);  // goes on from it
    better(setup, h, sweeps, best);
    const double um = mean_error_um(setup, h, best);
    const LowerBound b = lower_bound(setup, h, {}, 1e-3 * um * double(h.size()), {4, sweeps, 2e-7}, serially);
    const double bound_um = 1e3 * b.total_mm / double(h.size());
    const auto layer = to_npy(best);
    write(at / "best" / (std::string(name) + ".npy"), layer);
    table[name] = {{"sha256", sha256_hex(bytes)},
                   {"best_sha256", sha256_hex(layer)},
                   {"best_um", um},
                   {"droplets", best.total()},
                   {"bound_um", bound_um},
                   {"bound_rows", b.rows},
                   {"bound_sweeps", b.sweeps}};
    std::printf("%-8s %.6f um, bound %.6f um, gap %.4f %%\n", name, um, bound_um,
                100.0 * (um - bound_um) / um);
    std::fflush(stdout);
  }
  const std::string text = table.dump(2) + "\n";
  write(at / "best.json", std::as_bytes(std::span(text)));
  return 0;
}

}  // namespace firn::bench
