#include "core/control/lines/line_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace firn::control {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kEndClearance_mm = 0.5;
constexpr double kMinShare = 0.2,
                 kMaxShare = 5.0;  // of the nominal flow, that a section is believed to say
constexpr double kLargestDelay_s = 0.5;
constexpr double kMaxSaid_mm = 1.0;  // an end farther off is no shutter's delay
constexpr int kNeighbours = 2;       // stations on either side whose shares are averaged

// Means over a station and its readable neighbours of the same line, which are kNeighbours stations on
// either side, or more where a curve of short segments has shorter stations; NaN where none is.
std::vector<double> smoothed(const std::vector<double>& share, const std::vector<LineStation>& stations,
                             double station_mm) {
  std::vector<double> way_mm(share.size(), 0.0);  // middles
  for (std::size_t s = 1; s < share.size(); ++s)
    way_mm[s] = way_mm[s - 1] + 0.5 * (stations[s].to_mm - stations[s].from_mm + stations[s - 1].to_mm -
                                       stations[s - 1].from_mm);
  std::vector<double> out(share.size(), kNaN);
  for (std::size_t s = 0; s < share.size(); ++s) {
    const double length_mm = std::max(0.5 * station_mm, stations[s].to_mm - stations[s].from_mm);
    double sum = 0.0;
    int n = 0;
    const auto near = [&](std::size_t k) {
      return stations[k].line == stations[s].line &&
             std::abs(way_mm[k] - way_mm[s]) < (kNeighbours + 0.5) * length_mm;
    };
    std::size_t k = s;
    while (k > 0 && near(k - 1)) --k;
    for (; k < share.size() && near(k); ++k) {
      if (std::isnan(share[k])) continue;
      sum += share[k];
      ++n;
    }
    if (n > 0) out[s] = sum / n;
  }
  return out;
}

// A station without a value has that of the nearest one along the way; 1 where there is none at all.
void fill(std::vector<double>& values, double otherwise) {
  double last = kNaN;
  for (double& v : values) std::isnan(v) ? void(v = last) : void(last = v);
  last = kNaN;
  for (auto v = values.rbegin(); v != values.rend(); ++v) std::isnan(*v) ? void(*v = last) : void(last = *v);
  for (double& v : values)
    if (std::isnan(v)) v = otherwise;
}

LineSetup checked(LineSetup setup) {
  check_options("lines", kLineOptions, setup.options);
  return setup;
}

}  // namespace

LineController::LineController(LineSetup setup)
    : setup_(checked(std::move(setup))),
      focus_(setup_.options, setup_.gains, setup_.output_limit),
      stations_(line_stations(setup_.job, setup_.options.station_mm)),
      ends_(line_ends(setup_.job, kEndClearance_mm)) {
  if (stations_.empty()) throw std::invalid_argument("lines: the print job has no segments");
  now_.sum.assign(stations_.size(), 0.0);
  now_.error.assign(stations_.size(), 0.0);
  now_.open_delay_s = now_.close_delay_s = setup_.machine.shutter_delay_s;
  before_ = now_;
  std::vector<double> nominal;
  for (const LineStation& s : stations_)
    nominal.push_back(setup_.job.segments[std::size_t(s.segment)].speed_mm_s);
  const motion::AerosolPlan first = plan(nominal);
  if (!first.ok())
    throw std::invalid_argument("segments[" + std::to_string(first.refused[0].segment) +
                                "]: " + first.refused[0].reason);
}

void LineController::use_options(const LineOptions& options, const SmfGains& gains) {
  setup_.options.speed_range = options.speed_range;
  setup_.gains = gains;
  focus_.use_options(options, gains);
}

double LineController::nominal_area_mm2(std::size_t station) const {
  return setup_.machine.flow_mm3_s * setup_.options.solids /
         setup_.job.segments[std::size_t(stations_[station].segment)].speed_mm_s;
}

void LineController::learn_flow(const LineMeasurement& m) {
  std::vector<double> share(stations_.size(), kNaN);
  const double dry_mm3_s = setup_.machine.flow_mm3_s * setup_.options.solids;
  for (std::size_t s = 0; s < share.size(); ++s) {
    const double said = m.last[s].area_mm2 * measured_speed_[s] / dry_mm3_s;
    if (said >= kMinShare && said <= kMaxShare) share[s] = said;
  }
  share = smoothed(share, stations_, setup_.options.station_mm);
  if (std::ranges::all_of(share, [](double v) { return std::isnan(v); })) return;
  fill(share, 1.0);
  now_.share_before = std::move(now_.share);
  now_.share = std::move(share);
}

