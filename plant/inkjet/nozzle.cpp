#include "plant/inkjet/nozzle.h"

#include <cmath>

#include "core/grid/random.h"
#include "plant/ode/cvode.h"

namespace firn::plant {
namespace {

struct NozzleInput {
  const NozzleParams* params;
  double drops_per_s = 0.0;
  double target = 0.0;
};

int nozzle_rates(sunrealtype, N_Vector y_vector, N_Vector rate_vector, void* user) {
  const auto& in = *static_cast<const NozzleInput*>(user);
  const NozzleParams& p = *in.params;
  const sunrealtype* y = NV_DATA_S(y_vector);
  sunrealtype* rate = NV_DATA_S(rate_vector);
  rate[0] = -y[0] / p.pressure_tau_s - p.pressure_per_drop * in.drops_per_s;
  rate[1] = p.wetting_per_drop * in.drops_per_s * (1.0 - y[1]) - y[1] / p.wetting_tau_s;
  rate[2] = p.heating_per_drop_K * in.drops_per_s - y[2] / p.heating_tau_s;
  rate[3] = (in.target - y[3]) / p.wander_tau_s;
  return 0;
}

}  // namespace

// Every step starts afresh (the input jumps), so the state vector is all there is to save.
struct Nozzle::Solver {
  NozzleInput input;
  Cvode cvode{"nozzle", 4, nozzle_rates, &input};

  explicit Solver(const NozzleParams* params) : input{params} {
    cvode.require(CVodeSStolerances(cvode.memory, 1e-6, 1e-9), "CVodeSStolerances");
  }
};

Nozzle::Nozzle(const NozzleParams& params, std::uint64_t seed, std::uint32_t number)
    : params_(params), seed_(seed), number_(number) {}
Nozzle::~Nozzle() = default;
Nozzle::Nozzle(Nozzle&&) noexcept = default;
Nozzle& Nozzle::operator=(Nozzle&&) noexcept = default;

double Nozzle::fire(std::int64_t now_us) {
  if (!params_.drift) return 1.0;
  if (double(now_us - at_us_) * 1e-6 >= params_.step_s) advance(now_us);
  ++drops_;
  return factor_;
}

void Nozzle::cured(std::int64_t now_us, std::uint32_t layer) {
  if (!params_.drift) return;
  advance(now_us);
  const double keep = params_.wander_memory;
  target_ = keep * target_ + std::sqrt(1.0 - keep * keep) * params_.wander_sigma *
                                 random_normal({seed_, Purpose::kNozzleDrift, layer, number_, 0});
}

void Nozzle::advance(std::int64_t now_us) {
  const double span_s = double(now_us - at_us_) * 1e-6;
  if (span_s <= 0.0) return;
  if (!solver_) solver_ = std::make_unique<Solver>(&params_);
  solver_->input = {&params_, double(drops_) / span_s, target_};
  const Cvode& cvode = solver_->cvode;
  sunrealtype* y = NV_DATA_S(cvode.y);
  y[0] = state_.pressure;
  y[1] = state_.wetting;
  y[2] = state_.heating_K;
  y[3] = state_.wander;
  cvode.require(CVodeReInit(cvode.memory, 0.0, cvode.y), "CVodeReInit");
  cvode.require(CVodeSetStopTime(cvode.memory, span_s), "CVodeSetStopTime");
  sunrealtype reached = 0.0;
  cvode.require(CVode(cvode.memory, span_s, cvode.y, &reached, CV_NORMAL), "CVode");
  state_ = {y[0], y[1], y[2], y[3]};
  at_us_ = now_us;
  drops_ = 0;
  factor_ = 1.0 + state_.pressure + params_.wetting_effect * state_.wetting +
            params_.heating_effect_per_K * state_.heating_K + state_.wander;
}

}  // namespace firn::plant
