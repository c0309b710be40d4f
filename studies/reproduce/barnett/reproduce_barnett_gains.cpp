// Computes 5.4 to 5.7 of Barnett (2012): poles, stable gains, optimal gains and simulations of the
// one-dimensional SMF loop.
#include <fmt/core.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "estimators/gains/tune_smf.h"
#include "report/draw/charts.h"
#include "report/draw/raster.h"
#include "report/draw/svg.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

using namespace control::smf_line;
using gains::Algorithm;
using report::Series;

const std::string kPart = "barnett.gains.";
constexpr Gains kOptimum{0.99990, 0.32798, 0.00005}, kSimulated{1.0, 0.33, 0.03}, kUnstable{1.0, 0.33, 0.45};
constexpr Algorithm kAlgorithms[] = {Algorithm::kSlsqp, Algorithm::kLbfgs, Algorithm::kCobyla};

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * double(t.tv_sec) + 1e-6 * double(t.tv_nsec);
}

std::string panels(const std::vector<std::string>& charts, const char* title, int columns) {
  const int rows = (int(charts.size()) + columns - 1) / columns;
  std::string s = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\"><title>{}</title>\n",
      440 * columns, 335 * rows, title);
  for (int n = 0; n < int(charts.size()); ++n)
    s += fmt::format("<svg x=\"{}\" y=\"{}\" width=\"424\" height=\"330\">", 440 * (n % columns),
                     335 * (n / columns)) +
         charts[std::size_t(n)] + "</svg>\n";
  return s + "</svg>\n";
}

// The maximum pole over the volume of (5.25): its range along each axis and its minimum over each pair of
// axes.
struct Volume {
  explicit Volume(int steps) : n(steps), low(3 * std::size_t(n), NAN), high(3 * std::size_t(n), NAN) {
    for (auto& p : pair) p.assign(std::size_t(n) * std::size_t(n), NAN);
  }
  double gain(int axis, int i) const { return (axis == 0 ? 2.0 : axis == 1 ? 4.0 : 1.0) * (i + 0.5) / n; }
  void take(const std::array<int, 3>& at, double z) {
    worst = std::max(worst, z);
    ++points;
    for (int a = 0; a < 3; ++a) {
      double &l = low[std::size_t(a * n + at[std::size_t(a)])],
             &h = high[std::size_t(a * n + at[std::size_t(a)])];
      l = std::isnan(l) ? z : std::min(l, z);
      h = std::isnan(h) ? z : std::max(h, z);
      const int x = kPairs[a][0], y = kPairs[a][1];
      double& p = pair[std::size_t(a)][std::size_t(at[std::size_t(y)] * n + at[std::size_t(x)])];
      p = std::isnan(p) ? z : std::min(p, z);
    }
  }
  static constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  int n;
  std::vector<double> low, high;
  std::array<std::vector<double>, 3> pair;
  double worst = 0.0;
  std::int64_t points = 0;
};
constexpr const char* kAxisName[] = {"K_p", "K_i*", "K_d*"};

Volume volume(int steps) {
  Volume v(steps);
  for (int p = 0; p < steps; ++p)
    for (int i = 0; i < steps; ++i)
      for (int d = 0; d < steps; ++d) {
        const Gains g{v.gain(0, p), v.gain(1, i), v.gain(2, d)};
        if (0.5 * g.kp + 0.25 * g.ki_star + g.kd_star < 1.0) v.take({p, i, d}, largest_pole(g));
      }
  return v;
}

