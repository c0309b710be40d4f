// Motion along curves that nobody tuned the planner for, as users have them: sampled at 0.05 to 2 mm, rounded
// to 3, 4 or 9 decimals, with tolerances of 0.005 to 0.1 mm.
//
// - `motion_paths [CURVES] [SEED] [KIND]`: for each kind of curve, or for one: duration over the best of all
// tiers, its growth with a larger tolerance and with denser sampling (of all curves, and of those whose
// samples' polygon leaves them by at most half the tolerance: others are not told by their samples), the
// lower bound's share, deviation / tolerance, and the largest ratio to a limit. CURVES are drawn in all,
// default 200.
// - `motion_paths nasty N [SEED]`: N random paths (cusps, tiny and repeated steps, zigzags, near full reach)
// with tolerances of 0 and 0.005 to 0.1 mm: refusals by reason, deviation / tolerance, largest ratio to a
// limit at any instant by interval arithmetic
// - `motion_paths held N [SEED] [nasty]`: N paths whose points are held, or of those above: largest distance
// of a point over its rounding, what dense sampling finds beyond the distances told, largest ratio to a limit
// - `motion_paths rounded N [SEED]`: duration with held samples of three decimals over that with nine, of N
// curves of each kind, 0.01 to 1 mm apart, and of N epicycloids by 500 to 8,000 equal parameters; then that
// with samples of three decimals whose chords leave the curves by up to 0.005 to 0.05 mm over 0.1 mm apart
// - `motion_paths nlp [CURVES] [SEED] [KIND]`: durations of both tiers over the optimum on the same curve by
// direct transcription (tests/core/motion/time_transcription.h), and the lower bound over that optimum
// - `motion_paths one KIND SEED STEP DECIMALS TOLERANCE`: durations of one path
//
// Long tables may be had in parts, by kinds and by seeds. With MOTION_PATHS_VERBOSE set, each curve is
// printed when it is done.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "core/motion/certified/certified.h"
#include "core/motion/planner.h"
#include "tests/bench/bench.h"
#include "tests/core/motion/continuous_checker.h"
#include "tests/core/motion/emitted_ratio.h"
#include "tests/core/motion/held_paths.h"
#include "tests/core/motion/random_paths.h"
#include "tests/core/motion/sampled_curves.h"
#include "tests/core/motion/time_transcription.h"

namespace firn::bench::motion_paths {

namespace {

using namespace firn;
using namespace firn::motion;

constexpr Point2 kPart{400.0, 0.0};

struct Summary {
  std::vector<double> value;
  void add(double v) { value.push_back(v); }
  double mean() const {
    double sum = 0.0;
    for (const double v : value) sum += v;
    return value.empty() ? 0.0 : sum / double(value.size());
  }
  double most() const { return value.empty() ? 0.0 : *std::max_element(value.begin(), value.end()); }
  void merge(const Summary& o) { value.insert(value.end(), o.value.begin(), o.value.end()); }
};

struct Kind {
  Summary over_best, wider, denser, told, bound, off, ratio;
  int refused = 0;
  void merge(const Kind& o) {
    over_best.merge(o.over_best);
    wider.merge(o.wider);
    denser.merge(o.denser);
    told.merge(o.told);
    bound.merge(o.bound);
    off.merge(o.off);
    ratio.merge(o.ratio);
    refused += o.refused;
  }
};

class Planner {
 public:
  PlanResult operator()(const std::vector<Point2>& points, double tolerance_mm, int decimals, Method method) {
    PathInput input;
    input.points = points;
    input.origin = kPart;
    PlanOptions options;
    options.method = method;
    options.tolerance_mm = tolerance_mm;
    options.point_noise_mm = 0.5 * std::pow(10.0, -decimals);
    return plan(input, *arm_, cobra600_limits(), options, work_);
  }

