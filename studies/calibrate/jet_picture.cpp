#include "studies/calibrate/jet_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "report/draw/svg.h"

namespace firn {
namespace {

using calibration::JetSpeed;
using report::svg_text;

constexpr double kWidth = 980, kHeight = 420, kBar = 1.96;
constexpr int kCurvePoints = 80;

struct Panel {
  report::Frame frame;
  report::Axis x, y;
  std::string marks(const std::vector<JetSpeed>& speeds, double JetSpeed::*at) const {
    std::string s;
    for (const JetSpeed& p : speeds)
      s += fmt::format(
          "<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"var(--c0)\" stroke-width=\"1\"/><circle "
          "cx=\"{0:.1f}\" "
          "cy=\"{3:.1f}\" r=\"3\" fill=\"var(--c0)\"/>",
          x.px(p.*at), y.px(p.velocity_m_s - kBar * p.std_m_s), y.px(p.velocity_m_s + kBar * p.std_m_s),
          y.px(p.velocity_m_s));
    return s;
  }
  template <class Curve>
  std::string curve(double from, double to, Curve&& value) const {
    std::string s = "<path fill=\"none\" stroke=\"var(--c1)\" stroke-width=\"1.6\" d=\"";
    for (int k = 0; k <= kCurvePoints; ++k) {
      const double at = from + (to - from) * k / kCurvePoints;
      s += fmt::format("{}{:.1f} {:.1f}", k ? 'L' : 'M', x.px(at),
                       y.px(std::clamp(value(at), y.low(), y.high())));
    }
    return s + "\"/>";
  }
  std::string upright(double at, const std::string& text) const {
    const bool left = x.px(at) > 0.5 * (frame.left + frame.right);
    return fmt::format(
               "<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"var(--c2)\" stroke-dasharray=\"5 4\" "
               "stroke-width=\"1.4\" fill=\"none\"/>",
               x.px(at), frame.top, frame.bottom) +
           svg_text(x.px(at) + (left ? -6 : 6), frame.bottom - 10, left ? "end" : "start", "tick", text);
  }
};

Panel panel(double left, const std::vector<JetSpeed>& speeds, double JetSpeed::*at, double max_m_s) {
  const auto [low, high] = std::ranges::minmax(speeds, {}, at);
  const double pad = 0.05 * std::max(high.*at - low.*at, 1e-9);
  const report::Frame f{left, 44, left + 400, 352};
  return {f, report::Axis(low.*at - pad, high.*at + pad, f.left, f.right, 6),
          report::Axis(0.0, 1.1 * max_m_s, f.bottom, f.top, 6)};
}

}  // namespace

std::string jet_picture(const JetSweeps& s) {
  double most = s.wanted_m_s;
  for (const auto* list : {&s.by_dwell, &s.by_voltage})
    for (const JetSpeed& p : *list) most = std::max(most, p.velocity_m_s + kBar * p.std_m_s);
  const Panel left = panel(64, s.by_dwell, &JetSpeed::dwell_us, most),
              right = panel(550, s.by_voltage, &JetSpeed::volts, most);
  const auto [low, high] = std::ranges::minmax(s.by_voltage, {}, &JetSpeed::volts);
  const double d = s.dwell.dwell_us.value, w = s.dwell.half_width_us;
  std::string svg = report::svg_open(kWidth, kHeight, "velocity by waveform, firn calibrate jet");
  svg += svg_text(left.frame.left, 24, "start", "name",
                  fmt::format("fastest at {:.2f} +- {:.2f} us", d, s.dwell.dwell_us.ci95_half_width));
  svg += draw_axes(left.frame, left.x, left.y, "dwell time [us]", "velocity [m/s]");
  svg += left.curve(std::max(left.x.low(), d - w), std::min(left.x.high(), d + w),
                    [&](double at) { return s.dwell.at(at); });
  svg += left.marks(s.by_dwell, &JetSpeed::dwell_us) +
         left.upright(s.proposed_us, fmt::format("proposed: {:.1f} us", s.proposed_us));
  svg += svg_text(right.frame.left, 24, "start", "name",
                  fmt::format("{:g} m/s at {:.2f} +- {:.2f} V", s.wanted_m_s, s.line.volts.value,
                              s.line.volts.ci95_half_width));
  svg += draw_axes(right.frame, right.x, right.y, "voltage of the first pulse [V]", "");
  svg += right.curve(low.volts, high.volts, [&](double at) { return s.line.at(at); });
  svg += right.marks(s.by_voltage, &JetSpeed::volts) +
         right.upright(s.proposed_v, fmt::format("proposed: {:.0f} V", s.proposed_v));
  return svg + "</svg>";
}

}  // namespace firn