// The minimum z_max over a pair of gains: bands of a tenth, dark = small.
std::string pair_map(const Volume& v, int which) {
  const int x = Volume::kPairs[which][0], y = Volume::kPairs[which][1];
  report::Raster raster(v.n, v.n);
  for (int j = 0; j < v.n; ++j)
    for (int i = 0; i < v.n; ++i) {
      const double z = v.pair[std::size_t(which)][std::size_t(j * v.n + i)];
      if (std::isnan(z)) continue;
      const auto shade = [&](double dark, double light) {
        return std::uint8_t(dark + (light - dark) * std::floor(10.0 * std::min(z, 0.999)) / 9.0);
      };
      raster.at(i, v.n - 1 - j) = {shade(0, 255), shade(50, 235), shade(110, 150), 255};
    }
  const report::Frame f;
  const report::Axis ax(0.0, x == 0 ? 2.0 : 4.0, f.left, f.right, 5),
      ay(0.0, y == 1 ? 4.0 : 1.0, f.bottom, f.top, 5);
  return report::svg_open(424, 330, "least z_max") +
         report::svg_image(raster, f.left, f.top, f.right - f.left, f.bottom - f.top) +
         report::draw_axes(f, ax, ay, kAxisName[x], kAxisName[y]) +
         "<text class=\"label\" x=\"234\" y=\"315\" text-anchor=\"middle\" font-size=\"12\">least z_max, "
         "bands of 0.1: dark 0, light 1</text></svg>\n";
}

void figure_5_12(Reproduction& to) {
  const Volume v = volume(to.quick() ? 30 : 100);
  to.row(
      ReproduceRow(kPart + "fig-5-12",
                   fmt::format("Fig. 5-12: the largest pole at {} points of the volume (5.25)", v.points), "",
                   v.worst, 4)
          .prints(
              "always less than unity", "p. 117, 5.5",
              "the controller is indeed stable within the gain-stable volume, since $z_{p,\\text{max}}$ is "
              "always less than unity")
          .holds(v.worst < 1.0, "< 1"));
  to.row(ReproduceRow(kPart + "triple-pole", "5.5: largest pole at K_p = 1, K_i* = 1, K_d* = 0", "",
                      largest_pole({1, 1, 0}))
             .prints(0.0, "p. 117, 5.5", "produces a triple pole at z = 0")
             .within(1e-6)
             .arithmetic());
  to.row(ReproduceRow(kPart + "unstable-pole", "5.7: largest modulus of the poles of [1, 0.33, 0.45]", "",
                      largest_pole(kUnstable), 4)
             .prints(1.05, "p. 128, 5.7", "one of the poles of Eq.(5.22) having a module of 1.05")
             .within(5e-3)
             .derives(1.0482, "errata", "root of the denominator of (5.22), at -1.0482")
             .within_derived(5e-5)
             .arithmetic());
  std::vector<std::string> charts;
  for (int a = 0; a < 3; ++a) {
    Series low{"least", {}, {}, 0}, high{"largest", {}, {}, 1};
    for (int i = 0; i < v.n; ++i) {
      low.x.push_back(v.gain(a, i));
      high.x.push_back(v.gain(a, i));
      low.y.push_back(v.low[std::size_t(a * v.n + i)]);
      high.y.push_back(v.high[std::size_t(a * v.n + i)]);
    }
    report::ChartOptions o;
    o.title = "z_max";
    o.x_name = kAxisName[a];
    o.y_name = "z_max";
    o.y_range = std::pair(0.0, 1.0);
    charts.push_back(report::line_chart({low, high}, o));
    charts.push_back(pair_map(v, a));
  }
  to.picture({"fig-5-12", "Fig. 5-12: the largest pole over the gain-stable volume (5.25)",
              panels(charts, "Fig. 5-12", 2)});
}

void stability(Reproduction& to) {
  int stable_outside = 0, inside = 0;
  RandomStream random(5, Purpose::kTest);
  const int n = to.quick() ? 2'000 : 200'000;
  for (int k = 0; k < n; ++k) {
    const Gains g{random.uniform(-0.5, 2.5), random.uniform(-0.5, 4.5), random.uniform(-1.3, 1.3)};
    const bool sufficient =
        g.kp > 0 && g.ki_star > 0 && g.kd_star > 0 && 0.5 * g.kp + 0.25 * g.ki_star + g.kd_star < 1;
    stable_outside += stable(g) && !sufficient;
    inside += sufficient;
  }
  to.row(
      ReproduceRow(
          kPart + "sufficient",
          fmt::format(
              "(5.25), of {} random gains: stable ones that it leaves out, as a share of those it holds", n),
          "%", 100.0 * stable_outside / inside)
          .derives("sufficient, not necessary", "errata", "Jury's criterion for (5.22)")
          .holds(stable_outside > 0, "some"));
}

