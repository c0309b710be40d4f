#include "core/control/mpc/mpc.h"

#include <algorithm>
#include <cmath>

#include "core/control/halftone.h"
#include "core/control/mpc/descent.h"
#include "core/control/mpc/guard.h"
#include "core/control/mpc/horizon_search.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "core/control/mpc/layer/one_layer.h"
#include "core/control/mpc/layer/weighted_layer.h"
#include "core/control/mpc/placed_bound.h"
#include "core/control/mpc/placed_search.h"
#include "core/control/mpc/tiled_greedy.h"
#include "core/control/prediction.h"
#include "core/control/rim_inset.h"
#include "core/options/require.h"

namespace firn::control {
namespace {

MpcOptions checked(MpcOptions o) {
  check_options("mpc", kMpcOptions, o);
  require(o.price_mm2 >= 0.0, "mpc", "price_mm2 = " + std::to_string(o.price_mm2) + " must not be below 0");
  require(o.mean_weight >= 0.0, "mpc",
          "mean_weight = " + std::to_string(o.mean_weight) + " must not be below 0");
  require(o.start_ones || o.start_dithered, "mpc",
          "start_ones and start_dithered are both off: the search needs a first guess");
  require(!o.alpha.empty() && o.alpha.front().from_layer == 1, "mpc",
          "alpha: the schedule must begin at from_layer = 1");
  require(o.outside_price == 0.0 ||
              std::ranges::all_of(o.alpha, [](const AlphaStep& a) { return a.alpha == 1.0; }),
          "mpc", "outside_price: the price of ink beside the part is known at alpha = 1 only");
  require(o.edge_lag_layers == 0.0 || o.rise_layers > 0.0, "mpc",
          "edge_lag_layers: only a part that rises with rise_layers above 0 has an edge that lags");
  for (std::size_t n = 1; n < o.alpha.size(); ++n)
    require(o.alpha[n].from_layer > o.alpha[n - 1].from_layer, "mpc",
            "alpha: from_layer " + std::to_string(o.alpha[n].from_layer) + " does not ascend");
  if (o.error == ErrorKind::kSquareMean) {
    o.error = ErrorKind::kSquare;
    o.mean_weight = kMeanWeight;
  }
  return o;
}

}  // namespace

Mpc::Mpc(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      options_(checked(options.mpc)),
      noise_gate_(options.noise_gate),
      rim_inset_(options.rim_inset) {
  if (!placed()) return;
  require(options_.method != MpcMethod::kCertified || rim_inset_ > 0.0, "mpc",
          "method = certified with actuation.offsets needs control.rim_inset: the second place of cells at "
          "the outline");
  require(options_.horizon == 1 && options_.max_drops == 1, "mpc",
          "horizon and max_drops must be 1 with actuation.offsets: places are decided one layer and one "
          "droplet at a time");
  require(std::ranges::all_of(options_.alpha, [](const AlphaStep& a) { return a.alpha == 1.0; }), "mpc",
          "alpha must be 1 with actuation.offsets");
}

mpc::HorizonObjective& Mpc::objective() {
  if (!objective_)
    objective_.emplace(setup_, options_.horizon, options_.max_drops, options_.error, options_.price_mm2,
                       options_.mean_weight, options_.outside_price);
  return *objective_;
}

void Mpc::use_model(const deposition::DropletModel& model) {
  deposition::check(model);
  if (model == setup_.model) return;
  setup_.model = model;
  objective_.reset();
}

void Mpc::use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) {
  deposition::check(inside);
  deposition::check(rim);
  if (inside == setup_.model && rim == setup_.model_b) return;
  setup_.model = inside;
  setup_.model_b = rim;
  objective_.reset();
}

void Mpc::use_options(const ControlOptions& options) {
  take_changeable(kMpcOptions, checked(options.mpc), options_);
  noise_gate_ = options.noise_gate;
}

double Mpc::alpha_at(int layer) const {
  double alpha = options_.alpha.front().alpha;
  for (const AlphaStep& a : options_.alpha)
    if (a.from_layer <= layer) alpha = a.alpha;
  return alpha;
}

std::vector<MaterialMap> Mpc::materials_of(const HeightMap& height) const {
  if (setup_.rim.size() != 0) {
    MaterialMap models(setup_.grid);
    for (std::size_t c = 0; c < models.size(); ++c)
      models.set(c, setup_.rim.cells[c] ? Material::kB : Material::kA);
    return std::vector<MaterialMap>(std::size_t(options_.horizon), models);
  }
  std::vector<MaterialMap> inks;
  for (int n = 0; n < options_.horizon; ++n)
    inks.push_back(materials_at(setup_, height, double(n) * setup_.model.layer_height_mm()));
  return inks;
}

std::vector<DropletPattern> Mpc::first_guess(const HeightMap& height, const MaterialMap& materials,
                                             bool dithered) const {
  std::vector<DropletPattern> plan(std::size_t(options_.horizon), DropletPattern(setup_.grid));
  Grid<double> wanted(setup_.grid), carry(setup_.grid);
  const double step_of[2] = {setup_.model.layer_height_mm(), setup_.model_b.layer_height_mm()};
  for (std::size_t n = 0; n < plan.size(); ++n) {
    for (std::size_t c = 0; c < wanted.size(); ++c) {
      const double step_mm = step_of[materials.size() != 0 && materials.of(c) == Material::kB];
      const double missing =
          (setup_.target.cells[c] - height.cells[c]) / step_mm - double(n) * options_.max_drops;
      wanted.cells[c] = std::clamp(missing, 0.0, double(options_.max_drops));
      plan[n].cells[c] = setup_.mask.cells[c] ? std::uint8_t(options_.max_drops) : std::uint8_t{0};
    }
    if (dithered) plan[n] = halftone(wanted, setup_.mask, options_.max_drops, Rounding::kDiffusion, carry);
  }
  return plan;
}

Mpc::Found Mpc::search(std::vector<DropletPattern> guess, const HeightMap& height,
                       std::span<const MaterialMap> materials, double alpha, std::int64_t evaluations,
                       RandomStream& random) {
  Found found;
  mpc::HorizonObjective& objective = *objective_;
  if (options_.method == MpcMethod::kCertified && one_layer() &&
      objective.part_cells().size() <= mpc::kMaxSplitCells) {
    mpc::LayerProblem problem(setup_, height, materials.front());
    problem.set_drops(guess.front());
    if (alpha == 1.0) {
      const mpc::LayerSolution s = mpc::solve_layer(problem, mpc::certified_options(options_), parallel_);
      found.evaluations = s.strips;
      found.reached = mpc::reached(options_, s);
    } else
      mpc::weighted_layer(problem, alpha, {options_.strip_rows}, parallel_);
    guess.front() = problem.drops(setup_.grid);
    objective.set_plan(guess);
    return found;
  }
  if (options_.method == MpcMethod::kStripDp || options_.method == MpcMethod::kCertified) {
    const mpc::HorizonStart state{setup_, height, materials, options_.outside_price};
    for (std::size_t n = 1; n < guess.size(); ++n) guess[n] = DropletPattern(setup_.grid);
    if (options_.max_drops == 1) {
      const auto strips = mpc::strips_of_layer(guess, 0, state, options_.strip_rows, parallel_);
      found.evaluations = strips.strips;
      found.optimal = strips.settled;
    }
    objective.set_plan(guess);
    if (alpha == 1.0 && one_layer()) return found;
    const auto r = mpc::search_horizon(
        objective, state, {options_.strip_rows, options_.anneal_sweeps, evaluations, parallel_}, random);
    found.evaluations += r.evaluations;
    found.optimal = r.optimal;
    return found;
  }
  objective.set_plan(guess);
  if (options_.method == MpcMethod::kDescent) {
    const auto r = mpc::descend(objective, options_.horizon, evaluations);
    return {r.evaluations, r.optimal};
  }
  const auto greedy = mpc::greedy_search(objective, {options_.subset, evaluations}, random);
  objective.refresh();
  return {greedy.evaluations, greedy.optimal};
}

Decision Mpc::decide_lean(const Measurement& m, const HeightMap& height) const {
  Decision d;
  d.drops = DropletPattern(setup_.grid);
  d.objective_none_mm = mpc::mean_error_mm(setup_, height, d.drops);
  d.objective_mm = d.objective_none_mm - options_.min_improvement_mm - mpc::kMinGain_mm;  // to be beaten
  d.kind = Decision::Kind::kEnd;
  const bool large = setup_.grid.size() > mpc::kMaxSplitCells;
  bool settled = false;
  std::string reached;
  for (const bool dithered : {false, true}) {
    if (large ? dithered : !(dithered ? options_.start_dithered : options_.start_ones)) continue;
    DropletPattern guess;
    if (large) {
      guess = DropletPattern(setup_.grid);
      for (std::size_t c = 0; c < guess.size(); ++c) guess.cells[c] = setup_.mask.cells[c] != 0;
    } else {
      guess = std::move(first_guess(height, {}, dithered).front());
    }
    mpc::OneLayer found = mpc::decide_one_layer(setup_, height, guess, options_, parallel_);
    d.iterations += found.strips;
    if (!(found.objective_mm < d.objective_mm) || found.drops.passes() == 0) continue;
    d.drops = std::move(found.drops);
    d.objective_mm = found.objective_mm;
    d.kind = Decision::Kind::kPrint;
    settled = found.settled;
    reached = mpc::reached(options_, found.certified);
  }
  const std::int64_t cells = part_cells();
  const bool without_bound =
      options_.method == MpcMethod::kCertified && std::size_t(cells) > mpc::kMaxSplitCells;
  if (d.kind == Decision::Kind::kEnd)
    end_print(d, "another layer would not improve the surface");
  else if (!beats_noise(d, cells, m.noise_std_mm, noise_gate_, options_.error))
    end_print(d, "the best layer would only answer the measurement's noise");
  else  // more than half of its height goes where height is missing, or it would not better the mean error
        // (guard.h)
    d.reason = options_.method == MpcMethod::kCertified && !without_bound
                   ? "the best layer of strips that agree on windows of droplets" + reached
               : settled
                   ? "no strip of " + std::to_string(options_.strip_rows) + " rows betters this layer" +
                         (without_bound ? "; of more than " + std::to_string(mpc::kMaxSplitCells) +
                                              " cells certified decides as strip_dp, without a bound"
                                        : "")
                   : "best layer found within " + std::to_string(options_.max_evaluations) + " evaluations";
  return d;
}

Decision Mpc::decide_tiled(const Measurement& m, const HeightMap& height) const {
  Decision d;
  d.drops = DropletPattern(setup_.grid);
  d.objective_none_mm = mpc::mean_error_mm(setup_, height, d.drops);
  mpc::TiledLayer found = mpc::tiled_greedy(setup_, height, options_, m.layer + 1, m.attempt, parallel_);
  d.iterations = found.evaluations;
  if (found.objective_mm < d.objective_none_mm - options_.min_improvement_mm - mpc::kMinGain_mm) {
    d.drops = std::move(found.drops);
    d.objective_mm = found.objective_mm;
    d.kind = Decision::Kind::kPrint;
  }
  if (d.kind != Decision::Kind::kPrint)
    end_print(d, "another layer would not improve the surface");
  else if (!beats_noise(d, part_cells(), m.noise_std_mm, noise_gate_, options_.error))
    end_print(d, "the best layer would only answer the measurement's noise");
  else
    d.reason = found.optimal
                   ? "no single droplet more or less betters this layer"
                   : "best layer found within " + std::to_string(options_.max_evaluations) + " evaluations";
  return d;
}

std::int64_t Mpc::part_cells() const {
  return std::ranges::count_if(setup_.mask.cells, [](std::uint8_t in) { return in != 0; });
}

Decision Mpc::decide_placed(const Measurement& m, const HeightMap& height) {
  const MaterialMap inks = materials_of(height).front();
  const mpc::PlanCost cost{1.0, options_.error, options_.price_mm2, options_.mean_weight,
                           options_.outside_price};
  const bool certified = options_.method == MpcMethod::kCertified;
  const OffsetMap second = certified ? inset_places(setup_, rim_inset_) : OffsetMap{};
  const mpc::PlacedObjective empty(setup_, height, inks, cost, certified ? &second : nullptr);
  Decision d;
  if (setup_.geometry) d.materials = inks;
  d.drops = DropletPattern(setup_.grid);
  d.objective_none_mm = empty.value_mm();
  d.objective_mm = d.objective_none_mm - options_.min_improvement_mm - mpc::kMinGain_mm;  // to be beaten
  d.kind = Decision::Kind::kEnd;
  bool optimal = true;
  RandomStream random(setup_.seed, Purpose::kGreedySearch, std::uint32_t(m.layer + 1),
                      std::uint32_t(m.attempt));
  for (const bool dithered : {false, true}) {
    mpc::PlacedObjective layer = empty;
    if (dithered) {
      if (!options_.start_dithered) continue;
      const DropletPattern guess = first_guess(height, inks, true).front();
      for (std::size_t n = 0; n < layer.cells().size(); ++n)
        if (guess.cells[layer.cells()[n]]) layer.choose(n, 0);
    }
    const mpc::SearchResult found =
        mpc::place_droplets(layer, options_.max_evaluations - d.iterations, random);
    d.iterations += found.evaluations;
    if (!(layer.value_mm() < d.objective_mm)) continue;
    d.objective_mm = layer.value_mm();
    d.kind = Decision::Kind::kPrint;
    d.drops = layer.drops();
    d.offsets = layer.offsets();
    optimal = found.optimal;
  }
  if (d.kind == Decision::Kind::kEnd)
    end_print(d, "another layer would not improve the surface");
  else if (!beats_noise(d, std::int64_t(empty.cells().size()), m.noise_std_mm, noise_gate_, options_.error))
    end_print(d, "the best layer would only answer the measurement's noise");
  else
    d.reason =
        (optimal ? "no droplet more, less or in another place betters this layer, nor two of them"
                 : "best layer found within " + std::to_string(options_.max_evaluations) + " evaluations") +
        (certified ? mpc::placed_reached(empty, options_, d.objective_mm) : "");
  return d;
}

Decision Mpc::decide(const Measurement& m) {
  check(m, setup_);
  const bool whole = std::ranges::all_of(m.height.cells, [](double h) { return std::isfinite(h); });
  const HeightMap filled = whole ? HeightMap{} : known_heights(m);
  const HeightMap& height = whole ? m.height : filled;
  const int layer = m.layer + 1;
  const double alpha = alpha_at(layer);
  if (placed()) return decide_placed(m, height);
  if (one_layer() && strips() && alpha == 1.0 && !setup_.geometry && setup_.rim.size() == 0)
    return decide_lean(m, height);
  if (one_layer() && options_.method == MpcMethod::kGreedy && alpha == 1.0 && !setup_.geometry &&
      setup_.rim.size() == 0 && std::size_t(part_cells()) > mpc::kTiledCells)
    return decide_tiled(m, height);
  mpc::HorizonObjective& objective = this->objective();
  Decision d;
  d.drops = DropletPattern(setup_.grid);

  const std::vector<MaterialMap> materials = materials_of(height);
  if (setup_.geometry) d.materials = materials.front();
  objective.set_surface(height, alpha, materials);
  objective.set_plan(std::vector<DropletPattern>(std::size_t(options_.horizon), d.drops));
  d.objective_none_mm = objective.value_mm();
  d.objective_mm = d.objective_none_mm - options_.min_improvement_mm - mpc::kMinGain_mm;  // to be beaten
  d.kind = Decision::Kind::kEnd;
  bool optimal = true;
  std::string reached;
  RandomStream random(setup_.seed, Purpose::kGreedySearch, std::uint32_t(layer), std::uint32_t(m.attempt));
  for (const bool dithered : {false, true}) {
    if (!(dithered ? options_.start_dithered : options_.start_ones)) continue;
    const Found found = search(first_guess(height, materials.front(), dithered), height, materials, alpha,
                               options_.max_evaluations - d.iterations, random);
    d.iterations += found.evaluations;
    if (!(objective.value_mm() < d.objective_mm)) continue;
    int first =
        0;  // of the layers that print something; there is one, since this plan improves on an empty one
    while (objective.layer(first).passes() == 0) ++first;
    d.drops = objective.layer(first);
    d.objective_mm = objective.value_mm();
    d.kind = Decision::Kind::kPrint;
    optimal = found.optimal;
    reached = found.reached;
  }
  if (d.kind == Decision::Kind::kEnd) {
    end_print(d, "another layer would not improve the surface");
  } else if (!beats_noise(d, std::int64_t(objective.part_cells().size()), m.noise_std_mm, noise_gate_,
                          options_.error)) {
    end_print(d, "the best layer would only answer the measurement's noise");
  } else if (options_.method != MpcMethod::kGreedy &&
             mpc::useful_share(setup_, height, d.drops, materials.front()) < mpc::kMinUseful) {
    end_print(d, "the best layer would build where little is missing");
  } else {
    d.reason = options_.method == MpcMethod::kCertified && one_layer()
                   ? "the best layer of strips that agree on windows of droplets" + reached
               : optimal && options_.method == MpcMethod::kStripDp && alpha == 1.0 && options_.horizon == 1 &&
                       options_.max_drops == 1
                   ? "no strip of " + std::to_string(options_.strip_rows) + " rows betters this layer"
               : optimal
                   ? "no single droplet more or less betters this layer"
                   : "best layer found within " + std::to_string(options_.max_evaluations) + " evaluations";
  }
  return d;
}

}  // namespace firn::control
