// Computes chapter 6 of Barnett (2012): flow along a straight path, its valve pulses, and frequency against
// width modulation.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>

#include "core/deposition/delivery.h"
#include "core/deposition/pulse_width.h"
#include "core/deposition/pulses.h"
#include "report/draw/charts.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

using namespace deposition;

constexpr double kStep = 0.016, kBoundary_mm = 1.5, kFill_mm = 3.0, kLayer_mm = 0.25, kFeedForward = 4.0;
constexpr double kDropsPerMm = 1.0, kTop = 125.0, kAcceleration = 500.0, kJerk = 4000.0;

// Rest to rest in minimum time under (4.10): ramps of 0.375 s with jerk, and top speed between them.
double commanded_speed(double t_s, double length_mm) {
  const double ramp = kTop / kAcceleration + kAcceleration / kJerk, rise = kAcceleration / kJerk;
  const double whole = length_mm / kTop + ramp;
  const double t = std::clamp(std::min(t_s, whole - t_s), 0.0, ramp);
  if (t <= rise) return 0.5 * kJerk * t * t;
  if (t <= ramp - rise) return 0.5 * kJerk * rise * rise + kAcceleration * (t - rise);
  return kTop - 0.5 * kJerk * (ramp - t) * (ramp - t);
}

FlowDemand straight(double length_mm, double width_mm) {
  FlowDemand d;
  d.step_s = kStep;
  const double whole = length_mm / kTop + kTop / kAcceleration + kAcceleration / kJerk;
  for (int n = 0; n <= int(std::ceil(whole / kStep)); ++n)
    d.speed_mm_s.push_back(commanded_speed(kStep * n, length_mm));
  d.flow_mm3_s.resize(d.speed_mm_s.size());
  nominal_flow(width_mm, kLayer_mm, d.speed_mm_s, d.flow_mm3_s);
  return d;
}

ValveSetting setting() { return {0.00125, FlowCurve::proportional(kFeedForward, 500.0)}; }

std::string beside(const std::vector<std::string>& charts, const char* title) {
  std::string s = fmt::format(
      "<svg viewBox=\"0 0 {} 330\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\"><title>{}</title>\n",
      440 * charts.size(), title);
  for (std::size_t n = 0; n < charts.size(); ++n)
    s += fmt::format("<svg x=\"{}\" y=\"0\" width=\"424\" height=\"330\">", 440 * n) + charts[n] + "</svg>\n";
  return s + "</svg>\n";
}

std::string chart(const std::vector<report::Series>& series, const std::string& y_name) {
  report::ChartOptions o;
  o.title = y_name;
  o.x_name = "τ = t / T";
  o.y_name = y_name;
  o.from_zero = true;
  return report::line_chart(series, o);
}

// Fig. 6-2 does not print its controller output: a smooth one between -0.3 and 0.4 replaces it.
double action(double tau) {
  return tau < 0.5 ? 0.4 * 4.0 * tau * (0.5 - tau) * 4.0 : -0.3 * 4.0 * (tau - 0.5) * (1.0 - tau) * 4.0;
}

// Integral of the valve's frequency along a path under the action, by a fine sum of its own; the path's
// samples take `duration_s`.
double pulses_by_integral(double length_mm, double width_mm, double duration_s) {
  constexpr int kParts = 200'000;
  double sum = 0.0;
  for (int k = 0; k < kParts; ++k) {
    const double tau = (k + 0.5) / kParts;
    sum += (1.0 + action(tau)) * commanded_speed(tau * duration_s, length_mm);
  }
  return kFeedForward * width_mm * kLayer_mm * sum * duration_s / kParts;
}

