#include "estimators/calibration/laser.h"

#include <algorithm>
#include <cmath>

namespace firn::calibration {
namespace {

constexpr double kLeastStep_mm = 0.3;   // of an edge
constexpr int kHalf = 3;                // readings that make a level
constexpr double kLeastSpeed_mm_s = 2.0;

/// The flange-frame spot as believed, along one pass: position by time.
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
    for (std::size_t i = 0; i < n; ++i) at_.push_back({spot.of(motion::kX, 0)[i] - b.origin.x_mm, spot.of(motion::kY, 0)[i] - b.origin.y_mm});
  }
  double end_s() const { return tick_s_ * double(at_.size() - 1); }
  Point2 at(double t_s) const {
    const double k = std::clamp(t_s / tick_s_, 0.0, double(at_.size() - 1));
    const std::size_t i = std::min(std::size_t(k), at_.size() - 2);
    const double f = k - double(i);
    return {at_[i].x_mm + f * (at_[i + 1].x_mm - at_[i].x_mm), at_[i].y_mm + f * (at_[i + 1].y_mm - at_[i].y_mm)};
  }
  Point2 speed(double t_s) const {
    const Point2 a = at(t_s - 0.5 * tick_s_), b = at(t_s + 0.5 * tick_s_);
    return {(b.x_mm - a.x_mm) / tick_s_, (b.y_mm - a.y_mm) / tick_s_};
  }

 private:
  double tick_s_;
  std::vector<Point2> at_;
};

struct Crossing {
  std::size_t pass;
  double time_s;   ///< of the reading, without latency
  bool along_x;    ///< the side lies across x
  double side_mm;
};

double middle(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2), v.end());
  return v[v.size() / 2];
}

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
    const double low = middle(before), high = middle(after), step = high - low, here = double(z[valid[n]]), next = double(z[valid[n + 1]]);
    const double level = 0.5 * (low + high);
    if (std::abs(step) < kLeastStep_mm || (here - level) * step > 0.0 || (next - level) * step <= 0.0) continue;
    if (valid[n + 1] - valid[n] > 2) continue;  // values are missing at the edge itself
    const double share = std::abs(next - here) < 0.5 * std::abs(step) ? (level - here) / (next - here) : 0.5;
    steps.emplace_back(pass.period_s * (double(valid[n]) + share * double(valid[n + 1] - valid[n])), step > 0.0);
    n += kHalf;
  }
  return steps;
}

}  // namespace

LaserCalibration calibrate_laser(std::span<const LaserPass> passes, const Jig& jig, const LaserBelief& b, LaserUnknowns what) {
  std::vector<SpotTrack> tracks;
  std::vector<Crossing> crossings;
  bool up[2] = {}, down[2] = {};
  for (std::size_t n = 0; n < passes.size(); ++n) {
    tracks.emplace_back(passes[n], b);
    for (const auto& [time, rises] : steps_of(passes[n])) {
      const double at = time + b.latency_s;
      if (at < 0.0 || at > tracks.back().end_s()) continue;
      const Point2 v = tracks.back().speed(at);
      const bool along_x = std::abs(v.x_mm) > std::abs(v.y_mm);
      const double speed = along_x ? v.x_mm : v.y_mm;
      if (std::abs(speed) < kLeastSpeed_mm_s) continue;
      const bool low_side = (speed > 0.0) == rises;  // entered going up, or left going down
      crossings.push_back({n, time, along_x, along_x ? (low_side ? jig.x0_mm : jig.x1_mm) : (low_side ? jig.y0_mm : jig.y1_mm)});
      (speed > 0.0 ? up : down)[along_x ? 0 : 1] = true;
    }
  }
  const bool both_x = up[0] && down[0], both_y = up[1] && down[1];
  if (!both_x && !both_y) throw Uninformative("no side of the block was crossed both ways: the latency cannot be told from an offset");
  if (what == LaserUnknowns::kOffset && !((up[0] || down[0]) && (up[1] || down[1])))
    throw Uninformative(std::string("no side across ") + (up[0] || down[0] ? "y" : "x") + " was crossed: the offset along it cannot be told");
  if (what == LaserUnknowns::kLatency) std::erase_if(crossings, [&](const Crossing& c) { return c.along_x ? !both_x : !both_y; });

  // Unknown that no crossing knows of are left out.
  const bool has_x = std::any_of(crossings.begin(), crossings.end(), [](const Crossing& c) { return c.along_x; });
  const bool has_y = std::any_of(crossings.begin(), crossings.end(), [](const Crossing& c) { return !c.along_x; });
  std::vector<Unknown> unknowns{{"laser latency", b.latency_s, 0.001, b.reach_s}};
  const std::size_t ix = unknowns.size();
  if (has_x) unknowns.push_back({"laser offset x", 0.0, 0.1, b.reach_mm});
  const std::size_t iy = unknowns.size();
  if (has_y) unknowns.push_back({"laser offset y", 0.0, 0.1, b.reach_mm});
  const Residual residual = [&](std::size_t i, const double* x, double* g) {
    const Crossing& c = crossings[i];
    const SpotTrack& track = tracks[c.pass];
    const Point2 p = track.at(c.time_s + x[0]), v = track.speed(c.time_s + x[0]);
    std::fill(g, g + unknowns.size(), 0.0);
    g[0] = c.along_x ? v.x_mm : v.y_mm;
    g[c.along_x ? ix : iy] = 1.0;
    return (c.along_x ? p.x_mm + x[ix] : p.y_mm + x[iy]) - c.side_mm;
  };
  LaserCalibration out;
  out.fit = robust_fit(unknowns, crossings.size(), residual, 0.005);
  out.edges = int(crossings.size());
  out.latency_s = out.fit.unknowns[0];
  if (what == LaserUnknowns::kLatency) return out;
  // Passes are run with one yaw; 0 here, so that the part's axes are the flange's.
  out.x_mm = out.fit.unknowns[ix], out.y_mm = out.fit.unknowns[iy];
  out.x_mm.value += b.laser.x_mm, out.y_mm.value += b.laser.y_mm;
  return out;
}

}  // namespace firn::calibration
