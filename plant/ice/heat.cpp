#include "plant/ice/heat.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plant/ode/cvode.h"

namespace firn::plant {
namespace {

constexpr int kStates = 7, kRoots = 5;

struct Input {
  const IceHeatParams* params = nullptr;
  std::array<double, 3> power_W{};
  double valve_W = 0.0;
  std::array<double, 2> coil_goal{}, tau_s{}, flow_mm3_s{};
  std::array<double, 3> threshold_degC{};
};

int heat_rates(sunrealtype, N_Vector y_vector, N_Vector rate_vector, void* user) {
  const auto& in = *static_cast<const Input*>(user);
  const IceHeatParams& p = *in.params;
  const sunrealtype* y = NV_DATA_S(y_vector);
  sunrealtype* rate = NV_DATA_S(rate_vector);
  const double ab = p.link_W_K[0] * (y[0] - y[1]), bc = p.link_W_K[1] * (y[1] - y[2]);
  const double flow_in[3] = {-ab, ab - bc, bc};
  for (std::size_t n = 0; n < 3; ++n)
    rate[n] = (in.power_W[n] - p.loss_W_K[n] * (y[n] - p.ambient_degC) + flow_in[n]) / p.capacity_J_K[n];
  for (std::size_t v = 0; v < 2; ++v) {
    rate[3 + v] = (in.coil_goal[v] - y[3 + v]) / in.tau_s[v];
    rate[5 + v] = -in.flow_mm3_s[v];
  }
  return 0;
}

int roots(sunrealtype, N_Vector y_vector, sunrealtype* g, void* user) {
  const auto& in = *static_cast<const Input*>(user);
  const sunrealtype* y = NV_DATA_S(y_vector);
  for (int n = 0; n < 3; ++n) g[n] = y[n] - in.threshold_degC[std::size_t(n)];
  for (int v = 0; v < 2; ++v) g[3 + v] = y[5 + v];
  return 0;
}

}  // namespace

// Each step starts afresh (rates and relays jump), so the seven numbers are the whole of its state.
struct Heat::Solver {
  Input input;
  Cvode cvode{"heat", kStates, heat_rates, &input};
  N_Vector tolerance = N_VNew_Serial(kStates, cvode.context);