void LineController::learn(const LineMeasurement& m) {
  if (m.layer != now_.layer) {
    before_ = now_;
    measured_speed_ = printed_speed_;
  }
  now_ = before_;
  now_.layer = m.layer;
  if (m.layer == 0) return;
  learn_flow(m);
  for (std::size_t s = 0; s < stations_.size(); ++s) {
    const double nominal = nominal_area_mm2(s);
    const double e = (m.layer * nominal - m.total[s].area_mm2) / nominal;
    now_.error[s] = e;  // NaN: not read
    if (!std::isnan(e)) now_.sum[s] += e;
    if (const double most =
            setup_.gains.ki_star > 0.0 ? setup_.gains.integral_limit / setup_.gains.ki_star : 0.0;
        most > 0.0)
      now_.sum[s] = std::clamp(now_.sum[s], -most, most);
  }
  if (!setup_.feedback || !on(setup_.options.identify_shutter)) return;
  double speed = 0.0;
  for (const double v : measured_speed_) speed += v / double(measured_speed_.size());
  // The first layers say most; later ones average the noise of the ends away.
  const auto follow = [&](double& delay_s, int& seen, double error_mm) {
    if (std::isnan(error_mm) || std::abs(error_mm) > kMaxSaid_mm) return;
    ++seen;
    const double gain = seen == 1 ? 1.0 : seen == 2 ? 0.7 : 0.3;
    delay_s = std::clamp(delay_s + gain * error_mm / speed, 0.0, kLargestDelay_s);
  };
  follow(now_.open_delay_s, now_.open_seen, m.start_error_mm);
  follow(now_.close_delay_s, now_.close_seen, m.end_error_mm);
}

double LineController::foreseen_share(std::size_t s) const {
  if (now_.share.empty()) return 1.0;
  if (now_.share_before.empty()) return now_.share[s];
  return std::clamp(2.0 * now_.share[s] - now_.share_before[s], kMinShare, kMaxShare);
}

motion::AerosolPlan LineController::plan(const std::vector<double>& speed_mm_s) const {
  PrintJob job{setup_.job.start, setup_.job.end, {}};
  for (std::size_t s = 0; s < stations_.size(); ++s) {
    const LineStation& at = stations_[s];
    const PrintSegment& whole = setup_.job.segments[std::size_t(at.segment)];
    const bool first = s == 0 || stations_[s - 1].segment != at.segment;
    const bool last = s + 1 == stations_.size() || stations_[s + 1].segment != at.segment;
    const auto place = [&](double mm) {
      return Point2{whole.from.x_mm + mm * at.direction.x_mm, whole.from.y_mm + mm * at.direction.y_mm};
    };
    const Point2 from = first ? whole.from : job.segments.back().to, to = last ? whole.to : place(at.to_mm);
    if (!first && job.segments.back().speed_mm_s == speed_mm_s[s])
      job.segments.back().to = to;  // one piece at one speed
    else
      job.segments.push_back({from, to, speed_mm_s[s]});
  }
  motion::AerosolMachine machine = setup_.machine;
  machine.shutter_delay_s = std::max(now_.open_delay_s, now_.close_delay_s);
  return motion::plan_aerosol(job, machine, {setup_.options.corner, setup_.options.tolerance_mm, true});
}

