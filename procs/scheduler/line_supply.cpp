// Platen and gas of the line loop: a warm platen and gas before all else, gas that flows evenly before a way,
// none behind the last one.
#include <algorithm>
#include <iterator>

#include "firn/gas_command_t.hpp"
#include "firn/heater_command_t.hpp"
#include "procs/scheduler/line_loop.h"

namespace firn {
namespace {

constexpr double kPlatenWarmUp_s = 3600.0;

}  // namespace

bool LineLoop::has_gas() const { return firn::on(experiment().gas.use); }
bool LineLoop::heats() const { return experiment().heater.platen_degC > drivers::kHeaterOff_degC; }

bool LineLoop::supplies(Phase phase) {
  return phase == Phase::kHeat || phase == Phase::kWarmUp || phase == Phase::kGas ||
         phase == Phase::kGasSettles;
}

// A stop has ended the atomizer's gas, and a platen may have cooled: both come before the phase that was
// interrupted.
void LineLoop::after_resume(Time now, Outbox& out) {
  gas_since_.reset();
  temperature_.reset();
  if (!supplies(interrupted_)) after_supply_ = interrupted_;
  proceed(Phase::kHeat, now, out);
}

bool LineLoop::enter_supply(Phase next, Time now, Outbox& out) {
  const GasConfig& gas = experiment().gas;
  switch (next) {
    case Phase::kHeat:
      heats() ? send_platen(now, out) : proceed(Phase::kGas, now, out);
      return true;
    case Phase::kWarmUp:
      out.wake_at(kDeadline, now.after_s(kPlatenWarmUp_s));
      act_on_temperature(now, out);
      return true;
    case Phase::kGas:
      has_gas() ? send_gas(gas.atomizer_sccm, sheath_share_ * gas.sheath_sccm, now, out) : supplied(now, out);
      return true;
    case Phase::kGasSettles: {
      const Time steady = gas_since_->after_s(gas.steady_s);
      if (after_supply_ != Phase::kRunPath || steady <= now)
        supplied(now, out);
      else
        out.wake_at(kGasSteady, steady);
      return true;
    }
    case Phase::kGasOff:
      has_gas() ? send_gas(0.0, 0.0, now, out) : end_print(out);
      return true;
    default:
      return false;
  }
}

bool LineLoop::supply_answered(Time now, Outbox& out) {
  switch (phase_) {
    case Phase::kHeat:
      proceed(Phase::kWarmUp, now, out);
      return true;
    case Phase::kGas:
      if (!gas_since_) gas_since_ = now;
      proceed(Phase::kGasSettles, now, out);
      return true;
    case Phase::kGasOff:
      end_print(out);
      return true;
    default:
      return false;
  }
}

void LineLoop::wake(TimerId timer, Time now, Outbox& out) {
  if (timer != kGasSteady) return Scheduler::wake(timer, now, out);
  if (phase_ == Phase::kGasSettles) supplied(now, out);
}

void LineLoop::on(const temperature_t& m, Time now, Outbox& out) {
  temperature_ = m;
  if (phase_ == Phase::kWarmUp) act_on_temperature(now, out);
}

// A platen that cools later is the heater driver's to stop (I10).
void LineLoop::act_on_temperature(Time now, Outbox& out) {
  if (!temperature_ || !(temperature_->degC[0] >= experiment().heater.low_degC)) return;
  out.cancel(kDeadline);
  proceed(Phase::kGas, now, out);
}

std::string LineLoop::awaited() const {
  if (phase_ == Phase::kWarmUp) return "the platen is not above heater.low_degC";
  if (phase_ == Phase::kRunPath) return "no followed path of layer " + std::to_string(layers_done_ + 1);
  if (!has_profiler_) return "no plan for the pictures of layer " + std::to_string(layers_done_);
  return ScanLoop::awaited();
}

void LineLoop::send_platen(Time now, Outbox& out) {
  heater_command_t c{};
  c.verb = std::int8_t(HeaterVerb::kSet);
  std::fill(std::begin(c.set_degC), std::end(c.set_degC), drivers::kHeaterOff_degC);
  c.set_degC[0] = experiment().heater.platen_degC;
  stamp(c, NodeId::kHeater, 10.0, now, out);
  out.send(channels::kHeaterCommand, c);
}

void LineLoop::send_gas(double atomizer_sccm, double sheath_sccm, Time now, Outbox& out) {
  gas_command_t c{};
  c.verb = std::int8_t(GasVerb::kSet);
  c.attempt = scan_attempt_;
  c.atomizer_sccm = atomizer_sccm;
  c.sheath_sccm = sheath_sccm;
  stamp(c, NodeId::kGas, 2.0 * experiment().gas.settle_s, now, out);  // one flow after the other
  out.send(channels::kGasCommand, c);
}

void LineLoop::end_print(Outbox& out) {
  finish_run(RunOutcome::kFinished, 0, plan_ ? plan_->reason : std::string(), out);
}

}  // namespace firn
