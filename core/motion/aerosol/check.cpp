#include "core/motion/aerosol/check.h"

#include <cmath>
#include <cstdio>

#include "core/motion/kinematics/require.h"

namespace firn::motion {
namespace {

bool finite(const Point2& p) { return std::isfinite(p.x_mm) && std::isfinite(p.y_mm); }

bool positive(double v) { return v > 0.0 && std::isfinite(v); }
bool not_negative(double v) { return v >= 0.0 && std::isfinite(v); }

std::string at(const Point2& p) { return "(" + text(p.x_mm) + ", " + text(p.y_mm) + ") mm"; }

std::string fault_of(const PrintSegment& s, const AerosolMachine& m) {
  if (!finite(s.from) || !finite(s.to)) return "a coordinate is not finite";
  if (!positive(s.speed_mm_s)) return "speed " + text(s.speed_mm_s) + " mm/s is not positive";
  if (coincide(s.from, s.to)) return "it has no length: both ends are " + at(s.from);
  const double dx = s.to.x_mm - s.from.x_mm, dy = s.to.y_mm - s.from.y_mm, length = distance(s.from, s.to);
  for (const auto& [axis, part] : {std::pair("x", dx), std::pair("y", dy)})
    if (const double v = std::abs(part) / length * s.speed_mm_s; v > m.axis.v_max_mm_s * (1.0 + 1e-12))
      return std::string("axis ") + axis + " needs " + text(v) + " mm/s, the stage has " +
             text(m.axis.v_max_mm_s) + " mm/s";
  return "";
}

}  // namespace

std::string text(double value, int decimals) {
  char digits[64];
  std::snprintf(digits, sizeof digits, "%.*f", decimals, value);
  std::string s = digits;
  if (s.find('.') == s.npos) return s;
  s.erase(s.find_last_not_of('0') + 1);
  if (s.back() == '.') s.pop_back();
  return s == "-0" ? "0" : s;
}

bool coincide(const Point2& a, const Point2& b) {
  return std::abs(a.x_mm - b.x_mm) <= 1e-6 && std::abs(a.y_mm - b.y_mm) <= 1e-6;
}

void check_machine(const AerosolMachine& m, const AerosolOptions& o) {
  require(positive(m.axis.v_max_mm_s), Reason::kLimitNotPositive, "v_max_mm_s", m.axis.v_max_mm_s);
  require(positive(m.axis.alpha_mm_s2), Reason::kLimitNotPositive, "acceleration_mm_s2", m.axis.alpha_mm_s2);
  require(positive(m.tick_s), Reason::kLimitNotPositive, "tick_s", m.tick_s);
  require(not_negative(m.shutter_delay_s), Reason::kOption, "shutter_delay_s", m.shutter_delay_s);
  require(not_negative(m.flow_mm3_s), Reason::kOption, "flow_mm3_s", m.flow_mm3_s);
  require(not_negative(o.tolerance_mm), Reason::kOption, "tolerance_mm", o.tolerance_mm);
  require(finite(m.stage_origin), Reason::kOption, "stage_origin_mm", m.stage_origin.x_mm);
  require(m.stage_low.x_mm < m.stage_high.x_mm, Reason::kOption, "stage_low_mm x", m.stage_low.x_mm);
  require(m.stage_low.y_mm < m.stage_high.y_mm, Reason::kOption, "stage_low_mm y", m.stage_low.y_mm);
}

std::vector<Refusal> check_job(const PrintJob& job, const AerosolMachine& machine) {
  std::vector<Refusal> refused;
  if (!finite(job.start)) refused.push_back({0, "the start point is not finite"});
  for (std::size_t i = 0; i < job.segments.size(); ++i)
    if (std::string why = fault_of(job.segments[i], machine); !why.empty())
      refused.push_back({std::int32_t(i), std::move(why)});
  if (!finite(job.end)) refused.push_back({std::int32_t(job.segments.size()), "the end point is not finite"});
  return refused;
}

}  // namespace firn::motion
