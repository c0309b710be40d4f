#include "plant/aerosol/source.h"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/grid/random.h"
#include "plant/ode/sun_comm.h"

namespace firn::plant {
namespace {

constexpr double kSlowStep_s = 0.5;
constexpr double kMinGas = 0.01;  // of the nominal: below, no mist leaves
constexpr double kSecondsPerHour = 3600.0;

struct SourceInput {
  double output = 1.0, tube_s = 1.0, clog_per_s = 0.0;
  double emptied_per_s = 0.0, level_loss = 0.0, settles_per_s = 0.0;  // of slow_rates
};

int source_rates(sunrealtype, N_Vector y_vector, N_Vector rate_vector, void* user) {
  const auto& in = *static_cast<const SourceInput*>(user);
  const sunrealtype* y = NV_DATA_S(y_vector);
  sunrealtype* rate = NV_DATA_S(rate_vector);
  rate[0] = (in.output - y[0]) / in.tube_s;
  rate[1] = in.clog_per_s * y[0] * (1.0 - y[1]);
  return 0;
}

// The same with level and tube: four states. The two above keep their bytes where these are off.
int slow_rates(sunrealtype, N_Vector y_vector, N_Vector rate_vector, void* user) {
  const auto& in = *static_cast<const SourceInput*>(user);
  const sunrealtype* y = NV_DATA_S(y_vector);
  sunrealtype* rate = NV_DATA_S(rate_vector);
  const double level = std::max(0.0, y[2]), passes = y[0] * (1.0 - y[3]);
  rate[0] = (in.output * (1.0 - in.level_loss * (1.0 - level)) - y[0]) / in.tube_s;
  rate[1] = in.clog_per_s * passes * (1.0 - y[1]);
  rate[2] = level > 0.0 ? -in.emptied_per_s * y[0] : 0.0;
  rate[3] = in.settles_per_s * passes;
  return 0;
}

void succeeded(int flag, const char* call) {
  if (flag < 0)
    throw std::runtime_error(std::string("aerosol source: ") + call + " failed, flag " +
                             std::to_string(flag));
}

}  // namespace

double beam_sigma_mm(double nozzle_mm, double r) {
  return 0.25 * nozzle_mm * std::sqrt(1.0 - std::sqrt(r / (1.0 + r)));
}

// Every step starts afresh, so the states are all there is to save.
struct Source::Solver {
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  SUNNonlinearSolver iteration = nullptr;
  void* cvode = nullptr;
  SourceInput input;

