#include "estimators/calibration/laser.h"

#include <algorithm>
#include <cmath>

#include "core/statistics/median.h"

namespace firn::calibration {
namespace {

constexpr double kMinStep_mm = 0.3;  // of an edge
constexpr int kHalf = 3;             // readings that make a level
constexpr double kMinSpeed_mm_s = 2.0;
constexpr double kSameYaw_rad = 0.01;
constexpr double kOtherYaw_cos =
    0.5;  // yaws that differ by 60 degrees or more separate the spot from the block
constexpr double kMaxOutliers = 0.25;

/// The estimated spot in the flange's frame, along one pass: position by time.
class SpotTrack {
 public:
  SpotTrack(const LaserPass& pass, const LaserBelief& b) : tick_s_(pass.motion.tick_s) {
    const Trajectory& t = pass.motion;
    const std::size_t n = t.samples();
    motion::Jets q(motion::kMaxJoints, n), flange(motion::kTaskAxes, n), spot(motion::kTaskAxes, n);
    for (std::size_t i = 0; i < n; ++i)
      for (int a = 0; a < b.arm.joints(); ++a) {
        q.of(a, 0)[i] = t.positions[i * std::size_t(t.axes) + std::size_t(a)];
        for (int order = 1; order < 4; ++order) q.of(a, order)[i] = 0.0;
      }
    b.arm.forward(q, flange);
    motion::flange_to_tool(b.laser, flange, spot);
    for (std::size_t i = 0; i < n; ++i)
      at_.push_back({spot.of(motion::kX, 0)[i] - b.origin.x_mm, spot.of(motion::kY, 0)[i] - b.origin.y_mm});
    const double yaw = n > 0 ? flange.of(motion::kYaw, 0)[0] : 0.0;
    cos_ = std::cos(yaw);
    sin_ = std::sin(yaw);
    for (std::size_t i = 0; i < n; ++i)
      if (std::abs(flange.of(motion::kYaw, 0)[i] - yaw) > kSameYaw_rad)
        throw Unidentifiable("a pass turns its yaw while it runs: one yaw each");
  }
  double cos_yaw() const { return cos_; }
  double sin_yaw() const { return sin_; }
  double end_s() const { return tick_s_ * double(at_.size() - 1); }
  Point2 at(double t_s) const {
    const double k = std::clamp(t_s / tick_s_, 0.0, double(at_.size() - 1));
    const std::size_t i = std::min(std::size_t(k), at_.size() - 2);
    const double f = k - double(i);
    return {at_[i].x_mm + f * (at_[i + 1].x_mm - at_[i].x_mm),
            at_[i].y_mm + f * (at_[i + 1].y_mm - at_[i].y_mm)};
  }
  Point2 speed(double t_s) const {
    const Point2 a = at(t_s - 0.5 * tick_s_), b = at(t_s + 0.5 * tick_s_);
    return {(b.x_mm - a.x_mm) / tick_s_, (b.y_mm - a.y_mm) / tick_s_};
  }