void figures(Reproduction& to) {
  const ValveLimits limits;
  const FlowDemand nominal = straight(100.0, kBoundary_mm);
  FlowDemand corrected = nominal;
  const std::size_t n = nominal.flow_mm3_s.size();
  std::vector<double> tau(n), u(n), nu_nominal(n), nu(n);
  for (std::size_t i = 0; i < n; ++i) {
    tau[i] = double(i) / double(n - 1);
    u[i] = action(tau[i]);
  }
  corrected_flow(nominal.flow_mm3_s, u, corrected.flow_mm3_s);
  for (std::size_t i = 0; i < n; ++i) {
    nu_nominal[i] = setting().curve.frequency_hz(nominal.flow_mm3_s[i]);
    nu[i] = setting().curve.frequency_hz(corrected.flow_mm3_s[i]);
  }
  const std::vector<double> needed = pulses_needed(nu, kStep);
  const PulsePlan plan = plan_pulses(corrected, setting(), limits);
  const auto& ticks = plan.trains.at(0).ticks;
  to.row(ReproduceRow("barnett.pulses.count", "(6.6): pulses of the 100 mm test path", "pulses",
                      double(ticks.size()), 0)
             .derives(std::ceil(pulses_by_integral(100.0, kBoundary_mm, corrected.duration_s()) - 0.5),
                      "errata", "(6.6): ceil(max n - 0.5), n the integral of the frequency over the path")
             .within_derived(0.0)
             .arithmetic());
  to.row(
      ReproduceRow(
          "barnett.pulses.rectangle", "(6.5) as printed less the integral, at top speed, as a length of path",
          "mm",
          (pulses_needed_as_printed(nu_nominal, kStep)[n / 2] - pulses_needed(nu_nominal, kStep)[n / 2]) /
              (nu_nominal[n / 2] / kTop))
          .derives(0.5 * kStep * kTop, "errata", "(6.5) is a sum of rectangles: half a sample at top speed")
          .within_derived(1e-6)
          .arithmetic());
  const report::Series c{"path speed c", tau, nominal.speed_mm_s, 0},
      output{"controller output u", tau, u, 0};
  const report::Series q_nominal{"nominal (6.2)", tau, nominal.flow_mm3_s, 0},
      q{"corrected (6.3)", tau, corrected.flow_mm3_s, 1};
  to.picture(
      {"fig-6-2", "Fig. 6-2: path speed, controller output (chosen) and flow of a straight path of 100 mm",
       beside({chart({c}, "speed [mm/s]"), chart({output}, "u"), chart({q_nominal, q}, "flow [mm3/s]")},
              "Fig. 6-2")});
  report::Series ttl{"TTL signal", {}, {}, 0};
  const double whole = corrected.duration_s();
  for (std::uint16_t tick : ticks) {
    const double t = tick * limits.tick_s;
    for (const auto& [at, level] : {std::pair{t, 0.0}, {t, 1.0}, {t + 0.00125, 1.0}, {t + 0.00125, 0.0}}) {
      if (at < 0.10 || at > 0.20) continue;
      ttl.x.push_back(at / whole);
      ttl.y.push_back(level);
    }
  }
  to.picture({"fig-6-3",
              "Fig. 6-3: frequency h(Q), pulses needed, and the TTL signal between 0.10 and 0.20 s",
              beside({chart({{"ν = h(Q)", tau, nu, 0}}, "frequency [Hz]"),
                      chart({{"n (6.5)", tau, needed, 0}}, "pulses needed"), chart({ttl}, "TTL")},
                     "Fig. 6-3")});
}

void delivery_rows(Reproduction& to) {
  const ValveLimits limits;
  const ValveSetting s = setting();
  std::string gaps;
  double widest = 0.0;
  for (const auto& [name, width, window] :
       {std::tuple{"boundary", kBoundary_mm, 70.0}, {"fill", kFill_mm, 35.0}}) {
    double worst = 0.0, gap = 0.0;
    for (double length = 71.0; length < 400.0; length += to.quick() ? 60.0 : 7.3) {
      const FlowDemand d = straight(length, width);
      const DeliveryError e =
          count_delivery(d, drops_of(plan_pulses(d, s, limits), d, s.curve, limits.tick_s),
                         granted_by(d, s.curve, limits.tick_s), window);
      worst = std::max(worst, e.window_worst);
      gap = std::max(gap, e.widest_gap_mm);
    }
    to.beside({fmt::format("barnett.pulses.window-{}", name),
               fmt::format("largest error of the volume of any {} mm of {}, by counting", window, name), "%",
               100.0 * worst});
    gaps += fmt::format("{}{} {:.2f} mm", gaps.empty() ? "" : ", ", name, gap);
    widest = std::max(widest, gap);
  }
  to.row(ReproduceRow("barnett.pulses.gap", "6.1: widest gap between drops", "", gaps)
             .prints("at least one drop should be deposited per millimeter", "p. 134, 6.1",
                     "at least one drop should be deposited per millimeter of path")
             .holds(widest <= 1.0, "<= 1 mm"));
}

