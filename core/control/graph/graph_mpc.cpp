#include "core/control/graph/graph_mpc.h"

#include <algorithm>

#include "core/control/halftone.h"

namespace firn::control {
namespace {

ExtraValues checked_graph(const ControlOptions& options) {
  check_extra("graph_mpc", kGraphMpcOptions, options.extra);
  ExtraValues values = options.extra;
  values.complete(kGraphMpcOptions);
  if (std::ranges::find(kGraphSolverWords, values.text("graph_solver")) == kGraphSolverWords.end())
    throw std::invalid_argument("graph_mpc: extra.graph_solver = '" + values.text("graph_solver") +
                                "' is neither together nor blocks");
  return values;
}

}  // namespace

GraphMpc::GraphMpc(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      dh_mm_(setup.model.layer_height_mm()),
      noise_gate_(options.noise_gate),
      part_cells_(setup.mask.count()),
      predict_(setup) {
  const ExtraValues extra = checked_graph(options);
  horizon_ = int(extra.integer("graph_horizon"));
  steps_ = int(extra.integer("graph_steps"));
  effort_ = extra.number("graph_effort");
  blocks_ = extra.text("graph_solver") == kGraphSolverWords[1];
}

void GraphMpc::use_model(const deposition::DropletModel& model) {
  deposition::check(model);
  setup_.model = model;
  predict_ = Predictor(setup_);
}

graph::BoxProblem GraphMpc::problem(const HeightMap& height, const MaterialMap& materials, int layer,
                                    std::vector<double>& start) const {
  const graph::GraphModel model(setup_.model, setup_.border, steps_);
  graph::BoxProblem p;
  p.nx = setup_.grid.nx;
  p.ny = setup_.grid.ny;
  p.counts = p.free = setup_.mask.cells;
  p.effort_mm2 = effort_ * model.droplet_mm * model.droplet_mm;
  std::vector<double> droplet_mm(p.cells(), model.droplet_mm);
  if (materials.size() != 0)
    for (std::size_t c = 0; c < droplet_mm.size(); ++c)
      droplet_mm[c] = setup_.model_of(materials.of(c)).layer_height_mm();

  std::vector<double> surface = height.cells;
  start.assign(std::size_t(horizon_) * p.cells(), 0.0);
  for (int n = 0; n < horizon_; ++n) {
    const auto dose = std::span(start).subspan(std::size_t(n) * p.cells(), p.cells());
    for (std::size_t c = 0; c < dose.size(); ++c)
      if (setup_.mask.cells[c]) {
        const double next = std::min(double(layer + n + 1) * dh_mm_, setup_.target.cells[c]);
        dose[c] = std::clamp((next - surface[c]) / droplet_mm[c], 0.0, 1.0);
      }
    p.layers.push_back(graph::layer_along(model, setup_.grid, droplet_mm, surface, dose));
  }
  // The plan is about `surface`: what is wanted is the change by the doses, from none at all.
  const std::vector<double> by_start = p.change(start);
  p.wanted_mm.assign(p.cells(), 0.0);
  for (std::size_t c = 0; c < p.cells(); ++c)
    if (setup_.mask.cells[c])
      p.wanted_mm[c] =
          std::min(double(layer + horizon_) * dh_mm_, setup_.target.cells[c]) - surface[c] + by_start[c];
  return p;
}

Decision GraphMpc::decide(const Measurement& m) {
  check(m, setup_);
  const HeightMap height = known_heights(m);
  Decision d;
  d.materials = materials_at(setup_, height);
  std::vector<double> start;
  const graph::BoxProblem p = problem(height, d.materials, m.layer, start);
  const graph::BoxSolution plan = blocks_ ? graph::solve_in_blocks(p, std::move(start), {}, parallel_)
                                          : graph::solve_together(p, std::move(start), {});
  Grid<double> wanted(setup_.grid), none(setup_.grid);
  std::copy_n(plan.doses.begin(), wanted.size(), wanted.cells.begin());
  d.drops = halftone(wanted, setup_.mask, 1, Rounding::kDiffusion, none);
  d.iterations = plan.iterations;
  predict_.score(d, height, 1.0);
  bool at_target = true;
  for (std::size_t c = 0; c < height.size(); ++c)
    at_target = at_target && (!setup_.mask.cells[c] || double(m.layer) * dh_mm_ >= setup_.target.cells[c]);
  if (at_target && !beats_noise(d, part_cells_, m.noise_std_mm, noise_gate_)) {
    end_print(d,
              "the nominal height is reached and no layer betters the part beyond the measurement's noise");
    return d;
  }
  d.kind = Decision::Kind::kPrint;
  d.reason = "layer " + std::to_string(m.layer + 1) + " by the volumes of " + std::to_string(horizon_) +
             (horizon_ == 1 ? " layer" : " layers") + " that flow along a graph";
  return d;
}

}  // namespace firn::control