  explicit Solver(const IceHeatParams* params) {
    input.params = params;
    for (int n = 0; n < kStates; ++n) NV_Ith_S(tolerance, n) = n < 3 ? 1e-6 : n < 5 ? 1e-9 : 1e-3;
    cvode.require(CVodeSVtolerances(cvode.memory, 1e-8, tolerance), "CVodeSVtolerances");
    cvode.require(CVodeRootInit(cvode.memory, kRoots, roots), "CVodeRootInit");
    cvode.require(CVodeSetNoInactiveRootWarn(cvode.memory), "CVodeSetNoInactiveRootWarn");
  }
  ~Solver() { N_VDestroy(tolerance); }
};

Heat::Heat(const IceWorldConfig& config) : params_(config.heat), set_degC_(config.heat.set_degC) {
  state_.section_degC.fill(params_.start_degC);
  for (std::size_t v = 0; v < 2; ++v) {
    gain_per_hz_[v] = config.line[v].coil_gain / 500.0;
    tau_s_[v] = config.line[v].coil_tau_s;
    state_.tank_mm3[v] = config.line[v].tank_mm3;
  }
  obey_thermostats();
}
Heat::~Heat() = default;
Heat::Heat(Heat&&) noexcept = default;
Heat& Heat::operator=(Heat&&) noexcept = default;

double Heat::shown_degC(int n) const {
  const auto at = std::size_t(n);
  if (open_[at]) return std::numeric_limits<double>::quiet_NaN();
  return frozen_[at] ? frozen_degC_[at] : state_.section_degC[at];
}

void Heat::set(int n, double degC) {
  set_degC_[std::size_t(n)] = degC;
  obey_thermostats();
}
void Heat::open_thermocouple(int n, bool open) {
  open_[std::size_t(n)] = open;
  obey_thermostats();
}
void Heat::stick_relay(int n, bool stuck) {
  stuck_[std::size_t(n)] = stuck;
  obey_thermostats();
}

void Heat::freeze_reading(int n, bool frozen) {
  frozen_[std::size_t(n)] = frozen;
  frozen_degC_[std::size_t(n)] = state_.section_degC[std::size_t(n)];
  obey_thermostats();
}

// Between the thresholds a relay stays as it is; a controller without a thermocouple switches off.
void Heat::obey_thermostats() {
  for (std::size_t n = 0; n < 3; ++n) {
    const bool before = relay_[n];
    const double t = frozen_[n] ? frozen_degC_[n] : state_.section_degC[n];
    if (stuck_[n])
      relay_[n] = true;
    else if (open_[n] || t >= set_degC_[n] + params_.hysteresis_K)
      relay_[n] = false;
    else if (t <= set_degC_[n] - params_.hysteresis_K)
      relay_[n] = true;
    switchings_ += relay_[n] != before;
  }
}

void Heat::advance(std::int64_t t_us) {
  const double span_s = double(t_us - at_us_) * 1e-6;
  if (span_s <= 0.0) return;
  if (!solver_) solver_ = std::make_unique<Solver>(&params_);
  Input& in = solver_->input;
  in.params = &params_;
  in.tau_s = tau_s_;
  for (std::size_t v = 0; v < 2; ++v) {
    in.coil_goal[v] = gain_per_hz_[v] * double(pulses_[v]) / span_s;
    in.flow_mm3_s[v] = flown_mm3_[v] / span_s;
  }
  in.valve_W = params_.valve_J_per_pulse * double(pulses_[0] + pulses_[1]) / span_s;
  for (double left_s = span_s; left_s > 0.0;) {
    const double now_s = std::min(left_s, kStep_s);
    step(now_s);
    left_s = left_s - now_s > 1e-9 ? left_s - now_s : 0.0;
  }
  pulses_ = {};
  flown_mm3_ = {};
  at_us_ = t_us;
}

void Heat::step(double span_s) {
  Input& in = solver_->input;
  const Cvode& cvode = solver_->cvode;
  sunrealtype* y = NV_DATA_S(cvode.y);
  double at_s = 0.0;
  while (at_s < span_s) {
    for (std::size_t n = 0; n < 3; ++n) {
      in.power_W[n] = relay_[n] && !broken_[n] ? params_.heater_W[n] : 0.0;
      const bool watched = !stuck_[n] && !open_[n] && !frozen_[n];
      in.threshold_degC[n] = !watched    ? 1e6
                             : relay_[n] ? set_degC_[n] + params_.hysteresis_K
                                         : set_degC_[n] - params_.hysteresis_K;
      y[n] = state_.section_degC[n];
    }
    y[3] = state_.coil[0];
    y[4] = state_.coil[1];
    y[5] = state_.tank_mm3[0];
    y[6] = state_.tank_mm3[1];
    for (std::size_t v = 0; v < 2; ++v)
      if (state_.tank_mm3[v] <= 0.0) in.flow_mm3_s[v] = 0.0;
    in.power_W[0] += in.valve_W;
    cvode.require(CVodeReInit(cvode.memory, at_s, cvode.y), "CVodeReInit");
    cvode.require(CVodeSetStopTime(cvode.memory, span_s), "CVodeSetStopTime");
    sunrealtype reached = at_s;
    const int flag = CVode(cvode.memory, span_s, cvode.y, &reached, CV_NORMAL);
    cvode.require(flag, "CVode");
    state_ = {{y[0], y[1], y[2]}, {y[3], y[4]}, {y[5], y[6]}};
    if (flag == CV_ROOT_RETURN) {
      int found[kRoots];
      cvode.require(CVodeGetRootInfo(cvode.memory, found), "CVodeGetRootInfo");
      for (std::size_t n = 0; n < 3; ++n)  // on the threshold to rounding: switch for certain
        if (found[n] != 0) {
          relay_[n] = !relay_[n];
          ++switchings_;
        }
      for (std::size_t v = 0; v < 2; ++v)
        if (found[3 + v] != 0) state_.tank_mm3[v] = 0.0;
    }
    at_s = reached;
  }
}

void Heat::io(Archive& a) {
  a.all(state_, relay_, broken_, open_, stuck_, frozen_, frozen_degC_, set_degC_, pulses_, flown_mm3_, at_us_,
        switchings_);
}

}  // namespace firn::plant