// Columns of Table 5-2 that depend on the algorithm: times, iterations and the optimality reached.
struct Table52 {
  const char *name, *thesis;  ///< "ms"; the thesis's algorithm
  Algorithm ours;
  const char *seconds, *iterations,
      *fonc;  ///< as printed, without and with the user's gradient, from each start
  const char* quote;
};
constexpr Table52 kTable52[] = {
    {"ms", "FMINUNC medium-scale", Algorithm::kLbfgs, "0.24 0.22 0.33 0.25", "14 14 45 45",
     "4.5×10^{-9} 4.9×10^{-9} 2.5×10^{-9} 2.5×10^{-9}",
     "0.24 0.22 0.33 0.25 14 14 45 45 no yes no yes 4.5×10^{-9} 4.9×10^{-9} 2.5×10^{-9} 2.5×10^{-9}"},
    {"ip", "FMINCON interior-point", Algorithm::kSlsqp, "0.47 0.43 0.50 0.45", "25 25 31 35",
     "4.8×10^{-9} 4.8×10^{-9} 1.9×10^{-9} 6.3×10^{-9}",
     "0.47 0.43 0.50 0.45 25 25 31 35 no yes no yes 4.8×10^{-9} 4.8×10^{-9} 1.9×10^{-9} 6.3×10^{-9}"}};

constexpr Gains kStarts[] = {{1, 1, 0}, {0, 0, 0.5}};

void table_5_2_columns(Reproduction& to, const Table52& t, std::span<const double> d) {
  std::string seconds, evaluations, fonc;
  double worst = 0.0;
  for (const Gains& start : kStarts) {
    std::array<double, 21> ms{};
    gains::TunedGains tuned;
    for (double& once : ms) {
      const double before = cpu_ms();
      tuned = gains::tune_smf(d, {t.ours, start});
      once = cpu_ms() - before;
    }
    std::nth_element(ms.begin(), ms.begin() + 10, ms.end());
    const char* space = seconds.empty() ? "" : " ";
    seconds += fmt::format("{}{:.6f}", space, 1e-3 * ms[10]);
    evaluations += fmt::format("{}{}", space, tuned.evaluations);
    fonc += fmt::format("{}{:.1e}", space, tuned.optimality);
    worst = std::max(worst, tuned.optimality);
  }
  const std::string id = kPart + "table-5-2." + t.name, what = fmt::format("Table 5-2, {}", t.thesis),
                    ours(gains::name(t.ours));
  constexpr const char* kPlace = "p. 126, Table 5-2";
  to.row(
      ReproduceRow(id + "-time", what + ": computational time; ours " + ours + ", median of 21", "s", seconds)
          .prints(t.seconds, kPlace, t.quote)
          .not_identifiable("a time of the thesis's computer and Matlab programs"));
  to.row(ReproduceRow(id + "-iterations", what + ": iterations; ours evaluations of " + ours, "", evaluations)
             .prints(t.iterations, kPlace, t.quote)
             .not_identifiable("iterations are of Matlab's own algorithms; NLopt counts evaluations"));
  to.row(ReproduceRow(id + "-fonc", what + ": FONC; ours " + ours, "", fonc)
             .prints(t.fonc, kPlace, t.quote)
             .holds(worst < 1e-8, "below the thesis's 1e-8, (5.36)")
             .arithmetic()
             .not_reproduced("NLopt ends where the gains no longer change, and not by the gradient"));
}