 private:
  std::unique_ptr<Arm> arm_ = make_scara(cobra600());
  PlanWorkspace work_;
};

double largest(const PlanResult& result) {
  double most = 0.0;
  for (const LimitRatio& l : result.trajectory.certificate.limits) most = std::max(most, l.ratio);
  return most;
}

/// Largest distance of a curve from the polygon of its samples.
double missed_mm(const ParametricCurve& curve, const std::vector<Point2>& points) {
  constexpr int kFine = 20000, kAhead = 3;
  double most = 0.0;
  std::size_t from = 0;
  for (int i = 0; i <= kFine; ++i) {
    const Point2 p = curve(double(i) / kFine);
    double nearest = 1e300;
    std::size_t best = from;
    for (std::size_t k = from; k + 1 < points.size() && k < from + kAhead; ++k) {
      const Point2 a = points[k], b = points[k + 1];
      const double ux = b.x_mm - a.x_mm, uy = b.y_mm - a.y_mm, square = ux * ux + uy * uy;
      const double x = square > 0.0 ? ((p.x_mm - a.x_mm) * ux + (p.y_mm - a.y_mm) * uy) / square : 0.0;
      const double y = std::clamp(x, 0.0, 1.0);
      const double d = distance(p, {a.x_mm + y * ux, a.y_mm + y * uy});
      if (d < nearest) {
        nearest = d;
        best = k;
      }
    }
    from = best;
    most = std::max(most, nearest);
  }
  return most;
}

void measure(Planner& planner, int kind, std::uint64_t seed, Kind& out) {
  static constexpr int kDecimals[3] = {3, 4, 9};
  RandomStream draw(seed, Purpose::kTest);
  const ParametricCurve curve = random_curve(kind, seed);
  const double step = 0.05 * std::pow(40.0, draw.uniform(0.0, 1.0));
  const int decimals = kDecimals[draw.below(3)];
  const double tolerance = 0.005 * std::pow(20.0, draw.uniform(0.0, 1.0));
  const auto at = [&](double step_mm, double tolerance_mm, Method method) {
    return planner(sampled(curve, step_mm, decimals), tolerance_mm, decimals, method);
  };
  const PlanResult fast = at(step, tolerance, Method::kCertified),
                   slow = at(step, tolerance, Method::kOptimal),
                   wide = at(step, 1.5 * tolerance, Method::kCertified),
                   dense = at(0.5 * step, tolerance, Method::kCertified);
  if (!fast.ok() || !slow.ok() || !wide.ok() || !dense.ok()) {
    ++out.refused;
    return;
  }
  const double t = fast.continuous_s;
  out.over_best.add(t / std::min(slow.continuous_s, t));
  out.wider.add(wide.continuous_s / t - 1.0);
  out.denser.add(dense.continuous_s / t - 1.0);
  const double missed = missed_mm(curve, sampled(curve, step, decimals)) / tolerance;
  if (missed <= 0.5) out.told.add(out.denser.value.back());
  out.bound.add(fast.trajectory.certificate.lower_bound_s / t);
  out.off.add(std::max(fast.deviation_mm, slow.deviation_mm) / tolerance);
  out.ratio.add(std::max(largest(fast), largest(slow)));
  if (std::getenv("MOTION_PATHS_VERBOSE"))
    std::printf(
        "%s %llu step %.6f decimals %d tolerance %.6f: %.4f optimal %.4f wider %+.4f denser %+.4f (samples "
        "miss %.2f) off %.3f\n",
        kCurveKind[kind], static_cast<unsigned long long>(seed), step, decimals, tolerance, t,
        slow.continuous_s, out.wider.value.back(), out.denser.value.back(), missed, out.off.value.back());
  std::fflush(stdout);
}

void print(const char* text, const Kind& k) {
  std::printf("%-10s %6zu %8.4f %8.4f %9.2f %9.2f %9.2f %9.3f %8.4f %10.7f %7d\n", text,
              k.over_best.value.size(), k.over_best.mean(), k.over_best.most(), 100.0 * k.wider.most(),
              100.0 * k.denser.most(), 100.0 * k.told.most(), k.bound.mean(), k.off.most(), k.ratio.most(),
              k.refused);
  std::fflush(stdout);
}

int table(int curves, std::uint64_t seed, const char* only) {
  Planner planner;
  Kind all;
  std::printf("%-10s %6s %8s %8s %9s %9s %9s %9s %8s %10s %7s\n", "curves", "number", "T / best", "worst",
              "wider %", "denser %", "told %", "bound / T", "off / e", "ratio", "refused");
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    if (only && std::strcmp(only, kCurveKind[kind]) != 0) continue;
    Kind here;
    for (int k = kind; k < curves; k += kCurveKinds) measure(planner, kind, seed + std::uint64_t(k), here);
    print(kCurveKind[kind], here);
    all.merge(here);
  }
  print("all", all);
  return 0;
}

/// Optimum of all segments of a plan, each on its own curve. 0 = one was not found.
double transcribed_s(const CertifiedWork& work, const PlanResult& result, int parts) {
  static const MotionLimits limits = cobra600_limits();
  double sum = 0.0;
  for (std::size_t k = 0; k <= result.stops; ++k) {
    const double best =
        TimeTranscription(work.segments()[k], limits, 325.0, 275.0, result.configuration.elbow)
            .minimum_time(parts);
    if (best == 0.0) return 0.0;
    sum += best;
  }
  return sum;
}

int nlp(int curves, std::uint64_t seed, const char* only) {
  const auto arm = make_scara(cobra600());
  static constexpr int kDecimals[3] = {3, 4, 9};
  CertifiedWork work;
  std::printf("%-10s %6s %10s %8s %10s %8s %12s %8s %8s\n", "curves", "number", "certified", "worst",
              "optimal", "worst", "bound", "largest", "none");
  Summary all[3];
  int without = 0;
  const auto print = [](const char* text, const Summary(&of)[3], int none) {
    std::printf("%-10s %6zu %10.4f %8.4f %10.4f %8.4f %12.4f %8.4f %8d\n", text, of[0].value.size(),
                of[0].mean(), of[0].most(), of[1].mean(), of[1].most(), of[2].mean(), of[2].most(), none);
    std::fflush(stdout);
  };
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    if (only && std::strcmp(only, kCurveKind[kind]) != 0) continue;
    Summary here[3];
    int none = 0;
    for (int k = kind; k < curves; k += kCurveKinds) {
      RandomStream draw(seed + std::uint64_t(k), Purpose::kTest);
      const double step = 0.1 * std::pow(10.0, draw.uniform(0.0, 1.0));
      const int decimals = kDecimals[draw.below(3)];
      const std::vector<Point2> points = sampled(random_curve(kind, seed + std::uint64_t(k)), step, decimals);
      PathInput input;
      input.points = points;
      input.origin = kPart;
      PlanOptions options;
      options.point_noise_mm = 0.5 * std::pow(10.0, -decimals);
      if (draw.below(3) > 0) options.tolerance_mm = 0.005 * std::pow(20.0, draw.uniform(0.0, 1.0));
      for (int tier = 0; tier < 2; ++tier) {
        options.method = tier == 0 ? Method::kCertified : Method::kOptimal;
        const PlanResult result = plan_certified(input, *arm, cobra600_limits(), options, work);
        const double best = transcribed_s(work, result, tier == 0 ? 2 : 1);  // cells of tier 1 are finer
        none += best == 0.0;
        if (best == 0.0) continue;
        here[tier].add(result.continuous_s / best);
        here[2].add(result.trajectory.certificate.lower_bound_s / best);
        if (std::getenv("MOTION_PATHS_VERBOSE"))
          std::printf("%s %d tier %d tolerance %.4f, %zu stops: %.4f s, over the optimum %.4f, bound %.4f\n",
                      kCurveKind[kind], k, tier, options.tolerance_mm, result.stops, result.continuous_s,
                      here[tier].value.back(), here[2].value.back());
        std::fflush(stdout);
      }
    }
    print(kCurveKind[kind], here, none);
    for (int i = 0; i < 3; ++i) all[i].merge(here[i]);
    without += none;
  }
  print("all", all, without);
  return 0;
}

