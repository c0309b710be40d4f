#include "core/control/mpc/finish.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace firn::control {

FinishTogether::FinishTogether(const Setup& setup, const ControlOptions& options)
    : setup_(setup), options_(options), layer_mm_(setup.model.layer_height_mm()) {
  const double k = options.mpc.finish_layers;
  if (!(std::isfinite(k) && k >= 0.0)) throw std::invalid_argument("mpc: finish_layers = " + std::to_string(k) + " must not be below 0");
  Mpc(setup, options);  // refuses what MPC refuses
}

void FinishTogether::use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) {
  setup_.model = inside;
  setup_.model_b = rim;
}

HeightMap FinishTogether::first_target() const {
  HeightMap h = setup_.target;
  const double inside_mm = options_.mpc.finish_layers * layer_mm_;
  const bool has_rim = setup_.rim.size() != 0;
  const double rim_mm = has_rim ? inside_mm * setup_.model_b.layer_height_mm() / setup_.model.layer_height_mm() : 0.0;
  for (std::size_t c = 0; c < h.size(); ++c) h.cells[c] = std::max(0.0, h.cells[c] - (has_rim && setup_.rim.cells[c] ? rim_mm : inside_mm));
  return h;
}

Decision FinishTogether::decide(const Measurement& m) {
  Setup lower = setup_;
  lower.target = first_target();
  Mpc first(lower, options_);
  first.use_threads(parallel_);
  Decision d = first.decide(m);
  if (d.kind == Decision::Kind::kEnd) return last_layers(m);
  d.reason += ", for a target so many layers lower";
  return d;
}

Decision FinishTogether::last_layers(const Measurement& m) const {
  const double wander_mm = kWander * setup_.model.layer_height_mm();
  std::optional<Decision> best;
  double least = 0.0;
  for (int n = 1; n <= options_.mpc.horizon; ++n) {
    ControlOptions o = options_;
    o.mpc.horizon = n;
    Mpc mpc(setup_, o);
    mpc.use_threads(parallel_);
    Decision found = mpc.decide(m);
    const bool prints = found.kind == Decision::Kind::kPrint;
    const double cost = found.objective_mm * found.objective_mm + n * wander_mm * wander_mm;
    if (best && !(prints && (best->kind != Decision::Kind::kPrint || cost < least))) continue;
    best = std::move(found), least = cost;
  }
  return *std::move(best);
}

}  // namespace firn::control