// Its optimum, which is the same for every algorithm and start.
void table_5_2(Reproduction& to) {
  const auto d = disturbance({100, 0.5, 60, 0.2, 30});
  double off = 0.0, off_printed = 0.0, sigma = 0.0;
  gains::TunedGains last;
  for (const Gains& start : kStarts)
    for (const Algorithm a : kAlgorithms) {
      const gains::TunedGains t = last = gains::tune_smf(d, {a, start});
      off = std::max({off, std::abs(t.gains.kp - kOptimum.kp), std::abs(t.gains.ki_star - kOptimum.ki_star),
                      std::abs(t.gains.kd_star - kOptimum.kd_star)});
      off_printed = std::max({off_printed, std::abs(t.gains.kp - 1.0), std::abs(t.gains.ki_star - 0.33),
                              std::abs(t.gains.kd_star)});
      sigma = std::max(sigma, t.rms);
    }
  constexpr const char* kOptimumPrinted =
      "the optimal value of the design vector found is $\\mathbf{k}_{\\text{opt}} = \\begin{bmatrix} 1 & "
      "0.33 & 0 "
      "\\end{bmatrix}^T$, with the value of the objective function being $\\sigma_p^* = 0.061$";
  constexpr const char* kPlace = "p. 125, Table 5-2";
  constexpr const char* kHow =
      "(5.27) minimised over the controller as corrected: e_1 = 0, no derivative at k = 1";
  const std::string of = " by SLSQP, L-BFGS and COBYLA from [1 1 0] and [0 0 0.5]";
  to.row(ReproduceRow(
             kPart + "table-5-2.gains", "Table 5-2: optimal gains" + of, "",
             fmt::format("[{:.5f} {:.5f} {:.5f}]", last.gains.kp, last.gains.ki_star, last.gains.kd_star))
             .prints("[1 0.33 0]", kPlace, kOptimumPrinted)
             .holds(off_printed < 5e-3, "each +- 0.005")
             .derives("[0.99990 0.32798 0.00005]", "errata", kHow)
             .also_derived(off < 1e-5, "each +- 1e-05")
             .arithmetic());
  to.row(ReproduceRow(kPart + "table-5-2.sigma", "Table 5-2: sigma_p*, the largest" + of, "", sigma, 6)
             .prints(0.061, kPlace, kOptimumPrinted)
             .within(5e-4)
             .derives(0.060990, "errata", kHow)
             .within_derived(1e-6)
             .arithmetic());
  for (const Table52& t : kTable52) table_5_2_columns(to, t, d);
  const auto larger = gains::tune_smf(disturbance({100, 0.5, 60, 0.5, 30}), {});
  to.row(ReproduceRow(kPart + "step-0.5", "5.6: K_i* with d_s = 0.5", "", larger.gains.ki_star, 6)
             .prints(0.618, "p. 126, 5.6", "For example, with $d_s = 0.5$, $K_i^* = 0.618$")
             .within(5e-4)
             .derives(0.618034, "errata",
                      "closed form at K_p = 1, K_d = 0: -q + sqrt(q^2 + 2 q), q = d_s^2 / (2 d_p^2)")
             .within_derived(1e-5)
             .arithmetic());
}

void table_5_3(Reproduction& to) {
  constexpr struct {
    double pulse, kd, sigma, kd_errata, sigma_errata;
  } kRows[] = {{0.5, 0.0, 0.061, 0.0, 0.0610},
               {0.25, 0.023, 0.038, 0.0224, 0.0384},
               {0.0, 0.126, 0.027, 0.1257, 0.0267},
               {-0.5, 0.0, 0.061, 0.0, 0.0610}};
  std::string kd, sigma;
  double kd_off = 0.0, kd_off_errata = 0.0, sigma_off = 0.0, sigma_off_errata = 0.0;
  for (const auto& r : kRows) {
    for (const Algorithm a : kAlgorithms)
      for (const double start : {0.0, 0.2}) {
        const auto t =
            gains::tune_smf(disturbance({100, r.pulse, 60, 0.2, 30}), {a, {1.0, 0.33, start}, true});
        kd_off = std::max(kd_off, std::abs(t.gains.kd_star - r.kd));
        sigma_off = std::max(sigma_off, std::abs(t.rms - r.sigma));
        if (a != Algorithm::kSlsqp || start != 0.0) continue;
        kd_off_errata = std::max(kd_off_errata, std::abs(t.gains.kd_star - r.kd_errata));
        sigma_off_errata = std::max(sigma_off_errata, std::abs(t.rms - r.sigma_errata));
        kd += fmt::format("{}{:.4f}", kd.empty() ? "" : " ", t.gains.kd_star);
        sigma += fmt::format("{}{:.4f}", sigma.empty() ? "" : " ", t.rms);
      }
  }
  constexpr const char* kQuote = "MS 0 0 0.023 0.126 0 0.061 0.038 0.027 0.061 0.5 0.25 0 -0.5";
  constexpr const char* kPlace = "p. 127, Table 5-3";
  constexpr const char* kHow = "(5.39) as corrected, K_p = 1, K_i* = 0.33";
  const std::string at = " at d_p = 0.5, 0.25, 0, -0.5, any algorithm and start";
  to.row(ReproduceRow(kPart + "table-5-3.kd", "Table 5-3: K_d*" + at, "", kd)
             .prints("0 0.023 0.126 0", kPlace, kQuote)
             .holds(kd_off <= 1e-3, "each +- 0.001")
             .derives("0.0000 0.0224 0.1257 0.0000", "errata", kHow)
             .also_derived(kd_off_errata <= 5e-5, "each +- 5e-05")
             .arithmetic());
  to.row(ReproduceRow(kPart + "table-5-3.sigma", "Table 5-3: sigma_p*" + at, "", sigma)
             .prints("0.061 0.038 0.027 0.061", kPlace, kQuote)
             .holds(sigma_off <= 5e-4, "each +- 0.0005")
             .derives("0.0610 0.0384 0.0267 0.0610", "errata", kHow)
             .also_derived(sigma_off_errata <= 5e-5, "each +- 5e-05")
             .arithmetic());
}