int one(char** argv) {
  int kind = 0;
  while (kind + 1 < kCurveKinds && std::strcmp(kCurveKind[kind], argv[2]) != 0) ++kind;
  const ParametricCurve curve = random_curve(kind, std::strtoull(argv[3], nullptr, 10));
  const int decimals = std::atoi(argv[5]);
  const std::vector<Point2> points = sampled(curve, std::atof(argv[4]), decimals);
  Planner planner;
  for (const Method method : {Method::kCertified, Method::kOptimal}) {
    const PlanResult r = planner(points, std::atof(argv[6]), decimals, method);
    if (!r.ok()) {
      std::printf("%s: %s\n", name(method), describe(*r.fault).c_str());
      continue;
    }
    std::printf("%-10s %zu points, %.4f s, bound %.4f s, off %.5f mm, %zu stops, ratio %.7f\n", name(method),
                points.size(), r.continuous_s, r.trajectory.certificate.lower_bound_s, r.deviation_mm,
                r.stops, largest(r));
  }
  return 0;
}

/// Plans, and returns emitted_ratio().
double planned_ratio(const std::vector<Point2>& points, const PlanOptions& options, const Arm& arm,
                     CertifiedWork& work, double& deviation_mm) {
  static const MotionLimits limits = cobra600_limits();
  PathInput input;
  input.points = points;
  const PlanResult result = plan_certified(input, arm, limits, options, work);
  deviation_mm = result.deviation_mm;
  return emitted_ratio(result, work);
}

