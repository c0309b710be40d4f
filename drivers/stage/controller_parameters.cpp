#include "drivers/stage/controller_parameters.h"

#include <cmath>
#include <cstdio>

#include "drivers/stage/stage_tag.h"

namespace firn::drivers {

using ensemble::Line;

void ControllerParameters::ask(const ensemble::Table& table, Link& link) {
  const auto push = [&](int axis, ensemble::Parameter parameter) {
    Line line(table, Repeat::kRead, stage_tag::kParameter, ensemble::kValue);
    Request r = line.text("GETPARM(").axis(axis).text(", ").integer(parameter).text(")").done();
    r.argument = 3 * parameter + axis;
    link.push(r);
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const auto parameter : {ensemble::kCountsPerUnit, ensemble::kSoftwareLimitLow,
                                 ensemble::kSoftwareLimitHigh, ensemble::kSoftwareLimitSetup})
      push(axis, parameter);
  push(0, ensemble::kGlobalIntegers);
}

void ControllerParameters::take(std::int32_t argument, double value) {
  Axis& of = axes_[std::size_t(argument) % 3];
  switch (argument / 3) {
    case ensemble::kCountsPerUnit:
      of.counts_per_unit = value;
      break;
    case ensemble::kSoftwareLimitLow:
      of.low_limit_mm = value;
      break;
    case ensemble::kSoftwareLimitHigh:
      of.high_limit_mm = value;
      break;
    case ensemble::kSoftwareLimitSetup:
      of.limit_setup = value;
      break;
    default:
      global_integers_ = value >= 0.0 && value < 1e6 ? int(value) : 0;
  }
}

std::optional<std::string> ControllerParameters::mismatch(const StageConfig& config,
                                                          const std::array<AxisLimits, 3>& limits) const {
  char text[200];
  for (std::size_t a = 0; a < 3; ++a) {
    const Axis& p = axes_[a];
    const char axis = "XYZ"[a], key = char(axis - 'A' + 'a');
    if (!(std::abs(p.counts_per_unit - config.counts_per_mm) <= 1e-6 * config.counts_per_mm)) {
      std::snprintf(text, sizeof text, "axis %c: CountsPerUnit is %g, stage.counts_per_mm is %g", axis,
                    p.counts_per_unit, config.counts_per_mm);
      return text;
    }
    if (p.limit_setup == 0.0) {
      std::snprintf(text, sizeof text, "axis %c: the controller's soft limits are off (SoftwareLimitSetup)",
                    axis);
      return text;
    }
    constexpr double kRounding_mm = 1e-4;
    if (!(p.low_limit_mm <= limits[a].min_mm + kRounding_mm &&
          p.high_limit_mm >= limits[a].max_mm - kRounding_mm)) {
      std::snprintf(text, sizeof text,
                    "axis %c: the controller's soft limits [%g, %g] mm are inside stage.%c_min_mm, "
                    "stage.%c_max_mm [%g, %g] mm",
                    axis, p.low_limit_mm, p.high_limit_mm, key, key, limits[a].min_mm, limits[a].max_mm);
      return text;
    }
  }
  if (global_integers_ <= config.first_iglobal) {
    std::snprintf(text, sizeof text,
                  "GlobalIntegers is %d: none is left for firing distances from stage.first_iglobal = %d",
                  global_integers_, config.first_iglobal);
    return text;
  }
  return std::nullopt;
}

}  // namespace firn::drivers