void figure_5_13(Reproduction& to) {
  Series mean{"mean sigma_p* over d_p = 0 .. 0.5", {}, {}, 0};
  double best = NAN, least = 1e9, until_006 = 0.0;
  for (int k = 0; k <= 300; ++k) {
    const double kd = 0.001 * k;
    double sum = 0.0;
    for (int p = 0; p <= 50; ++p)
      sum += spread({1.0, 0.33, kd}, disturbance({100, 0.01 * p, 60, 0.2, 30})).rms;
    mean.x.push_back(kd);
    mean.y.push_back(sum / 51);
    if (sum / 51 < least) {
      least = sum / 51;
      best = kd;
    }
    if (kd <= 0.06) until_006 = std::max(until_006, sum / 51);
  }
  to.row(ReproduceRow(kPart + "fig-5-13.best",
                      "Fig. 5-13: K_d* of the least mean sigma_p* over d_p in [0, 0.5]", "", best, 3)
             .prints(0.02, "p. 128, Fig. 5-13", "the optimal value of K_d^* being about 0.02")
             .within(0.01)
             .arithmetic());
  to.row(ReproduceRow(kPart + "fig-5-13.flat", "Fig. 5-13: rise of the mean within K_d* = [0, 0.06]", "%",
                      100.0 * (until_006 / least - 1.0))
             .prints("almost constant", "p. 128, Fig. 5-13",
                     "in the range [0, 0.06] could be used, since $\\overline{\\sigma_p^*}$ is almost "
                     "constant there")
             .at_most(3.0));
  report::ChartOptions o;
  o.title = "Fig. 5-13";
  o.x_name = "K_d*";
  o.y_name = "mean sigma_p* [intervals]";
  to.picture({"fig-5-13", "Fig. 5-13: the derivative gain over the expected pulses",
              panels({report::line_chart({mean}, o)}, "Fig. 5-13", 1)});
}

std::string simulation(const Gains& g, const DisturbanceModel& m, const char* title) {
  const auto d = disturbance(m);
  Series e{"e", {}, std::vector<double>(d.size()), 0}, u{"u", {}, std::vector<double>(d.size()), 1},
      dist{"d", {}, d, Series::kReference};
  simulate(g, d, e.y, u.y);
  for (std::size_t k = 0; k < d.size(); ++k) e.x.push_back(double(k + 1));
  u.x = dist.x = e.x;
  report::ChartOptions o;
  o.title = title;
  o.x_name = fmt::format("{}: interval k", title);
  o.y_name = "in intervals";
  o.whole_x = true;
  return report::line_chart({e, u, dist}, o);
}

// Maximum error of the last ten intervals.
double left_after(int intervals, const Gains& g, DisturbanceModel m) {
  m.intervals = intervals;
  const auto d = disturbance(m);
  std::vector<double> e(d.size());
  simulate(g, d, e);
  double largest = 0.0;
  for (std::size_t k = e.size() - 10; k < e.size(); ++k) largest = std::max(largest, std::abs(e[k]));
  return largest;
}

