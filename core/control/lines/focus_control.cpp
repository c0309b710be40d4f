#include "core/control/lines/focus_control.h"

#include <algorithm>
#include <cmath>

namespace firn::control {
namespace {

constexpr double kMinEffect = 0.3, kMaxEffect = 3.0;  // that a width is believed to say
constexpr double kFollow = 0.5;                       // of what a layer after the first says

}  // namespace

FocusControl::FocusControl(const LineOptions& options, const SmfGains& gains, double output_limit)
    : options_(options), gains_(gains), output_limit_(output_limit) {}

void FocusControl::use_options(const LineOptions& options, const SmfGains& gains) {
  options_.sheath_range = options.sheath_range;
  gains_ = gains;
}

double FocusControl::next_share(std::int32_t layer, double squared_width) {
  if (layer != now_.layer) before_ = now_;
  now_ = before_;
  now_.layer = layer;
  now_.squared_width = layer > 0 ? squared_width : 0.0;
  if (layer == 0 || std::isnan(squared_width)) return now_.share;
  const double own = layer * squared_width - (layer - 1) * before_.squared_width;
  if (before_.layer == layer - 1 && !std::isnan(own)) {
    const double said =
        std::clamp(own * (1.0 + (before_.share - 1.0) / options_.focus_slope), kMinEffect, kMaxEffect);
    now_.effect += (layer == 1 ? 1.0 : kFollow) * (said - now_.effect);
  }
  const double e = layer * (1.0 - squared_width);
  now_.sum += e;
  if (gains_.ki_star > 0.0 && gains_.integral_limit > 0.0)
    now_.sum =
        std::clamp(now_.sum, -gains_.integral_limit / gains_.ki_star, gains_.integral_limit / gains_.ki_star);
  const double u = std::clamp(gains_.kp * e + gains_.ki_star * now_.sum, -output_limit_, output_limit_);
  now_.share = std::clamp(1.0 + options_.focus_slope * (now_.effect / (1.0 + u) - 1.0),
                          1.0 - options_.sheath_range, 1.0 + options_.sheath_range);
  return now_.share;
}

}  // namespace firn::control