int nasty(int paths, std::uint64_t seed) {
  constexpr int kReport = 1000;
  const auto arm = make_scara(cobra600());
  CertifiedWork work;
  RandomPathMaker maker(seed);
  RandomStream draw(seed, Purpose::kTest);
  std::map<std::string, int> refused;
  double most = 0.0, off = 0.0;
  int planned = 0;
  for (int k = 0; k < paths; ++k) {
    if (k > 0 && k % kReport == 0) {
      std::printf("%d paths\n", k);
      std::fflush(stdout);
    }
    const RandomPath path = maker.next();
    PlanOptions options;
    if (k % 2) options.tolerance_mm = 0.005 * std::pow(20.0, draw.uniform(0.0, 1.0));
    try {
      double deviation_mm = 0.0;
      const double ratio = planned_ratio(path.points, options, *arm, work, deviation_mm);
      ++planned;
      if (options.tolerance_mm > 0.0) off = std::max(off, deviation_mm / options.tolerance_mm);
      if (ratio > most || (options.tolerance_mm > 0.0 && deviation_mm > options.tolerance_mm))
        std::printf("path %d (%s, %zu points), tolerance %.4f: ratio 1 %+.3g, deviation %.5f mm\n", k,
                    path.kind, path.points.size(), options.tolerance_mm, ratio - 1.0, deviation_mm);
      std::fflush(stdout);
      most = std::max(most, ratio);
    } catch (const MotionError& error) {
      const Reason reason = error.fault().reason;
      ++refused[name(reason)];
      if (reason >= Reason::kReachFar && reason <= Reason::kJointHigh) continue;
      std::printf("path %d (%s, %zu points), tolerance %.4f: %s\n", k, path.kind, path.points.size(),
                  options.tolerance_mm, describe(error.fault()).c_str());
      std::fflush(stdout);
    }
  }
  std::printf("%d planned, largest ratio 1 %+.3g, deviation / tolerance %.4f\n", planned, most - 1.0, off);
  for (const auto& [reason, count] : refused) std::printf("%6d refused: %s\n", count, reason.c_str());
  return 0;
}

/// Paths with `--tolerance 0`: points within their rounding, by the planner and by dense sampling of the
/// curve.
int held(int paths, std::uint64_t seed, bool nasty) {
  constexpr double kChords_mm = 5e-6;  ///< sagitta of the chords between samples
  const auto arm = make_scara(cobra600());
  CertifiedWork work;
  HeldPathMaker maker(seed);
  RandomPathMaker random(seed);
  double most = 0.0, share = 0.0, told = -1.0, polygon = -1.0;
  int planned = 0;
  for (int k = 0; k < paths; ++k) {
    HeldPath path = maker.next();
    if (nasty) {
      const RandomPath other = random.next();
      path = {other.points, other.kind, 9};
      for (Point2& p : path.points) p = {p.x_mm - kPart.x_mm, p.y_mm - kPart.y_mm};
    }
    PathInput input;
    input.points = path.points;
    input.origin = kPart;
    PlanOptions options;
    options.point_rule = PointRule::kHeld;
    options.point_noise_mm = path.decimals < 9 ? 0.5 * std::pow(10.0, -path.decimals) : 0.0;
    try {
      const PlanResult result = plan_certified(input, *arm, cobra600_limits(), options, work);
      std::vector<Point2> points;
      for (const Point2& p : path.points) points.push_back({p.x_mm + kPart.x_mm, p.y_mm + kPart.y_mm});
      const HeldDistances found =
          sampled_distances(points, work.segments(), result.stops + 1, result.points_off_mm);
      const double ratio = emitted_ratio(result, work);
      const bool bad = ratio > 1.0 || result.points_off_mm > result.held_mm ||
                       found.points_mm > result.points_off_mm + kChords_mm ||
                       (!nasty && found.curve_mm > result.deviation_mm + kChords_mm);
      if (bad || std::getenv("MOTION_PATHS_VERBOSE"))
        std::printf(
            "path %d (%s, %zu points, %d decimals): %.3f s, ratio 1 %+.3g, points off %.6f of %.6f, found "
            "%.6f; curve off %.6f, found %.6f, %zu stops\n",
            k, path.kind, path.points.size(), path.decimals, result.continuous_s, ratio - 1.0,
            result.points_off_mm, result.held_mm, found.points_mm, result.deviation_mm, found.curve_mm,
            result.stops);
      std::fflush(stdout);
      most = std::max(most, ratio);
      share = std::max(share, result.points_off_mm / result.held_mm);
      told = std::max(told, found.points_mm - result.points_off_mm);
      if (!nasty) polygon = std::max(polygon, found.curve_mm - result.deviation_mm);
      ++planned;
    } catch (const MotionError& error) {
      std::printf("path %d (%s, %zu points): %s\n", k, path.kind, path.points.size(),
                  describe(error.fault()).c_str());
    }
  }
  std::printf(
      "%d of %d planned, largest ratio 1 %+.3g, points off / rounding %.4f, found beyond what is told: "
      "points %.3g mm, curve %.3g mm\n",
      planned, paths, most - 1.0, share, told, polygon);
  return 0;
}

