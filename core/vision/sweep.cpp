#include "core/vision/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/statistics/median.h"
#include "core/vision/least_squares.h"

namespace firn::vision {
namespace {

// Values without another reason were chosen on rendered sweeps (tests/bench/droplet_pictures.cpp, seeds below
// 50,000).
constexpr double kPriorFreedom = 8.0;   // degrees of freedom of the stated variances
constexpr double kOutlierStds = 5.0;    // a centroid farther from the line belongs to another droplet, but
constexpr double kMinOutlier_px = 1.5;  // … not within this
constexpr std::size_t kMinAgreed = 3;   // pictures on one line that make another one an outlier
constexpr std::size_t kMinTailless =
    4;  // free droplets without tails; with fewer those with tails count, too
constexpr double kCentroidFloor_px2 = 1e-6;  // variance that a place has at least

// Drag as v^m: m = 1 of Stokes, 1.69 of Schiller and Naumann; a path is curved from so many pictures on.
constexpr double kDragPower = 1.35, kDragPower_std = 0.2;
constexpr std::size_t kMinCurved = 6, kMinCurvedDelays = 5;
constexpr double kThirdInSlope = 0.6;  // of a third order that goes into the slope of evenly spread delays
constexpr double kShared_px = 0.008;   // error of places that changes slowly across the picture: light, lens
constexpr double kMinStatedShare = 0.25;  // of the stated variance that the pooled one keeps

// Standard deviation of a diameter that all pictures share: the rim's plateau is known to some per cent, and
// a level moves a blurred edge by a + b blur + c blur^2 / diameter [px].
constexpr double kLevel_px = 0.006, kLevelPerBlur = 0.018, kLevelPerBlur2 = 0.09;
constexpr double kMinAxisRatio = 0.5, kMaxAxisRatio = 2.0;  // of a spheroid; beyond, it is an edge's error
constexpr double kSatelliteStd = 0.05, kSatelliteCommonStd = 0.02;  // of a satellite's diameter
constexpr int kMaxWrongPart = 4;       // 1 / 4 of the pictures on the wrong side: there is no break-off
constexpr double kMedianError = 1.25;  // standard deviation of a median over that of a mean
constexpr std::size_t kMinDots = 9;    // of a calibration target

struct Observation {
  double t = 0.0, x = 0.0, y = 0.0, variance = 0.0;
  const Droplet* droplet = nullptr;
  const DropletPicture* picture = nullptr;
};

struct Line {
  double t = 0.0, at = 0.0, slope = 0.0, spread2 = 0.0;  // spread2: weighted sum of (t - mean)^2
  double value(double time) const { return at + slope * (time - t); }
};

double middle_of(std::vector<double> v) { return statistics::median(v); }

Line fit(const std::vector<Observation>& seen, double Observation::*place, double more) {
  Line line;
  double w = 0, wt = 0, wy = 0, tt = 0, ty = 0;
  for (const Observation& s : seen) {
    const double weight = 1 / (s.variance + more);
    w += weight;
    wt += weight * s.t;
    wy += weight * s.*place;
  }
  line.t = wt / w;
  line.at = wy / w;
  for (const Observation& s : seen) {
    const double weight = 1 / (s.variance + more);
    tt += weight * (s.t - line.t) * (s.t - line.t);
    ty += weight * (s.t - line.t) * (s.*place - line.at);
  }
  line.spread2 = tt;
  line.slope = tt > 0 ? ty / tt : 0.0;
  return line;
}

// Theil-Sen: the median slope of all pairs with different delays, and the median intercept.
Line robust_line(const std::vector<Observation>& seen, double Observation::*place) {
  std::vector<double> slopes, at;
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t k = i + 1; k < seen.size(); ++k)
      if (seen[k].t > seen[i].t)
        slopes.push_back((seen[k].*place - seen[i].*place) / (seen[k].t - seen[i].t));
  Line line;
  if (slopes.empty()) return line;
  line.slope = statistics::median(slopes);
  for (const Observation& s : seen) at.push_back(s.*place - line.slope * s.t);
  line.at = statistics::median(at);
  return line;
}

Observation observed(const TimedPicture& p, const Droplet& d) {
  return {p.delay_us, d.x, d.y, d.x_std * d.x_std + kCentroidFloor_px2, &d, &p.picture};
}

// Free droplets, first without tails: a tail that is drawn in moves the centroid.
std::vector<Observation> free_droplets(std::span<const TimedPicture> pictures, bool tails) {
  std::vector<Observation> seen;
  for (const TimedPicture& p : pictures)
    if (p.picture.state == PictureState::kDrop && (tails || p.picture.main.tail_px == 0.0))
      seen.push_back(observed(p, p.picture.main));
  std::stable_sort(seen.begin(), seen.end(),
                   [](const Observation& a, const Observation& b) { return a.t < b.t; });
  return seen;
}

bool has_two_delays(const std::vector<Observation>& seen) {
  return !seen.empty() && seen.back().t > seen.front().t;
}

// Each picture's droplet that is nearest to the robust line; none within reach: the picture does not count.
void follow(std::span<const TimedPicture> pictures, std::vector<Observation>& seen) {
  const Line x = robust_line(seen, &Observation::x), y = robust_line(seen, &Observation::y);
  std::vector<double> off;
  for (const Observation& s : seen) {
    const double dx = s.x - x.value(s.t), dy = s.y - y.value(s.t);
    off.push_back(std::sqrt(dx * dx + dy * dy));
  }
  std::vector<double> copy(off);
  const double n = double(seen.size());  // a line takes two degrees of freedom from the distances
  const double reach =
      std::max(kOutlierStds * statistics::kMadToStd * statistics::median(copy) * n / std::max(1.0, n - 2),
               kMinOutlier_px);
  std::vector<Observation> kept;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Observation best = seen[i];
    double nearest = off[i];
    if (nearest > reach)
      for (const TimedPicture& p : pictures) {
        if (&p.picture != seen[i].picture) continue;
        for (const Droplet& d : p.picture.drops) {
          const double dx = d.x - x.value(p.delay_us), dy = d.y - y.value(p.delay_us),
                       r = std::sqrt(dx * dx + dy * dy);
          if (r < nearest && !d.joined) {
            nearest = r;
            best = observed(p, d);
          }
        }
      }
    if (nearest <= reach) kept.push_back(best);
  }
  // A line passes through any two places: two pictures cannot outvote a third one.
  if (kept.size() >= kMinAgreed) seen = std::move(kept);
}