 private:
  double tick_s_, cos_ = 1.0, sin_ = 0.0;
  std::vector<Point2> at_;
};

struct Crossing {
  std::size_t pass;
  double time_s;  ///< of the reading, without latency
  bool along_x;   ///< the side lies across x
  double side_mm;
};

/// Times at which the readings step, and whether they rise.
std::vector<std::pair<double, bool>> steps_of(const LaserPass& pass) {
  std::vector<std::pair<double, bool>> steps;
  const std::vector<float>& z = pass.reading_mm;
  std::vector<std::size_t> valid;
  for (std::size_t k = 0; k < z.size(); ++k)
    if (std::isfinite(z[k])) valid.push_back(k);
  for (std::size_t n = kHalf; n + kHalf < valid.size(); ++n) {
    std::vector<double> before, after;
    for (std::size_t k = n - kHalf; k < n; ++k) before.push_back(double(z[valid[k]]));
    for (std::size_t k = n + 1; k <= n + kHalf; ++k) after.push_back(double(z[valid[k]]));
    const double low = statistics::upper_median(before), high = statistics::upper_median(after);
    const double step = high - low, here = double(z[valid[n]]), next = double(z[valid[n + 1]]);
    const double level = 0.5 * (low + high);
    if (std::abs(step) < kMinStep_mm || (here - level) * step > 0.0 || (next - level) * step <= 0.0) continue;
    if (valid[n + 1] - valid[n] > 2) continue;  // values are missing at the edge itself
    const double share = std::abs(next - here) < 0.5 * std::abs(step) ? (level - here) / (next - here) : 0.5;
    steps.emplace_back(pass.period_s * (double(valid[n]) + share * double(valid[n + 1] - valid[n])),
                       step > 0.0);
    n += kHalf;
  }
  return steps;
}

}  // namespace

namespace {

struct Crossings {
  std::vector<SpotTrack> tracks;
  std::vector<Crossing> all;
  int steps = 0;
  bool up[2] = {}, down[2] = {};  ///< x, y: crossed in this direction
  bool turned = false;            ///< passes of yaws far apart
  bool both(int axis) const { return up[axis] && down[axis]; }
  bool any(int axis) const { return up[axis] || down[axis]; }
};

Crossings crossings_of(std::span<const LaserPass> passes, const Jig& jig, const LaserBelief& b) {
  Crossings c;
  for (std::size_t n = 0; n < passes.size(); ++n) {
    c.tracks.emplace_back(passes[n], b);
    const SpotTrack &track = c.tracks.back(), &first = c.tracks.front();
    c.turned =
        c.turned || track.cos_yaw() * first.cos_yaw() + track.sin_yaw() * first.sin_yaw() < kOtherYaw_cos;
    for (const auto& [time, rises] : steps_of(passes[n])) {
      ++c.steps;
      const double at = time + b.latency_s;
      if (at < 0.0 || at > track.end_s()) continue;
      const Point2 v = track.speed(at);
      const bool along_x = std::abs(v.x_mm) > std::abs(v.y_mm);
      const double speed = along_x ? v.x_mm : v.y_mm;
      if (std::abs(speed) < kMinSpeed_mm_s) continue;
      const bool low_side = (speed > 0.0) == rises;  // entered going up, or left going down
      c.all.push_back({n, time, along_x,
                       along_x ? (low_side ? jig.x0_mm : jig.x1_mm) : (low_side ? jig.y0_mm : jig.y1_mm)});
      (speed > 0.0 ? c.up : c.down)[along_x ? 0 : 1] = true;
    }
  }
  return c;
}

}  // namespace

LaserCalibration calibrate_laser(std::span<const LaserPass> passes, const Jig& jig, const LaserBelief& b,
                                 LaserUnknowns what) {
  Crossings c = crossings_of(passes, jig, b);
  const bool offset = what == LaserUnknowns::kOffset;
  if (c.steps == 0) throw Unidentifiable("no reading steps by 0.3 mm: no side of the block was seen");
  if (!c.both(0) && !c.both(1))
    throw Unidentifiable(
        "no side of the block was crossed both ways: the latency cannot be told from an offset");
  if (offset && !(c.any(0) && c.any(1)))
    throw Unidentifiable(std::string("no side across ") + (c.any(0) ? "y" : "x") +
                         " was crossed: the offset along it cannot be told");
  if (!offset && c.turned)
    throw Unidentifiable("passes of more than one yaw: the latency is told by passes of one");
  if (!offset) std::erase_if(c.all, [&](const Crossing& k) { return !c.both(k.along_x ? 0 : 1); });

  // The spot's offset turns with the flange, a shift of the block does not. Without an offset one shift
  // represents both.
  std::vector<Parameter> parameters{{"laser latency", b.latency_s, 0.001, b.bound_s}};
  constexpr std::size_t kNone = 99;
  const auto add = [&](bool wanted, const char* name) {
    if (!wanted) return kNone;
    parameters.push_back({name, 0.0, 0.1, b.reach_mm});
    return parameters.size() - 1;
  };
  const auto crosses = [&](bool along_x) {
    return std::any_of(c.all.begin(), c.all.end(), [&](const Crossing& k) { return k.along_x == along_x; });
  };
  const std::size_t ix = add(offset, "laser offset x"), iy = add(offset, "laser offset y");
  const bool shifted = !offset || c.turned;
  const std::size_t jx = add(shifted && crosses(true), "place of the block x"),
                    jy = add(shifted && crosses(false), "place of the block y");
  const Residual residual = [&](std::size_t i, const double* x, double* g) {
    const Crossing& k = c.all[i];
    const SpotTrack& track = c.tracks[k.pass];
    const Point2 p = track.at(k.time_s + x[0]), v = track.speed(k.time_s + x[0]);
    std::fill(g, g + parameters.size(), 0.0);
    double off = k.along_x ? p.x_mm : p.y_mm;
    g[0] = k.along_x ? v.x_mm : v.y_mm;
    if (offset) {
      g[ix] = k.along_x ? track.cos_yaw() : track.sin_yaw();
      g[iy] = k.along_x ? -track.sin_yaw() : track.cos_yaw();
      off += g[ix] * x[ix] + g[iy] * x[iy];
    }
    if (const std::size_t j = k.along_x ? jx : jy; j != kNone) {
      g[j] = -1.0;
      off -= x[j];
    }
    return off - k.side_mm;
  };
  LaserCalibration out;
  out.fit = robust_fit(parameters, c.all.size(), residual, 0.005);
  if (out.fit.outliers > kMaxOutliers * out.fit.data)
    throw Unidentifiable(std::to_string(out.fit.outliers) + " of " + std::to_string(out.fit.data) +
                         " steps do not lie on the sides of one block");
  out.edges = int(c.all.size());
  out.latency_s = out.fit.parameters[0];
  std::vector<double> x(parameters.size()), g(parameters.size());
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = out.fit.parameters[k].value;
  for (std::size_t i = 0; i < c.all.size(); ++i) {
    const Point2 v = c.tracks[c.all[i].pass].speed(c.all[i].time_s + x[0]);
    out.residuals.push_back(
        {c.all[i].along_x ? v.x_mm : v.y_mm, residual(i, x.data(), g.data()), c.all[i].along_x});
  }
  if (!offset) return out;
  out.x_mm = out.fit.parameters[ix];
  out.y_mm = out.fit.parameters[iy];
  out.x_mm.value += b.laser.x_mm;
  out.y_mm.value += b.laser.y_mm;
  if (c.turned) {
    out.block_x_mm = out.fit.parameters[jx];
    out.block_y_mm = out.fit.parameters[jy];
  }
  return out;
}

}  // namespace firn::calibration
