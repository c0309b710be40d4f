#include "core/control/mpc/horizon_search.h"

#include <algorithm>

#include "core/control/mpc/anneal.h"
#include "core/control/mpc/descent.h"
#include "core/control/mpc/layer_problem.h"
#include "core/control/prediction.h"

namespace firn::control::mpc {
namespace {

std::vector<DropletPattern> plan_of(const HorizonObjective& objective) {
  std::vector<DropletPattern> plan;
  for (int n = 0; n < objective.horizon(); ++n) plan.push_back(objective.layer(n));
  return plan;
}

// Marks the cells within `reach` of a marked one, in x and in y.
void spread(Mask& marks, int reach) {
  const GridSpec& g = marks.spec;
  for (const bool along_x : {true, false}) {
    const int length = along_x ? g.nx : g.ny, lines = along_x ? g.ny : g.nx;
    for (int line = 0; line < lines; ++line) {
      const auto at = [&](int n) -> std::uint8_t& { return along_x ? marks.at(n, line) : marks.at(line, n); };
      for (const bool forward : {true, false}) {
        int since = reach + 1;  // cells since a marked one; those marked here read 2 and do not count
        for (int n = 0; n < length; ++n) {
          std::uint8_t& m = at(forward ? n : length - 1 - n);
          since = m == 1 ? 0 : since + 1;
          if (m == 0 && since <= reach) m = 2;
        }
      }
      for (int n = 0; n < length; ++n) at(n) = at(n) != 0;
    }
  }
}

// Cells where a droplet more or less is a question: near a cell that is short now and one that would be too high if every
// layer were full. (Elsewhere every droplet pays, or none; descent finds those.) For alpha < 1 the deviation asks for all.
std::vector<std::uint32_t> open_cells(const HorizonObjective& objective, const HorizonState& s, int layers) {
  const GridSpec& g = s.setup.grid;
  std::vector<std::uint32_t> open;
  if (objective.alpha() < 1.0) {
    open.assign(objective.part_cells().begin(), objective.part_cells().end());
    return open;
  }
  Mask below(g), above(g);
  HeightMap full = s.height;
  DropletPattern all(g);
  Predictor predict(s.setup);
  for (std::size_t c = 0; c < all.size(); ++c) all.cells[c] = s.setup.mask.cells[c] ? std::uint8_t(objective.max_drops()) : 0;
  for (int n = 0; n < layers; ++n)
    full = predict.after(full, all, s.materials.empty() ? MaterialMap{} : s.materials[std::size_t(n)]);
  for (const std::uint32_t c : objective.part_cells()) {
    below.cells[c] = s.height.cells[c] < s.setup.target.cells[c];
    above.cells[c] = full.cells[c] > s.setup.target.cells[c];
  }
  const int reach = layers * objective.max_drops();
  spread(below, reach);
  spread(above, reach);
  for (const std::uint32_t c : objective.part_cells())
    if (below.cells[c] && above.cells[c]) open.push_back(c);
  return open;
}

}  // namespace

StripResult strips_of_layer(std::vector<DropletPattern>& plan, int n, const HorizonState& s, int rows) {
  constexpr int kMostSweeps = 200;
  const auto materials = [&s](int layer) { return s.materials.empty() ? MaterialMap{} : s.materials[std::size_t(layer)]; };
  HeightMap height = s.height;
  if (n > 0) {
    Predictor predict(s.setup);
    for (int before = 0; before < n; ++before) height = predict.after(height, plan[std::size_t(before)], materials(before));
  }
  LayerProblem problem(s.setup, height, materials(n));
  problem.set_drops(plan[std::size_t(n)]);
  StripResult result;
  for (int k = std::min(2, rows); k <= rows; ++k) {
    const StripResult r = sweep_strips(problem, {k, kMostSweeps}, serially);
    result = {result.sweeps + r.sweeps, result.strips + r.strips, result.improved + r.improved, r.settled};
  }
  plan[std::size_t(n)] = problem.drops(s.setup.grid);
  return result;
}

SearchResult search_horizon(HorizonObjective& objective, const HorizonState& s, const HorizonOptions& o,
                            RandomStream& random) {
  SearchResult result;
  const auto add = [&result](const SearchResult& r) {
    result.evaluations += r.evaluations, result.moves += r.moves, result.optimal = r.optimal;
  };
  std::vector<DropletPattern> best = plan_of(objective);
  double best_mm = objective.value_mm();
  const auto keep_better = [&] {
    if (!(objective.value_mm() < best_mm)) return objective.set_plan(best);
    best = plan_of(objective), best_mm = objective.value_mm();
  };
  for (int layers = 1; layers <= objective.horizon(); ++layers) {
    if (layers > 1 && objective.max_drops() == 1) {
      std::vector<DropletPattern> plan = best;
      result.evaluations += strips_of_layer(plan, layers - 1, s, o.strip_rows).strips;
      objective.set_plan(plan);
      keep_better();
    }
    add(descend(objective, layers, o.max_evaluations - result.evaluations));
    keep_better();
    const std::vector<std::uint32_t> open = open_cells(objective, s, layers);
    const bool exact = layers == 1 && objective.max_drops() == 1 && objective.alpha() == 1.0;  // strips are better at it
    if (o.anneal_sweeps == 0 || open.empty() || exact) continue;
    AnnealOptions annealing;
    annealing.layers = layers;
    annealing.sweeps = o.anneal_sweeps;
    annealing.max_evaluations = o.max_evaluations - result.evaluations;
    if (objective.max_drops() == 1 && layers <= PlanField::kMostLayers) {
      PlanField field(s.setup, s.height, s.materials, layers);
      std::vector<DropletPattern> plan = plan_of(objective);
      field.set_plan(plan);
      add(anneal(field, objective.alpha(), open, annealing, random));
      std::ranges::move(field.plan(s.setup.grid), plan.begin());
      objective.set_plan(plan);
    } else {
      add(anneal(objective, open, annealing, random));
    }
    add(descend(objective, layers, o.max_evaluations - result.evaluations));
    keep_better();
  }
  return result;
}

}  // namespace firn::control::mpc
