#include "cli/decide_command.h"

#include <sys/resource.h>
#include <time.h>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "config/experiment.h"
#include "core/control/mpc/bound/bound.h"
#include "core/control/mpc/bound/bound_checker.h"
#include "core/control/mpc/bound/weighted_bound.h"
#include "core/control/mpc/layer/window_kernel.h"
#include "core/grid/npy.h"
#include "core/grid/outline.h"
#include "core/options/for_people.h"
#include "files/certificate_file.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/inputs/python_input.h"
#include "print/inputs/targets.h"
#include "print/progress.h"
#include "procs/controller/node.h"
#include "runs/folder/run_folder.h"
#include "runtime/thread_pool.h"
#include "studies/edge/edge_bound.h"

namespace firn {
namespace {

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

Experiment deciding_experiment(const DecideOptions& o, const GridSpec& grid) {
  std::vector<std::pair<std::string, std::string>> texts;
  if (!o.model.empty()) {
    const auto bytes = read_bytes(o.model, "--model");
    texts.emplace_back(o.model, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  std::vector<std::string> settings = o.overrides;
  if (o.alpha) settings.push_back("control.mpc.alpha=" + nlohmann::json(*o.alpha).dump());
  if (o.horizon) settings.push_back("control.mpc.horizon=" + std::to_string(*o.horizon));
  if (!o.method.empty()) {
    std::string name = o.method;
    std::ranges::replace(name, '-', '_');
    settings.push_back("control.mpc.method=\"" + name + "\"");
  }
  Experiment e = parse_experiment(texts, settings);
  if (e.geometry.solid.kind != "none")
    throw UsageError("--model: geometry.shape = \"" + e.geometry.solid.kind +
                     "\": firn decide decides layers of one ink");
  e.grid.nx = grid.nx;
  e.grid.ny = grid.ny;
  return e;
}

void write_npy(const std::string& path, const std::vector<std::byte>& bytes) {
  write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

control::Setup setup_of(const DecideOptions& o, const Experiment& e) {
  HeightMap target = height_map_from_npy(read_bytes(o.target, "--target"), e.grid, o.target);
  Mask mask = o.mask.empty() ? Mask(e.grid, 1) : mask_from_npy(read_bytes(o.mask, "--mask"), e.grid, o.mask);
  return control_setup(e, std::move(target), std::move(mask));
}

control::mpc::CellCost cost_of_layer(const Experiment& e) {
  control::mpc::CellCost cost;
  cost.outside = float(e.control.mpc.outside_price);
  return cost;
}

// Bound that the multipliers prove for any layer, by the checker that shares nothing with the solver.
std::string check_certificate(const DecideOptions& o, const Experiment& e, const HeightMap& height) {
  const control::Setup setup = setup_of(o, e);
  const int nx = setup.grid.nx, cuts = (setup.grid.ny + o.bound_rows - 1) / o.bound_rows - 1;
  const std::vector<float> m =
      certificate_from(read_bytes(o.check_certificate, "--check-certificate"), nx, o.check_certificate);
  if (m.size() != std::size_t(cuts) * std::size_t(nx) * control::mpc::kSharedPatterns)
    throw std::invalid_argument(o.check_certificate + ": strips of --bound-rows " +
                                std::to_string(o.bound_rows) + " have " + std::to_string(cuts) +
                                " cuts, the file others");
  double counted = 0.0;
  for (const auto in : setup.mask.cells) counted += in;
  const double bound_mm =
      control::mpc::certified_bound_mm(setup, height, {}, o.bound_rows, m, cost_of_layer(e)) / counted;
  if (o.json)
    return nlohmann::ordered_json{{"lower_bound_mm", bound_mm}, {"bound_rows", o.bound_rows}}.dump(2) + "\n";
  return fmt::format(
      "lower bound     {:.6f} um: no layer of at most one droplet per cell has a smaller mean error\n",
      1e3 * bound_mm);
}

// Overspill of the surface, and the least that any pattern could have at its mean error.
std::string edge_bound_of(const DecideOptions& o, const Experiment& e, const HeightMap& height) {
  const control::Setup setup = setup_of(o, e);
  const ErrorStats error = error_stats(height, setup.target, setup.mask);
  if (error.cells == 0) throw std::invalid_argument(o.height + ": no cell of the part is measured");
  const double overspill = outline_stats(height, setup.target, setup.mask).overspill;
  const double bound = edge_bound(setup.target, setup.mask, setup.model, setup.border, error.mean_abs_mm);
  constexpr double kPercent = 100.0;
  if (o.json) {
    nlohmann::ordered_json out{{"mean_abs_error_mm", error.mean_abs_mm},
                               {"edge_bound_pct", kPercent * bound}};
    out["overspill_pct"] = std::isfinite(overspill) ? nlohmann::ordered_json(kPercent * overspill) : nullptr;
    return out.dump(2) + "\n";
  }
  std::string text = fmt::format("mean error      {:.4f} um inside the part\n", 1e3 * error.mean_abs_mm);
  if (std::isfinite(overspill)) text += fmt::format("overspill       {:.3f} %\n", kPercent * overspill);
  return text +
         fmt::format("lower bound     {:.3f} %: no pattern of this model has less at this mean error\n",
                     kPercent * bound);
}

void check_bound_options(const DecideOptions& o, const Experiment& e) {
  const control::MpcOptions& m = e.control.mpc;
  if (e.control.scheme != "mpc" || m.horizon != 1 || m.max_drops != 1 ||
      m.error != control::ErrorKind::kAbsolute)
    throw UsageError(
        "--bound, --check-certificate: a bound is proved for scheme mpc, error = absolute, horizon = 1 and "
        "one droplet per cell only");
  if (m.alpha.front().alpha != 1.0 && !(o.certificate.empty() && o.check_certificate.empty()))
    throw UsageError(
        "--certificate, --check-certificate: multipliers prove a bound for alpha = 1 only; for alpha < 1 "
        "--bound adds up several proofs");
  if (o.bound_rows < 1 || o.bound_rows > 4)
    throw UsageError("--bound-rows = " + std::to_string(o.bound_rows) + " is outside 1..4");
  if (o.bound_sweeps < 0)
    throw UsageError("--bound-sweeps = " + std::to_string(o.bound_sweeps) + " must not be below 0");
}

double peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * double(usage.ru_maxrss);
}

void add_bound(const DecideOptions& o, const Experiment& e, const HeightMap& height,
               const control::Decision& d, double objective_mm, const ParallelFor& parallel,
               nlohmann::ordered_json& out) {
  const control::Setup setup = setup_of(o, e);
  const HeightMap known = control::known_heights({height, 0, 0, 0.0});
  double cells = 0.0, bound_mm = 0.0;
  for (const auto in : setup.mask.cells) cells += in;
  control::mpc::BoundOptions strips{o.bound_rows, o.bound_sweeps, 1e-6};
  strips.cost = cost_of_layer(e);
  int sweeps = 0, cuts = 0;
  if (const double alpha = e.control.mpc.alpha.front().alpha; alpha < 1.0) {
    control::mpc::WeightedBoundOptions options;
    options.strips.rows = o.bound_rows;
    options.strips.sweeps = std::min(o.bound_sweeps, options.strips.sweeps);
    const DropletPattern drops =
        d.kind == control::Decision::Kind::kPrint ? d.drops : DropletPattern(setup.grid);
    ProgressLine line({});
    const auto b =
        control::mpc::weighted_bound(setup, known, {}, alpha, drops, options, parallel, [&](double now_mm) {
          ++cuts;
          if (line.terminal())
            line.show(fmt::format("cut {} of at most {}: at most {:.2f} % better ", cuts, options.cuts,
                                  100.0 * (1.0 - now_mm / objective_mm)));
        });
    line.done();
    bound_mm = b.objective_mm;
    sweeps = b.sweeps;
    out["bound_cuts"] = b.cuts;
  } else {
    const auto b = control::mpc::lower_bound(setup, known, {}, objective_mm * cells, strips, parallel);
    bound_mm = b.total_mm / cells;
    sweeps = b.sweeps;
    if (!o.certificate.empty()) write_npy(o.certificate, certificate_bytes(b.multipliers, e.grid.nx));
  }
  out["lower_bound_mm"] = bound_mm;
  out["gap"] = objective_mm > 0.0 ? (objective_mm - bound_mm) / objective_mm : 0.0;
  out["bound_rows"] = o.bound_rows;
  out["bound_sweeps"] = sweeps;
}

std::string decided(const DecideOptions& o) {
  Experiment e;
  HeightMap height;
  {
    const auto bytes = read_bytes(o.height, "--height");
    const NpyShape shape = npy_shape(bytes, o.height);
    e = deciding_experiment(o, {shape.nx, shape.ny});
    height = height_map_from_npy(bytes, e.grid, o.height);
  }
  const control::ControlOptions options = control_options(e);
  if (!o.check_certificate.empty() || o.bound) check_bound_options(o, e);
  if (!o.certificate.empty() && !o.bound)
    throw UsageError("--certificate: only --bound has multipliers to write");
  if (!o.check_certificate.empty())
    return check_certificate(o, e, control::known_heights({height, 0, 0, 0.0}));
  if (o.edge_bound) return edge_bound_of(o, e, height);
  const ParallelFor parallel = parallel_on(thread_count(o.threads));

  // The controller has a copy of target and mask; on large grids there is no room for more.
  std::unique_ptr<control::LayerController> scheme;
  {
    const control::Setup setup = setup_of(o, e);
    Blobs inputs;
    add_python_inputs(
        e, "", setup.mask, [&](const Blobs& files) { scheme = make_scheme(setup, options, files); }, inputs);
    if (!scheme) scheme = make_scheme(setup, options, inputs);
  }
  scheme->use_threads(parallel);
  const double start = cpu_s();
  const control::Decision d = scheme->decide({height, 0, 0, 0.0});
  const double decide_s = cpu_s() - start;
  scheme.reset();
  const bool mpc = e.control.scheme == "mpc";
  const double objective = d.kind == control::Decision::Kind::kPrint ? d.objective_mm : d.objective_none_mm;
  nlohmann::ordered_json out{{"decision", d.kind == control::Decision::Kind::kPrint ? "print"
                                          : d.kind == control::Decision::Kind::kEnd ? "end"
                                                                                    : "stop"},
                             {"reason", d.reason},
                             {"method", mpc ? std::string(word(e.control.mpc.method)) : e.control.scheme},
                             {"droplets", d.drops.total()},
                             {"objective_mm", objective},
                             {"objective_none_mm", d.objective_none_mm},
                             {"iterations", d.iterations},
                             {"cpu_s", decide_s},
                             {"peak_bytes", peak_bytes()}};
  if (o.bound) {
    const double before = cpu_s();
    add_bound(o, e, height, d, objective, parallel, out);
    out["bound_cpu_s"] = cpu_s() - before;
  }
  if (!o.output.empty()) write_npy(o.output, to_npy(d.drops));
  if (o.json) return out.dump(2) + "\n";
  const int layers = mpc ? e.control.mpc.horizon : 1;
  std::string text = fmt::format("{}: {}\n", out["decision"].get<std::string>(), for_people(d.reason));
  text += fmt::format("objective       {:.6f} um, {} {} droplets\n", 1e3 * objective,
                      layers == 1 ? "with" : fmt::format("after {} layers, the next with", layers),
                      d.drops.total());
  text += fmt::format("printing none   {:.6f} um\n", 1e3 * d.objective_none_mm);
  if (o.bound)
    text += fmt::format(
        "lower bound     {:.6f} um: no layer is better by more than {:.3f} % (strips of {} rows, {} sweeps, "
        "{:.2f} "
        "s)\n",
        1e3 * out["lower_bound_mm"].get<double>(), 100.0 * out["gap"].get<double>(),
        out["bound_rows"].get<int>(), out["bound_sweeps"].get<int>(), out["bound_cpu_s"].get<double>());
  return text + fmt::format("{} iterations, {:.4f} s of processor time, {:.0f} MB at most\n", d.iterations,
                            decide_s, 1e-6 * peak_bytes());
}

}  // namespace

std::string decide(const DecideOptions& o) try {
  return decided(o);
} catch (const std::invalid_argument& e) {  // a file that is no NPY, or states that the scheme cannot take
  throw UsageError(e.what());
}

int run_decide(const DecideOptions& o) {
  std::fputs(decide(o).c_str(), stdout);
  return kOk;
}

void declare_decide(OptionSet& options) {
  auto& o = options.calls(run_decide);
  options.option("--height", o.height, "NPY of the surface [mm], rows along x").required();
  options.option("--target", o.target, "NPY of the wanted heights [mm]").required();
  options.option("--mask", o.mask, "NPY, 1 = the part; default: every cell");
  options.option("--model", o.model,
                 "TOML with [model], and [control] if wanted; default: Lu's Table I, mpc");
  options.override_option(o.overrides);
  options.option("--alpha", o.alpha, "weight of the mean error, (0, 1]");
  options.option("--horizon", o.horizon, "N");
  options.option("--method", o.method, "greedy, descent, strip-dp or certified");
  options.flag("--bound", o.bound, "prove how much better any layer could be (N = 1)");
  options.option("--bound-rows", o.bound_rows, "rows per strip, 1..4: tighter and dearer").show_default();
  options.option("--bound-sweeps", o.bound_sweeps, "down or up, at most").show_default();
  options.option("--certificate", o.certificate, "NPY of the bound's multipliers, written");
  options.option("--check-certificate", o.check_certificate,
                 "NPY of multipliers: prints the bound that they prove, nothing else");
  options.flag("--edge-bound", o.edge_bound,
               "prints the least overspill of any pattern at the surface's mean error, nothing else");
  options.option("-o,--output", o.output, "NPY of the droplets");
  options.option("--threads", o.threads, "0 = as many as the machine has; the same bytes for any number")
      .show_default();
  options.json_flag(o.json);
}

}  // namespace firn