int rounded(int curves_of_kind, std::uint64_t seed) {
  constexpr double kSlower = 1.05;
  const auto arm = make_scara(cobra600());
  CertifiedWork work;
  RandomStream draw(seed, Purpose::kTest);
  const auto duration_s = [&](const std::vector<Point2>& points, int decimals) {
    PathInput input;
    input.points = points;
    input.origin = kPart;
    PlanOptions options;
    options.point_rule = PointRule::kHeld;
    options.point_noise_mm = decimals < 9 ? 0.5 * std::pow(10.0, -decimals) : 0.0;
    return plan_certified(input, *arm, cobra600_limits(), options, work).continuous_s;
  };
  const auto told = [&](const char* what, const Summary& over) {
    std::printf(
        "%-16s %zu curves: mean %.4f, at most %.4f, %ld above %.2f\n", what, over.value.size(), over.mean(),
        over.most(),
        long(std::count_if(over.value.begin(), over.value.end(), [](double v) { return v > kSlower; })),
        kSlower);
    std::fflush(stdout);
  };
  for (int kind = 0; kind <= kCurveKinds; ++kind) {
    const bool cusps = kind == kCurveKinds;
    Summary over;
    for (int k = 0; k < curves_of_kind; ++k) {
      const ParametricCurve curve =
          cusps ? curves::epicycloid(draw) : random_curve(kind, seed + std::uint64_t(k));
      const double share = draw.uniform(0.0, 1.0);
      const auto points = [&](int decimals) {
        return cusps ? at_parameters(curve, int(500.0 * std::pow(16.0, share)), decimals)
                     : sampled(curve, 0.01 * std::pow(100.0, share), decimals);
      };
      over.add(duration_s(points(3), 3) / duration_s(points(9), 9));
      if (std::getenv("MOTION_PATHS_VERBOSE"))
        std::printf("%s %d: %.4f\n", cusps ? "epicycloids" : kCurveKind[kind], k, over.value.back());
    }
    told(cusps ? "epicycloids" : kCurveKind[kind], over);
  }
  for (const double sagitta_mm : {0.005, 0.01, 0.02, 0.05}) {
    Summary over;
    for (int k = 0; k < curves_of_kind; ++k) {
      const int kind = k % kCurveKinds;
      const ParametricCurve curve = random_curve(kind, seed + std::uint64_t(k));
      over.add(duration_s(within_sagitta(curve, sagitta_mm, 3), 3) / duration_s(sampled(curve, 0.1, 9), 9));
      if (std::getenv("MOTION_PATHS_VERBOSE"))
        std::printf("within %.3f mm, %s %d: %.4f\n", sagitta_mm, kCurveKind[kind], k, over.value.back());
    }
    told(("within " + std::to_string(sagitta_mm).substr(0, 5) + " mm").c_str(), over);
  }
  return 0;
}

}  // namespace

FIRN_BENCH(motion_paths) {
  if (argc == 7 && std::strcmp(argv[1], "one") == 0) return one(argv);
  if (argc > 2 && std::strcmp(argv[1], "nasty") == 0)
    return nasty(std::max(1, std::atoi(argv[2])), argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
  if (argc > 2 && std::strcmp(argv[1], "held") == 0)
    return held(std::max(1, std::atoi(argv[2])), argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1,
                argc > 4);
  if (argc > 2 && std::strcmp(argv[1], "rounded") == 0)
    return rounded(std::max(1, std::atoi(argv[2])), argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
  if (argc > 1 && std::strcmp(argv[1], "nlp") == 0)
    return nlp(argc > 2 ? std::max(1, std::atoi(argv[2])) : 36,
               argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1, argc > 4 ? argv[4] : nullptr);
  return table(argc > 1 ? std::max(1, std::atoi(argv[1])) : 200,
               argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1, argc > 3 ? argv[3] : nullptr);
}

}  // namespace firn::bench::motion_paths
