#include "drivers/gas/script_gas.h"

#include <cstdio>
#include <utility>

namespace firn::drivers {
namespace {

std::string shown_flows(const char* format, double a, double b) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

ScriptGas::ScriptGas(ScriptOptions script, GasOptions config)
    : ScriptDriver(std::move(script), {"set", "read"}, std::move(config)) {}

void ScriptGas::set(double atomizer_sccm, double sheath_sccm, std::int64_t now_us, Effects& fx) {
  if (accepts(fx)) {
    if (std::string why = refusal_of(atomizer_sccm, sheath_sccm); !why.empty()) {
      refuse(kGas, std::move(why), fx);
    } else {
      begin_command();
      acts();
      figure_ = {};
      wanted_sccm_ = {atomizer_sccm, sheath_sccm};
      first_ = atomizer_sccm < commanded_sccm_[kAtomizer] ? kAtomizer : kSheath;
      set_state(DeviceState::kActive, "flows change", fx);
      begin_step(Step::kFirst, now_us);
    }
  }
  pump(now_us, fx);
}

void ScriptGas::begin_step(Step step, std::int64_t now_us) {
  const auto n = std::size_t(step == Step::kFirst ? first_ : 1 - first_);
  step_ = step;
  commanded_sccm_[n] = wanted_sccm_[n];
  was_there_[n] = false;
  gone_since_us_[n] = 0;
  to_send_ = true;
  read_since_ = false;
  settle_until_us_ = now_us + std::int64_t((config_.settle_s + script().host_latency_s) * 1e6);
}

bool ScriptGas::work(std::int64_t now_us, Effects&) {
  if (std::exchange(to_send_, false)) {
    call(kSet, "set",
         {{"atomizer_sccm", {commanded_sccm_[kAtomizer]}}, {"sheath_sccm", {commanded_sccm_[kSheath]}}},
         now_us);
    return true;
  }
  if (now_us < next_read_us_) return false;
  call(kRead, "read", {}, now_us);
  return true;
}

void ScriptGas::returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
  if (tag == kSet) {
    next_read_us_ = now_us;
    return;
  }
  next_read_us_ = now_us + std::int64_t(config_.poll_s * 1e6);
  const auto sccm = line.values.find("sccm"), kpa = line.values.find("kpa");
  for (const auto& at : {sccm, kpa})
    if (at == line.values.end() || at->second.size() != 2)
      return wrong("read", "it returns no two numbers \"sccm\" and \"kpa\"", now_us, fx);
  for (std::size_t n = 0; n < 2; ++n) {
    flows_.sccm[n] = sccm->second[n];
    flows_.kpa[n] = kpa->second[n];
    flows_.set_sccm[n] = commanded_sccm_[n];
  }
  read_since_ = true;
  judge(now_us, fx);
  if (!stopping()) settle(now_us, fx);
}

void ScriptGas::stop_for(GasFault what, int n, const std::string& text, Figure figure, std::int64_t now_us,
                         Effects& fx) {
  flows_.fault[std::size_t(n)] = what;
  fault(Severity::kStop, kGas, std::string("gas: ") + name_of(n) + ": " + text, fx, figure);
  figure_ = std::move(figure);
  make_safe(text, kGas, now_us, fx);
}

void ScriptGas::judge(std::int64_t now_us, Effects& fx) {
  flows_.steady = there(kAtomizer) && there(kSheath) && step_ == Step::kNone;
  for (const int n : {kAtomizer, kSheath}) {
    const auto k = std::size_t(n);
    const bool flows = flows_.sccm[k] >= config_.lost_share * commanded_sccm_[k];  // NaN does not
    if (flows) gone_since_us_[k] = 0;
    if (flows && there(n)) {
      was_there_[k] = true;
      if (flows_.fault[k] == GasFault::kFlowLost) flows_.fault[k] = GasFault::kNone;
    }
    if (flows || !was_there_[k] || flows_.fault[k] != GasFault::kNone || stopping()) continue;
    if (gone_since_us_[k] == 0) gone_since_us_[k] = now_us;
    if (double(now_us - gone_since_us_[k]) < config_.lost_s * 1e6) continue;
    stop_for(GasFault::kFlowLost, n,
             shown_flows("%.3g of %.3g sccm flow: bottle, tube, valve?", flows_.sccm[k], commanded_sccm_[k]),
             {flows_.sccm[k] / commanded_sccm_[k], config_.lost_share, "", "gas.lost_share"}, now_us, fx);
  }
  const double kpa = flows_.kpa[kSheath];
  if (kpa <= config_.most_pressure_kpa) {
    if (flows_.fault[kSheath] == GasFault::kPressure) flows_.fault[kSheath] = GasFault::kNone;
  } else if (flows_.fault[kSheath] == GasFault::kNone && !stopping()) {
    stop_for(GasFault::kPressure, kSheath,
             shown_flows("%.1f kPa behind the nozzle, gas.most_pressure_kpa = %.5g: it clogs", kpa,
                         config_.most_pressure_kpa),
             {kpa, config_.most_pressure_kpa, "kPa", "gas.most_pressure_kpa"}, now_us, fx);
  }
  fx.measured<GasDriver>(flows_);
}

void ScriptGas::settle(std::int64_t now_us, Effects& fx) {
  if (step_ == Step::kNone || !read_since_) return;
  const int n = step_ == Step::kFirst ? first_ : 1 - first_;
  const auto k = std::size_t(n);
  if (there(n)) {
    if (step_ == Step::kFirst) return begin_step(Step::kSecond, now_us);
    step_ = Step::kNone;
    const bool flows = wanted_sccm_[kAtomizer] > 0.0;
    if (!flows) end_acting();
    set_state(flows ? DeviceState::kActive : DeviceState::kSafe, flows ? "gas flows" : "no atomizer gas", fx);
    return finish({}, fx);
  }
  if (now_us < settle_until_us_) return;
  const double share = flows_.sccm[k] / wanted_sccm_[k];
  stop_for(
      GasFault::kFlowLost, n,
      shown_flows("%.3g of %.3g sccm flow after gas.settle_s", flows_.sccm[k], wanted_sccm_[k]),
      {share, 1.0 + (share < 1.0 ? -1.0 : 1.0) * tolerance_sccm(n) / wanted_sccm_[k], "", "gas.tolerance"},
      now_us, fx);
}

Result ScriptGas::broken_off(Outcome outcome, std::int32_t code, std::string text) {
  Result r = ScriptDriver::broken_off(outcome, code, std::move(text));
  r.figure = figure_;
  return r;
}

void ScriptGas::became_safe(std::int64_t now_us, Effects&) {
  commanded_sccm_[kAtomizer] = wanted_sccm_[kAtomizer] = 0.0;
  step_ = Step::kNone;
  to_send_ = false;
  next_read_us_ = now_us;
}

void ScriptGas::program_lost(Effects&) {
  step_ = Step::kNone;
  to_send_ = false;
}

}  // namespace firn::drivers