LineDecision LineController::decide(const LineMeasurement& m) {
  if (m.total.size() != stations_.size() || m.last.size() != stations_.size())
    throw std::invalid_argument("lines: " + std::to_string(m.total.size()) + " stations are measured, " +
                                std::to_string(stations_.size()) + " are printed");
  if (printed_speed_.empty() && m.layer > 0)
    throw std::invalid_argument("lines: layer " + std::to_string(m.layer) +
                                " is measured and none was planned");
  learn(m);
  LineDecision d;
  if (m.layer >= setup_.options.layers) {
    d.kind = PlanDecision::kEnd;
    d.reason = "all " + std::to_string(setup_.options.layers) + " layers are printed";
    return d;
  }
  if (setup_.feedback && setup_.options.width_by == WidthActuator::kGas)
    d.sheath_share = focus_.next_share(m.layer, m.squared_width);
  const SmfGains& k = setup_.gains;
  std::vector<double> speed(stations_.size());
  double share_sum = 0.0;
  for (std::size_t s = 0; s < speed.size(); ++s) {
    const double nominal = setup_.job.segments[std::size_t(stations_[s].segment)].speed_mm_s;
    speed[s] = nominal;
    if (!setup_.feedback || m.layer == 0) continue;
    const double e = now_.error[s], e_before = before_.error[s];
    double u = kNaN;
    if (!std::isnan(e))
      u = k.kp * e + k.ki_star * now_.sum[s] +
          (m.layer > 1 && !std::isnan(e_before) ? k.kd_star * (e - e_before) : 0.0);
    // The error of layer k holds the flow's change up to it; fed forward, the next layer's own is met as
    // well.
    const double share = on(setup_.options.feed_forward) ? foreseen_share(s) : 1.0;
    share_sum += share;
    speed[s] = std::isnan(u)
                   ? kNaN
                   : nominal * share / (1.0 + std::clamp(u, -setup_.output_limit, setup_.output_limit));
  }
  if (setup_.feedback && m.layer > 0) {
    d.flow_share = share_sum / double(speed.size());
    for (std::size_t s = 0; s < speed.size(); ++s)  // a station that cannot be read goes as the flow says
      if (std::isnan(speed[s])) {
        const double nominal = setup_.job.segments[std::size_t(stations_[s].segment)].speed_mm_s;
        speed[s] = nominal * (on(setup_.options.feed_forward) ? foreseen_share(s) : 1.0);
      }
    for (std::size_t s = 0; s < speed.size(); ++s) {
      const double nominal = setup_.job.segments[std::size_t(stations_[s].segment)].speed_mm_s;
      const double range = setup_.options.speed_range;
      const Point2 w = stations_[s].direction;
      const double axis = std::max(std::abs(w.x_mm), std::abs(w.y_mm));
      speed[s] = std::clamp(speed[s], (1.0 - range) * nominal, (1.0 + range) * nominal);
      speed[s] = std::min(speed[s], 0.98 * setup_.machine.axis.v_max_mm_s / axis);
    }
    // Around a corner that is rounded both sides go at one speed.
    if (setup_.options.corner == motion::CornerMode::kHybrid)
      for (std::size_t s = 1; s < speed.size(); ++s)
        if (stations_[s].segment != stations_[s - 1].segment &&
            setup_.job.segments[std::size_t(stations_[s].segment)].from ==
                setup_.job.segments[std::size_t(stations_[s - 1].segment)].to)
          speed[s] = speed[s - 1] = std::min(speed[s], speed[s - 1]);
  }
  motion::AerosolPlan next = plan(speed);
  if (!next.ok()) {  // blends need room: one speed for each segment, else the nominal ones
    for (std::size_t first = 0, end = 0; first < speed.size(); first = end) {
      double sum = 0.0;
      for (end = first; end < speed.size() && stations_[end].segment == stations_[first].segment; ++end)
        sum += speed[end];
      std::fill(speed.begin() + std::ptrdiff_t(first), speed.begin() + std::ptrdiff_t(end),
                sum / double(end - first));
    }
    next = plan(speed);
  }
  if (!next.ok()) {
    for (std::size_t s = 0; s < speed.size(); ++s)
      speed[s] = setup_.job.segments[std::size_t(stations_[s].segment)].speed_mm_s;
    next = plan(speed);
  }
  if (!next.ok()) {
    d.kind = PlanDecision::kStop;
    d.reason = "segments[" + std::to_string(next.refused[0].segment) + "]: " + next.refused[0].reason;
    return d;
  }
  if (setup_.feedback && m.layer > 0 &&
      std::ranges::all_of(m.total, [](const LineReading& r) { return std::isnan(r.area_mm2); }))
    d.reason = "no station of the lines could be measured: the layer is printed without feedback";
  printed_speed_ = speed;
  d.way = way_of(next, now_.open_delay_s, now_.close_delay_s);
  d.duration_s = next.duration_s();
  d.open_s = next.report.print_s;
  for (const LineStation& s : stations_) d.printed_mm += s.to_mm - s.from_mm;
  d.open_delay_s = now_.open_delay_s;
  d.close_delay_s = now_.close_delay_s;
  d.speed_mm_s = std::move(speed);
  return d;
}

}  // namespace firn::control
