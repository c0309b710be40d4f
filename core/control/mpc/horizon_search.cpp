#include "core/control/mpc/horizon_search.h"

#include <algorithm>

#include "core/control/halftone.h"
#include "core/control/mpc/anneal.h"
#include "core/control/mpc/descent.h"
#include "core/control/mpc/layer/layer_problem.h"
#include "core/control/prediction.h"

namespace firn::control::mpc {
namespace {

constexpr std::size_t kCellsForOneRun = 500, kMaxRuns = 12;

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

// Cells where a droplet more or less is a question: near a cell that is short now and one that would be too
// high if every layer were full. (Elsewhere every droplet pays, or none; descent finds those.) For alpha < 1
// the deviation asks for all.
std::vector<std::uint32_t> open_cells(const HorizonObjective& objective, const HorizonStart& s, int layers) {
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
  for (std::size_t c = 0; c < all.size(); ++c)
    all.cells[c] = s.setup.mask.cells[c] ? std::uint8_t(objective.max_drops()) : 0;
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

// Descent that looks in single precision first.
SearchResult descend_sieved(HorizonObjective& objective, const HorizonStart& s, int layers,
                            std::int64_t most) {
  HorizonState field(s.setup, s.height, s.materials, layers, objective.cost());
  field.set_drops(plan_of(objective));
  DeltaCache flips(field, objective.error() == ErrorKind::kSquare ? DeltaCache::Wanted::kSquares
                                                                  : DeltaCache::Wanted::kAbsolute);
  return descend(objective, layers, most, &flips);
}

}  // namespace

StripResult strips_of_layer(std::vector<DropletPattern>& plan, int n, const HorizonStart& s, int rows,
                            const ParallelFor& parallel) {
  constexpr int kMaxSweeps = 200;
  const auto materials = [&s](int layer) {
    return s.materials.empty() ? MaterialMap{} : s.materials[std::size_t(layer)];
  };
  HeightMap height = s.height;
  if (n > 0) {
    Predictor predict(s.setup);
    for (int before = 0; before < n; ++before)
      height = predict.after(height, plan[std::size_t(before)], materials(before));
  }
  CellCost cost;
  cost.outside = float(s.outside_price);
  LayerProblem problem(s.setup, height, materials(n));
  problem.set_drops(plan[std::size_t(n)]);
  StripResult result;
  for (int k = std::min(2, rows); k <= rows; ++k) {
    const StripResult r = sweep_strips(problem, {k, kMaxSweeps, cost}, parallel);
    result = {result.sweeps + r.sweeps, result.strips + r.strips, result.improved + r.improved, r.settled};
  }
  plan[std::size_t(n)] = problem.drops(s.setup.grid);
  return result;
}

std::vector<DropletPattern> partial_layer_first(const HorizonStart& s, int layers) {
  std::vector<DropletPattern> plan(std::size_t(layers), DropletPattern(s.setup.grid));
  Grid<double> wanted(s.setup.grid), carry(s.setup.grid);
  const double step_mm[2] = {s.setup.model.layer_height_mm(), s.setup.model_b.layer_height_mm()};
  for (int n = 0; n < layers; ++n) {  // the full ones are at the end
    const int at = layers - 1 - n;
    const bool inks = !s.materials.empty() && s.materials[std::size_t(at)].size() != 0;
    for (std::size_t c = 0; c < wanted.size(); ++c) {
      const bool b = inks && s.materials[std::size_t(at)].of(c) == Material::kB;
      wanted.cells[c] = std::clamp((s.setup.target.cells[c] - s.height.cells[c]) / step_mm[b] - n, 0.0, 1.0);
    }
    plan[std::size_t(at)] = halftone(wanted, s.setup.mask, 1, Rounding::kDiffusion, carry);
  }
  return plan;
}

SearchResult search_horizon(HorizonObjective& objective, const HorizonStart& s, const HorizonOptions& o,
                            RandomStream& random) {
  SearchResult result;
  std::vector<DropletPattern> best = plan_of(objective);
  double best_mm = objective.value_mm();
  const auto left = [&] { return o.max_evaluations - result.evaluations; };
  const bool sieved = objective.max_drops() == 1 && objective.horizon() > 1 &&
                      objective.horizon() <= HorizonState::kMaxLayers && objective.alpha() == 1.0;
  const auto descend_from = [&](std::span<const DropletPattern> start, int layers) {
    std::vector<DropletPattern> plan(best.size(), DropletPattern(s.setup.grid));
    std::ranges::copy(start, plan.begin());
    objective.set_plan(plan);
    const SearchResult r =
        sieved ? descend_sieved(objective, s, layers, left()) : descend(objective, layers, left());
    result.evaluations += r.evaluations;
    result.moves += r.moves;
    if (objective.value_mm() > best_mm) return;
    best = plan_of(objective);
    best_mm = objective.value_mm();
    result.optimal = r.optimal;
  };
  const auto take = [&](std::span<const DropletPattern> plan) {
    objective.set_plan(plan);
    if (objective.value_mm() < best_mm) {
      best = plan_of(objective);
      best_mm = objective.value_mm();
    }
  };
  const bool single = objective.max_drops() == 1;
  const bool strips_do = single && objective.alpha() == 1.0;
  const bool strips_end = strips_do && objective.error() == ErrorKind::kAbsolute;
  for (int layers = 1; layers <= objective.horizon(); ++layers) {
    std::vector<DropletPattern> plan = best;
    if (layers > 1 && single)
      result.evaluations += strips_of_layer(plan, layers - 1, s, o.strip_rows, o.parallel).strips;
    const std::vector<std::uint32_t> open = open_cells(objective, s, layers);
    if ((strips_end && layers == 1) || (strips_do && open.empty())) {
      take(plan);
      continue;
    }
    descend_from(plan, layers);
    if (layers > 1 && single) descend_from(partial_layer_first(s, layers), layers);
    if (o.anneal_sweeps == 0 || open.empty()) continue;
    // On few cells many runs are cheap, and hot ones forget their start; on many the start is worth more.
    const int runs = 1 + int(kCellsForOneRun / (open.size() + kCellsForOneRun / kMaxRuns));
    for (int run = 0; run < runs; ++run) {
      AnnealOptions annealing;
      annealing.layers = layers;
      annealing.sweeps = o.anneal_sweeps;
      annealing.max_evaluations = left();
      if (run > 0) annealing.hot_mm *= 4.0;
      SearchResult r;
      plan = best;
      if (single && layers <= HorizonState::kMaxLayers) {
        HorizonState field(s.setup, s.height, s.materials, layers, objective.cost());
        field.set_drops(plan);
        r = anneal(field, objective.cost(), open, annealing, random);
        std::ranges::move(field.plan(s.setup.grid), plan.begin());
      } else {
        objective.set_plan(plan);
        r = anneal(objective, open, annealing, random);
        plan = plan_of(objective);
      }
      result.evaluations += r.evaluations;
      result.moves += r.moves;
      descend_from(plan, layers);
    }
  }
  objective.set_plan(best);
  return result;
}

}  // namespace firn::control::mpc