// 6.3: hundreds of paths a layer.
void cost_row(Reproduction& to) {
  constexpr int kPaths = 300;
  const FlowDemand d = straight(300.0, kBoundary_mm);
  const std::clock_t before = std::clock();
  std::size_t pulses = 0;
  for (int n = 0; n < kPaths; ++n)
    for (const auto& train : plan_pulses(d, setting(), ValveLimits{}).trains) pulses += train.ticks.size();
  to.row(ReproduceRow("barnett.pulses.cost",
                      fmt::format("6.3: processor time for the valve data of {} paths of 300 mm, {} pulses",
                                  kPaths, pulses),
                      "s", double(std::clock() - before) / CLOCKS_PER_SEC, 3)
             .prints("less than five seconds", "p. 138, 6.3",
                     "Normally, these computations require less than five seconds")
             .not_identifiable("a time of the thesis's computer and Matlab programs"));
}

// Range: from the minimum to the maximum flow that keeps a drop per mm. Ideal valve: 200 mm^3/s while it is
// open.
void comparison_rows(Reproduction& to) {
  const ValveLimits limits;
  const ValveSetting fm = setting();
  const WidthModulation pwm = ideal_width_modulation(200.0, 0.008, limits);
  const double fm_top = max_flow_mm3_s(fm, limits), pwm_low = pwm.dose.points().front().y / pwm.period_s,
               pwm_top = pwm.dose.points().back().y / pwm.period_s;
  to.row(
      ReproduceRow("barnett.pulses.range-from-zero", "6.1: flow goes down to zero at rest", "",
                   fmt::format("FM 0 to {:.0f} mm3/s, PWM {:.1f} to {:.0f} mm3/s", fm_top, pwm_low, pwm_top))
          .prints("can be reduced to zero", "p. 134, 6.1",
                  "valve frequency, and by extension flow rate, can be reduced to zero")
          .holds(pwm_low > 0.0, "FM does, PWM does not"));
  const std::string fixed = fmt::format("pulses of {:.2f} ms", 1e3 * fm.pulse_s);
  for (double c : {125.0, 25.0, 5.0}) {
    const double fm_low = c * fm.curve.drop_mm3(1.0);
    to.beside({fmt::format("barnett.pulses.range-{:.0f}", c),
               fmt::format("most : least flow at {:.0f} mm/s with a drop per mm, {}", c, fixed), "",
               fmt::format("FM {:.1f}, PWM {:.1f}", fm_top / fm_low, pwm_top / pwm_low)});
    to.beside({fmt::format("barnett.pulses.drops-{:.0f}", c),
               fmt::format("drops per mm of a boundary at {:.0f} mm/s", c), "1/mm",
               fmt::format("FM {:.2f}, PWM {:.2f}", kFeedForward * kBoundary_mm * kLayer_mm,
                           1.0 / (pwm.period_s * c))});
  }
  const FlowDemand d = straight(100.0, kBoundary_mm);
  WidthModulation carry = pwm;
  carry.carry = true;
  const auto worst = [&](const std::vector<Drop>& drops) {
    return count_delivery(d, drops, {}, 0.0).worst_mm3;
  };
  const double of_fm = worst(drops_of(plan_pulses(d, fm, limits), d, fm.curve, limits.tick_s));
  const double of_pwm = worst(drops_of(plan_widths(d, pwm, limits))),
               of_carry = worst(drops_of(plan_widths(d, carry, limits)));
  to.beside({"barnett.pulses.error", "largest volume error along 100 mm of boundary from rest to rest", "mm3",
             fmt::format("FM {:.3f}, PWM {:.3f}, PWM with carry {:.3f}", of_fm, of_pwm, of_carry)});
}

}  // namespace

void reproduce_barnett_pulses(Reproduction& to) {
  to.note(
      "Chapter 6. The path is a straight one of 100 mm under (4.10), 1.175 s from rest to rest; the "
      "controller output of Fig. 6-2 is not "
      "printed and was chosen. Valve: 200 mm3/s while open (Table 2-2), so that c_ff = 4 Hz/(mm3/s) of 5.7 "
      "is a pulse of 1.25 ms; a "
      "straight frequency-flow line, as the table behind Fig. 6-1 is not printed either.");
  figures(to);
  to.progress(0.3, "counting drops");
  delivery_rows(to);
  cost_row(to);
  comparison_rows(to);
}

}  // namespace firn
