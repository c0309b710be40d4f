#include "cli/decide_command.h"

#include <time.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/run_folder.h"
#include "cli/targets.h"
#include "config/experiment.h"
#include "core/control/mpc/bound.h"
#include "core/grid/npy.h"
#include "procs/controller/node.h"

namespace firn {
namespace {

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

Experiment experiment_of(const DecideOptions& o, const GridSpec& grid) {
  std::vector<std::pair<std::string, std::string>> texts;
  if (!o.model.empty()) {
    const auto bytes = read_bytes(o.model, "--model");
    texts.emplace_back(o.model, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  std::vector<std::string> settings = o.overrides;
  if (o.alpha > 0.0) settings.push_back("control.mpc.alpha=" + nlohmann::json(o.alpha).dump());
  if (o.horizon > 0) settings.push_back("control.mpc.horizon=" + std::to_string(o.horizon));
  if (!o.method.empty()) settings.push_back("control.mpc.method=\"" + o.method + "\"");
  Experiment e = parse_experiment(texts, settings);
  e.grid.nx = grid.nx, e.grid.ny = grid.ny;
  return e;
}

void write_npy(const std::string& path, const std::vector<std::byte>& bytes) {
  write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

// The multipliers as an array of 2 (strips - 1) rows.
HeightMap multipliers_of(const control::mpc::LowerBound& b, int nx) {
  HeightMap m(GridSpec{nx, std::max(1, int(b.multipliers.size()) / nx)});
  for (std::size_t i = 0; i < b.multipliers.size(); ++i) m.cells[i] = b.multipliers[i];
  return m;
}

}  // namespace

int run_decide(const DecideOptions& o) {
  const auto height_bytes = read_bytes(o.height, "--height");
  const NpyShape shape = npy_shape(height_bytes, o.height);
  const GridSpec named{shape.nx, shape.ny};
  const Experiment e = experiment_of(o, named);
  const HeightMap height = height_map_from_npy(height_bytes, e.grid, o.height);
  const HeightMap target = height_map_from_npy(read_bytes(o.target, "--target"), e.grid, o.target);
  const Mask mask = o.mask.empty() ? Mask(e.grid, 1) : mask_from_npy(read_bytes(o.mask, "--mask"), e.grid, o.mask);
  const bool provable = e.control.scheme == "mpc" && e.control.mpc.alpha.front().alpha == 1.0 && e.control.mpc.horizon == 1 &&
                        e.control.mpc.max_drops == 1;
  if (o.bound && !provable)
    throw UsageError("--bound: a bound is proved for scheme mpc, alpha = 1, horizon = 1 and one droplet per cell only");
  const control::Setup setup = control_setup(e, target, mask);
  const auto scheme = control::make_controller(setup, control_options(e));

  const double start = cpu_s();
  const control::Decision d = scheme->decide({height, 0, 0, 0.0});
  const double decide_s = cpu_s() - start;
  const double objective = d.kind == control::Decision::Kind::kPrint ? d.objective_mm : d.objective_none_mm;
  nlohmann::ordered_json out{{"decision", d.kind == control::Decision::Kind::kPrint ? "print" : d.kind == control::Decision::Kind::kEnd ? "end" : "stop"},
                             {"reason", d.reason},
                             {"method", e.control.scheme == "mpc" ? e.control.mpc.method : e.control.scheme},
                             {"droplets", d.drops.total()},
                             {"objective_mm", objective},
                             {"objective_none_mm", d.objective_none_mm},
                             {"iterations", d.iterations},
                             {"cpu_s", decide_s}};
  if (o.bound) {
    control::mpc::LayerProblem problem(setup, control::known_heights({height, 0, 0, 0.0}), {});
    const double cells = double(problem.counted()), before = cpu_s();
    const auto b = control::mpc::lower_bound(problem, objective * cells, {o.bound_rows, o.bound_iterations, 1e-5},
                                             serially);
    out["lower_bound_mm"] = b.total_mm / cells;
    out["gap"] = (objective - b.total_mm / cells) / objective;
    out["bound_rows"] = b.rows;
    out["bound_iterations"] = b.iterations;
    out["bound_cpu_s"] = cpu_s() - before;
    if (!o.certificate.empty()) write_npy(o.certificate, to_npy(multipliers_of(b, e.grid.nx)));
  }
  if (!o.output.empty()) write_npy(o.output, to_npy(d.drops));
  if (o.json) {
    std::puts(out.dump(2).c_str());
    return kOk;
  }
  std::printf("%s: %s\n", out["decision"].get<std::string>().c_str(), d.reason.c_str());
  std::printf("objective       %.6f um, with %lld droplets\nprinting none   %.6f um\n", 1e3 * objective,
              static_cast<long long>(d.drops.total()), 1e3 * d.objective_none_mm);
  if (o.bound)
    std::printf("lower bound     %.6f um: at most %.3f %% better can be (strips of %d rows, %d iterations, %.2f s)\n",
                1e3 * out["lower_bound_mm"].get<double>(), 100.0 * out["gap"].get<double>(), out["bound_rows"].get<int>(),
                out["bound_iterations"].get<int>(), out["bound_cpu_s"].get<double>());
  std::printf("%lld iterations, %.4f s of processor time\n", static_cast<long long>(d.iterations), decide_s);
  return kOk;
}

}  // namespace firn