// value +- 1.96 std covers 95 % of Student's t with `freedom` [Abramowitz and Stegun, table 26.10 for 1 and
// 2; 26.7.5, two terms].
double widen(double freedom) {
  if (freedom < 1.5) return 6.483;
  if (freedom < 2.5) return 2.195;
  return 1 + (1.21 + 1.44 / freedom) / freedom;
}

// Sum of squares over `freedom` and variance above which the scatter contradicts the stated variance: with
// one or two degrees of freedom the 95 % quantile of chi-squared.
double contradiction(double freedom) { return freedom < 1.5 ? 3.84 : freedom < 2.5 ? 3.0 : 2.0; }

// The scatter of n values about `fitted` parameters, with the stated variance as prior; the scatter alone
// where it contradicts the prior: a jet that jitters. @returns the variance, then widened for its degrees of
// freedom
double pooled_variance(double squares, double n, double fitted, double stated) {
  const double freedom = n - fitted;
  const bool alone = freedom >= 1 && squares > contradiction(freedom) * freedom * stated;
  const double prior = alone ? 0.0 : kPriorFreedom, all = std::max(0.0, freedom) + prior;
  const double factor = alone ? widen(all) : 1.0;
  return (squares + prior * stated) / all * factor * factor;
}

Estimate mean_estimate(const std::vector<double>& v, double stated_std, double common_std) {
  Estimate e;
  if (v.empty()) return e;
  const double n = double(v.size());
  for (const double x : v) e.value += x / n;
  double squares = 0.0;
  for (const double x : v) squares += (x - e.value) * (x - e.value);
  const double variance = pooled_variance(squares, n, 1, stated_std * stated_std);
  e.std = std::sqrt(variance / n + common_std * common_std);
  e.known = true;
  return e;
}

