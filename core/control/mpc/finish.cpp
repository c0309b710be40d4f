#include "core/control/mpc/finish.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace firn::control {

FinishTogether::FinishTogether(const Setup& setup, const ControlOptions& options)
    : setup_(setup), options_(options), last_(setup, options) {
  const double k = options.mpc.finish_layers;
  if (!(std::isfinite(k) && k >= 0.0)) throw std::invalid_argument("mpc: finish_layers = " + std::to_string(k) + " must not be below 0");
}

HeightMap FinishTogether::first_target() const {
  HeightMap h = setup_.target;
  const double inside_mm = options_.mpc.finish_layers * setup_.model.layer_height_mm();
  const double rim_mm = options_.mpc.finish_layers * setup_.model_b.layer_height_mm();
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
  if (d.kind == Decision::Kind::kEnd) return last_.decide(m);
  d.reason += ", up to the last layers";
  return d;
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