  explicit Solver(bool slow) {
    succeeded(SUNContext_Create(SUN_COMM_NULL, &context), "SUNContext_Create");
    y = N_VNew_Serial(slow ? 4 : 2, context);
    N_VConst(0.0, y);
    cvode = CVodeCreate(CV_ADAMS, context);
    succeeded(CVodeInit(cvode, slow ? slow_rates : source_rates, 0.0, y), "CVodeInit");
    succeeded(CVodeSStolerances(cvode, 1e-8, 1e-10), "CVodeSStolerances");
    iteration = SUNNonlinSol_FixedPoint(y, 0, context);
    succeeded(CVodeSetNonlinearSolver(cvode, iteration), "CVodeSetNonlinearSolver");
    succeeded(CVodeSetUserData(cvode, &input), "CVodeSetUserData");
  }
  ~Solver() {
    CVodeFree(&cvode);
    SUNNonlinSolFree(iteration);
    N_VDestroy(y);
    SUNContext_Free(&context);
  }
};

Source::Source(const AerosolParams& params, std::uint64_t seed)
    : params_(params), seed_(seed), gas_(params.gas ? 0.0 : 1.0), since_us_(params.gas ? -1 : 0) {
  mist_ = atomizer(0);
}
Source::~Source() = default;
Source::Source(Source&&) noexcept = default;
Source& Source::operator=(Source&&) noexcept = default;

// The random part is drawn at fixed times and goes linearly between them.
double Source::atomizer(std::int64_t t_us) const {
  if (since_us_ < 0) return 0.0;
  const double t = double(t_us) * 1e-6, place = t / params_.wander_s, whole = std::floor(place);
  const auto draw = [&](double n) {
    return random_normal({seed_, Purpose::kDisturbance, 40, 0, std::uint32_t(std::max(0.0, n))});
  };
  const double wander =
      params_.wander > 0.0
          ? params_.wander * (draw(whole) + (place - whole) * (draw(whole + 1.0) - draw(whole)))
          : 0.0;
  const double ran_s = std::max(0.0, t - double(since_us_) * 1e-6);
  return gas_ * std::max(0.0, 1.0 + params_.drift * std::min(1.0, ran_s / params_.drift_s) + wander);
}

void Source::supply(const GasSupply& gas) {
  gas_ = gas.atomizer;
  open_share_ = gas.open_share;
  if (since_us_ < 0 && gas_ > kMinGas) since_us_ = at_us_;
}

void Source::advance(std::int64_t t_us) {
  const double span_s = double(t_us - slow_us_) * 1e-6;
  if (span_s <= 0.0) return;
  const bool slow = drifts_slowly();
  if (!solver_) solver_ = std::make_unique<Solver>(slow);
  solver_->input = {
      atomizer((slow_us_ + t_us) / 2), params_.tube_s,     params_.clog_per_h / kSecondsPerHour,
      params_.flow / params_.vial_s,   params_.level_loss, params_.tube_per_h / kSecondsPerHour};
  sunrealtype* y = NV_DATA_S(solver_->y);
  y[0] = mist_;
  y[1] = clog_;
  if (slow) {
    y[2] = level_;
    y[3] = settles_;
  }
  succeeded(CVodeReInit(solver_->cvode, 0.0, solver_->y), "CVodeReInit");
  succeeded(CVodeSetStopTime(solver_->cvode, span_s), "CVodeSetStopTime");
  sunrealtype reached = 0.0;
  succeeded(CVode(solver_->cvode, span_s, solver_->y, &reached, CV_NORMAL), "CVode");
  mist_ = y[0];
  clog_ = y[1];
  if (slow) {
    level_ = std::max(0.0, y[2]);
    settles_ = y[3];
  }
  slow_us_ = t_us;
}

double Source::flow_mm3_s() const { return params_.flow_mm3_s * flow_share(); }

void Source::switch_shutter(bool open, std::int64_t t_us) {
  commanded_ = open;
  const double delay_s = open ? params_.open_delay_s : params_.close_delay_s;
  const std::int64_t effect_us = t_us + std::llround(delay_s * 1e6);
  changes_.push_back({std::max(effect_us, changes_.empty() ? effect_us : changes_.back().t_us), open});
}

std::int64_t Source::next_change_us() const {
  return changes_.empty() ? std::numeric_limits<std::int64_t>::max() : changes_.front().t_us;
}

Given Source::step(std::int64_t t_us) {
  const double dt = double(t_us - at_us_) * 1e-6;
  Given g;
  if (dt > 0.0) {
    while (double(t_us - slow_us_) * 1e-6 >= kSlowStep_s) advance(slow_us_ + std::llround(kSlowStep_s * 1e6));
    const double ink = flow_mm3_s() * dt, goal = target_ ? 1.0 : 0.0;
    // Mean of the opening over the step.
    const double decay = std::exp(-dt / params_.tail_s);
    const double mean = goal + (opening_ - goal) * (1.0 - decay) * params_.tail_s / dt;
    opening_ = goal + (opening_ - goal) * decay;
    const double most = params_.blob_s * params_.flow_mm3_s, before = gathered_mm3_;
    if (target_)
      gathered_mm3_ *= std::exp(-dt / params_.release_s);
    else
      gathered_mm3_ = std::min(most - (most - gathered_mm3_) * std::exp(-dt / params_.gather_s),
                               gathered_mm3_ + (1.0 - mean) * ink);
    const double released = std::max(0.0, before - gathered_mm3_);
    g.passed_mm3 = mean * ink + released;
    g.kept_mm3 = ink - mean * ink - (gathered_mm3_ - before) - released;
    at_us_ = t_us;
  }
  while (!changes_.empty() && changes_.front().t_us <= t_us) {
    target_ = changes_.front().open;
    changes_.pop_front();
  }
  return g;
}

void Source::io(Archive& a) {
  a.all(mist_, clog_, slow_us_, gas_, open_share_, since_us_, commanded_, target_, opening_, gathered_mm3_,
        changes_, at_us_);
  if (drifts_slowly()) a.all(level_, settles_);
}

}  // namespace firn::plant