void measure_size(const std::vector<Observation>& seen, const Scale& scale, SweepResult& r) {
  std::vector<double> diameter, volume, relative, bias;
  for (const Observation& s : seen) {
    const double d = s.droplet->diameter_px * scale.um_per_px, blur = s.picture->blur_px;
    diameter.push_back(d);
    // Spheroid about the flight: pi / 6 * along * across^2, um^3 in pl.
    volume.push_back(std::numbers::pi / 6 * d * d * d /
                     std::sqrt(std::clamp(s.droplet->axis_ratio, kMinAxisRatio, kMaxAxisRatio)) * 1e-3);
    relative.push_back(s.droplet->diameter_std_px / s.droplet->diameter_px);
    const double px = s.droplet->diameter_px,
                 level_px = kLevel_px + kLevelPerBlur * blur + kLevelPerBlur2 * blur * blur / px,
                 focus_px = blurred_std_px(blur, px);
    bias.push_back(std::sqrt(level_px * level_px + focus_px * focus_px) / px);
  }
  const double stated = statistics::median(relative), scale_share = scale.std / scale.um_per_px;
  const double common = statistics::median(bias),
               shared = std::sqrt(common * common + scale_share * scale_share);
  r.diameter_um = mean_estimate(diameter, stated * middle_of(diameter), 0.0);
  r.diameter_um.std = std::sqrt(r.diameter_um.std * r.diameter_um.std +
                                shared * shared * r.diameter_um.value * r.diameter_um.value);
  const double of_volume = middle_of(volume);
  r.volume_pl = mean_estimate(volume, 3 * stated * of_volume, 3 * shared * of_volume);
}

void measure_satellites(const std::vector<Observation>& seen, const Scale& scale, SweepResult& r) {
  std::vector<double> count, largest;
  for (const Observation& s : seen) {
    count.push_back(double(s.picture->satellites.size()));
    if (!s.picture->satellites.empty())
      largest.push_back(s.picture->satellites.front().diameter_px * scale.um_per_px);
  }
  r.satellites.known = !count.empty();
  if (!r.satellites.known) return;
  r.satellites.value = statistics::upper_median(std::vector<double>(count));
  double squares = 0.0;
  for (const double c : count) squares += (c - r.satellites.value) * (c - r.satellites.value);
  r.satellites.std = std::sqrt(squares / double(count.size()));
  if (2 * largest.size() >= count.size() && !largest.empty()) {
    const double middle = middle_of(largest);
    r.largest_satellite_um = mean_estimate(largest, kSatelliteStd * middle, kSatelliteCommonStd * middle);
  }
}

// The delay that leaves the fewest pictures on the wrong side.
Estimate break_off(std::span<const TimedPicture> pictures) {
  struct State {
    double t;
    bool joined;
  };
  std::vector<State> states;
  for (const TimedPicture& p : pictures)
    if (p.picture.state != PictureState::kNoDrop)
      states.push_back({p.delay_us, p.picture.state == PictureState::kNotBrokenOff});
  std::stable_sort(states.begin(), states.end(), [](const State& a, const State& b) { return a.t < b.t; });
  Estimate e;
  long best = -1, wrong = 0;
  for (const State& s : states) wrong += s.joined;  // all are taken as free
  long fewest = wrong;
  for (std::size_t i = 0; i < states.size(); ++i) {
    wrong += states[i].joined ? -1 : 1;
    if (i + 1 < states.size() && states[i + 1].t == states[i].t) continue;
    if (wrong < fewest) {
      fewest = wrong;
      best = long(i);
    }
  }
  if (best < 0 || best + 1 >= long(states.size()) || kMaxWrongPart * fewest > long(states.size())) return e;
  const double from = states[std::size_t(best)].t, to = states[std::size_t(best) + 1].t;
  return {0.5 * (from + to), (to - from) / std::sqrt(12.0), true};
}

Point axis_of(std::span<const TimedPicture> pictures) {
  for (const TimedPicture& p : pictures)
    if (p.picture.nozzle.found) return p.picture.nozzle.flight;
  return {0.0, 1.0};
}