void figures_5_14_5_15(Reproduction& to) {
  constexpr DisturbanceModel kTable54[] = {{100, 0.5, 60, 0.2, 30, 0.0, 1, 1},
                                           {100, 0.5, 60, 0.2, 30, 0.05, 50, 1},
                                           {100, -2.0, 60, 0.0, 30, 0.0, 1, 1},
                                           {100, 0.0, 60, -2.0, 30, 0.0, 1, 1}};
  constexpr const char* kNames[] = {"(a) pulse 0.5, step 0.2", "(b) the same with noise 0.05", "(c) pulse -2",
                                    "(d) step -2"};
  constexpr double kMost[] = {1e-3, 0.05, 1e-3, 1e-3};  // (b) keeps its noise
  std::vector<std::string> charts;
  std::string left;
  bool corrected = true;
  for (int n = 0; n < 4; ++n) {
    charts.push_back(simulation(kSimulated, kTable54[n], kNames[n]));
    const double most = left_after(100, kSimulated, kTable54[n]);
    left += fmt::format("{}{:.1e}", n == 0 ? "" : ", ", most);
    corrected = corrected && most <= kMost[n];
  }
  to.row(ReproduceRow(
             kPart + "fig-5-14",
             "Fig. 5-14: largest error of the last ten intervals after (a) pulse 0.5, step 0.2; (b) the "
             "same with noise 0.05; (c) pulse -2; (d) step -2",
             "", left)
             .prints("rapidly corrects", "p. 128, Fig. 5-14",
                     "the SMF PID controller is stable and rapidly corrects any disturbances likely to be "
                     "encountered")
             .holds(corrected, "<= 0.001, (b) <= 0.05"));
  to.picture({"fig-5-14", "Fig. 5-14: simulations with K = [1, 0.33, 0.03], disturbances of Table 5-4",
              panels(charts, "Fig. 5-14", 2)});
  charts.clear();
  constexpr DisturbanceModel kTable55[] = {{100, 0.5, 60, 0.2, 30, 0.0, 1, 1},
                                           {100, 0.0, 60, 0.0, 30, 0.05, 50, 1}};
  charts.push_back(simulation(kUnstable, kTable55[0], "(a) pulse 0.5, step 0.2"));
  charts.push_back(simulation(kUnstable, kTable55[1], "(b) noise 0.05 from 50 on"));
  // The pole of modulus 1.048 multiplies an error by 110 in 100 intervals.
  const double a[] = {left_after(100, kUnstable, kTable55[0]), left_after(200, kUnstable, kTable55[0])};
  const double b[] = {left_after(100, kUnstable, kTable55[1]), left_after(200, kUnstable, kTable55[1])};
  to.row(ReproduceRow(kPart + "fig-5-15", "Fig. 5-15: with K = [1, 0.33, 0.45] the error grows without end",
                      "",
                      fmt::format("(a) {:.2f} intervals after 100, {:.0f} after 200; (b) {:.2f} and {:.1f}",
                                  a[0], a[1], b[0], b[1]))
             .prints("fails the Jury stability criterion", "p. 128, Fig. 5-15",
                     "This set of gains fails the Jury stability criterion")
             .holds(a[1] > 20.0 * a[0] && b[1] > 20.0 * b[0], "20 times larger after 100 more"));
  to.picture({"fig-5-15",
              "Fig. 5-15: simulations with the unstable gains [1, 0.33, 0.45], disturbances of Table 5-5",
              panels(charts, "Fig. 5-15", 2)});
}

}  // namespace

void reproduce_barnett_gains(Reproduction& to) {
  to.note(
      "One point of the surface, in units of the measurement interval: e_1 = 0, no derivative at the first "
      "interval, 100 intervals (errata.md). "
      "The thesis gives no seed for its noise; ours is drawn by Firn's own generator.");
  figure_5_12(to);
  to.progress(0.5, "poles over the gain-stable volume");
  stability(to);
  table_5_2(to);
  table_5_3(to);
  figure_5_13(to);
  figures_5_14_5_15(to);
}

}  // namespace firn
