#include "core/control/mpc/finish.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>

namespace firn::control {
namespace {
const double kWander = getenv("WANDER") ? atof(getenv("WANDER")) : 0.024;
}

FinishTogether::FinishTogether(const Setup& setup, const ControlOptions& options)
    : setup_(setup), options_(options), layer_mm_(setup.model.layer_height_mm()), last_(setup, options) {
  const double k = options.mpc.finish_layers;
  if (!(std::isfinite(k) && k >= 0.0)) throw std::invalid_argument("mpc: finish_layers = " + std::to_string(k) + " must not be below 0");
}

HeightMap FinishTogether::first_target() const {
  HeightMap h = setup_.target;
  const double inside_mm = options_.mpc.finish_layers * layer_mm_;
  const double rim_mm = inside_mm * setup_.model_b.layer_height_mm() / setup_.model.layer_height_mm();
  for (std::size_t c = 0; c < h.size(); ++c)
    h.cells[c] = std::max(0.0, h.cells[c] - (setup_.rim.size() != 0 && setup_.rim.cells[c] ? rim_mm : inside_mm));
  return h;
}

Decision FinishTogether::decide(const Measurement& m) {
  Setup lower = setup_;
  lower.target = first_target();
  Mpc first(lower, options_);
  first.use_threads(parallel_);
  Decision d = first.decide(m);
  if (d.kind != Decision::Kind::kEnd) {
    d.reason += ", up to the last layers";
    return d;
  }
  const double layer_mm = kWander * setup_.model.layer_height_mm();
  double least = 0.0;
  std::optional<Decision> best;
  for (int n = 1; n <= options_.mpc.horizon; ++n) {
    ControlOptions o = options_;
    o.mpc.horizon = n;
    Mpc last(setup_, o);
    last.use_threads(parallel_);
    Decision found = last.decide(m);
    const double cost = found.objective_mm * found.objective_mm + n * layer_mm * layer_mm;
    if (best && (found.kind != Decision::Kind::kPrint || (best->kind == Decision::Kind::kPrint && cost >= least))) continue;
    best = std::move(found), least = cost;
  }
  return *best;
}

void FinishTogether::use_model(const deposition::DropletModel& model) {
  last_.use_model(model);
  setup_.model = model;
}

void FinishTogether::use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) {
  last_.use_models(inside, rim);
  setup_.model = inside, setup_.model_b = rim;
}

void FinishTogether::use_threads(const ParallelFor& parallel) {
  parallel_ = parallel;
  last_.use_threads(parallel);
}

}  // namespace firn::control