// The path along the flight: place and velocity at the mean delay, and the deceleration by the air.
struct Path {
  bool found = false;
  double velocity = 0.0, unit_std = 0.0;  // unit_std: of the velocity, for places of deviation 1
  double squares = 0.0;                   // of the places' distances from the path
  double freedom = 0.0;
  double model_std = 0.0;  // of the velocity: drag, and what neighbouring pictures share
};

std::size_t delays_of(const std::vector<Observation>& seen) {
  std::size_t n = 1;
  for (std::size_t i = 1; i < seen.size(); ++i) n += seen[i].t > seen[i - 1].t;
  return n;
}

// @param along places along the flight, from that of the lines at `middle`
Path fit_path(const std::vector<Observation>& seen, const std::vector<double>& along, double middle,
              bool curved) {
  Path path;
  double reach = 0.0;
  for (const Observation& s : seen) reach = std::max(reach, std::abs(s.t - middle));
  if (!(reach > 0)) return path;
  std::array<double, 3> at{};
  double third = 0.0;
  // Drag as v^m gives x''' = m x''^2 / x': the third order follows from the second.
  for (int round = 0; round < 3; ++round) {
    SmallLeastSquares<3> sums;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const double u = (seen[i].t - middle) / reach;
      sums.add({1.0, u, curved ? u * u : 0.0}, along[i] - third * u * u * u, 1.0);
    }
    if (!curved) sums.add({0.0, 0.0, 1.0}, 0.0, 1.0);
    if (!sums.solve(at)) return path;
    path.unit_std = std::sqrt(sums.variance({0.0, 1.0, 0.0})) / reach;
    third = curved && at[1] > 0.0 ? kDragPower * 2.0 / 3.0 * at[2] * at[2] / at[1] : 0.0;
  }
  path.velocity = at[1] / reach;
  const double power = kThirdInSlope * kDragPower_std / kDragPower * third;
  path.model_std = std::sqrt(power * power + kShared_px * kShared_px) / reach;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double u = (seen[i].t - middle) / reach;
    const double off = along[i] - at[0] - u * (at[1] + u * (at[2] + u * third));
    path.squares += off * off;
  }
  path.freedom = double(seen.size()) - (curved ? 3.0 : 2.0);
  path.found = path.velocity > 0.0;
  return path;
}

void measure_flight(const std::vector<Observation>& seen, const Scale& scale, Point axis, SweepResult& r) {
  const double n = double(seen.size());
  const bool curved = seen.size() >= kMinCurved && delays_of(seen) >= kMinCurvedDelays;
  double stated = 0.0, across2 = 0.0, jitter2 = 0.0;
  Line x, y;
  Path path;
  std::vector<double> along(seen.size());
  for (int round = 0; round < 3; ++round) {
    x = fit(seen, &Observation::x, jitter2);
    y = fit(seen, &Observation::y, jitter2);
    const double speed = std::sqrt(x.slope * x.slope + y.slope * y.slope);
    if (!(speed > 0)) return;
    r.flight = {x.slope / speed, y.slope / speed};
    stated = across2 = 0.0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Observation& s = seen[i];
      along[i] = (s.x - x.at) * r.flight.x + (s.y - y.at) * r.flight.y;
      const double b = (s.x - x.value(s.t)) * r.flight.y - (s.y - y.value(s.t)) * r.flight.x;
      across2 += b * b;
      stated += s.variance / n;
    }
    path = fit_path(seen, along, x.t, curved);
    if (!path.found) return;
    jitter2 = path.freedom > 0 ? std::max(0.0, path.squares / path.freedom - stated) : 0.0;
  }
  r.used = int(seen.size());
  r.middle_us = x.t;
  double tt = 0.0;
  for (const Observation& s : seen) tt += (s.t - x.t) * (s.t - x.t);
  const double speed = path.velocity, share = scale.std / scale.um_per_px;
  const double place2 =
      std::max(pooled_variance(path.squares, n, n - path.freedom, stated), stated * kMinStatedShare);
  const double across =
      std::sqrt(std::max(pooled_variance(across2, n, 2, stated), stated * kMinStatedShare) / tt);
  const double variance = place2 * path.unit_std * path.unit_std + path.model_std * path.model_std +
                          speed * speed * share * share;
  r.velocity_m_s = {speed * scale.um_per_px, scale.um_per_px * std::sqrt(variance), true};
  const double forward = r.flight.x * axis.x + r.flight.y * axis.y,
               side = r.flight.x * axis.y - r.flight.y * axis.x;
  const double degrees = 180 / std::numbers::pi;
  double angle = forward != 0 ? arc_tangent(side / forward) * degrees : std::copysign(90.0, side);
  if (forward < 0) angle += side >= 0 ? 180 : -180;
  r.angle_deg = {angle, degrees * across / speed, true};
  if (path.freedom >= 2) {
    const double us = std::sqrt(jitter2) / speed;
    const double total = std::sqrt(path.squares / path.freedom) / speed;
    r.jitter_us = {us, std::max(us, total) / std::sqrt(2 * path.freedom), true};
  }
}

}  // namespace

double arc_tangent(double x) {
  for (int i = 0; i < 4; ++i) x = x / (1 + std::sqrt(1 + x * x));
  const double q = x * x;
  double s = 0.0;
  for (int k = 12; k >= 0; --k) s = (k % 2 ? -1.0 : 1.0) / (2 * k + 1) + q * s;
  return 16 * x * s;
}

Scale scale_from_nozzle(std::span<const DropletPicture> pictures, double nozzle_um) {
  std::vector<double> widths, stds;
  for (const DropletPicture& p : pictures)
    if (p.nozzle.found) {
      widths.push_back(p.nozzle.width_px);
      stds.push_back(p.nozzle.width_std_px);
    }
  if (widths.empty()) return {};
  const double width = statistics::median(widths), n = double(widths.size());
  std::vector<double> off;
  for (const double w : widths) off.push_back(std::abs(w - width));
  const double scatter = kMedianError * statistics::kMadToStd * statistics::median(off) / std::sqrt(n);
  const double std = std::sqrt(scatter * scatter + statistics::median(stds) * statistics::median(stds));
  return {nozzle_um / width, nozzle_um / width * std / width};
}

Scale scale_from_target(const DropletPicture& target, double pitch_um) {
  std::vector<Droplet> dots;
  if (target.state == PictureState::kDrop) dots.push_back(target.main);
  dots.insert(dots.end(), target.drops.begin(), target.drops.end());
  if (dots.size() < kMinDots) return {};
  std::vector<double> pitches;
  for (const Droplet& a : dots) {
    double nearest = 1e18;
    for (const Droplet& b : dots) {
      const double d = (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
      if (&a != &b) nearest = std::min(nearest, d);
    }
    pitches.push_back(std::sqrt(nearest));
  }
  const double pitch = statistics::median(pitches);
  std::vector<double> off;
  for (const double p : pitches) off.push_back(std::abs(p - pitch));
  const double std =
      kMedianError * statistics::kMadToStd * statistics::median(off) / std::sqrt(double(off.size()));
  return {pitch_um / pitch, pitch_um / pitch * std / pitch};
}

SweepResult measure_sweep(std::span<const TimedPicture> pictures, const Scale& scale) {
  SweepResult r;
  r.pictures = int(pictures.size());
  for (const TimedPicture& p : pictures) r.with_droplet += p.picture.state != PictureState::kNoDrop;
  r.break_off_us = break_off(pictures);
  if (!(scale.um_per_px > 0)) return r;
  std::vector<Observation> seen = free_droplets(pictures, false);
  if (seen.size() < kMinTailless || !has_two_delays(seen)) seen = free_droplets(pictures, true);
  if (seen.empty()) return r;
  if (has_two_delays(seen)) follow(pictures, seen);
  if (seen.empty()) return r;
  measure_size(seen, scale, r);
  measure_satellites(seen, scale, r);
  if (has_two_delays(seen) && seen.size() >= 2) measure_flight(seen, scale, axis_of(pictures), r);
  return r;
}

}  // namespace firn::vision
