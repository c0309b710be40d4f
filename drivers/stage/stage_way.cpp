#include "drivers/stage/stage_way.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/stage/stage_tag.h"

namespace firn::drivers {
namespace {

constexpr std::size_t kMaxKnots = 3000;  // 5 doubles each of the controller's DGLOBAL [P]

}  // namespace

using ensemble::Line;

std::optional<std::string> way_refused(const StageWay& way, const std::array<AxisLimits, 3>& limits,
                                       const StageConfig& config, const ensemble::Table& table) {
  char text[160];
  const auto said = [&](std::size_t k, const std::string& what) {
    return "knot " + std::to_string(k) + ": " + what;
  };
  if (way.knots.size() < 2 || way.knots.size() > kMaxKnots)
    return "a way of " + std::to_string(way.knots.size()) + " knots; 2 to " + std::to_string(kMaxKnots) +
           " can be followed";
  if (way.switch_mm.size() % 2 != 0 || way.switch_mm.size() > std::size_t(std::max(0, table.increments())))
    return std::to_string(way.switch_mm.size()) + " switches of the shutter; an even number up to " +
           std::to_string(table.increments()) + " can be held";
  for (std::size_t k = 0; k < way.knots.size(); ++k) {
    const WayKnot& at = way.knots[k];
    if (const auto why = limit_broken('X', at.x_mm, limits[0])) return said(k, *why);
    if (const auto why = limit_broken('Y', at.y_mm, limits[1])) return said(k, *why);
    const double speed = std::sqrt(at.vx_mm_s * at.vx_mm_s + at.vy_mm_s * at.vy_mm_s);
    if (!(speed <= limits[0].max_speed_mm_s)) {
      std::snprintf(text, sizeof text, "speed %.4f mm/s is above %.4f mm/s", speed, limits[0].max_speed_mm_s);
      return said(k, text);
    }
    if (k == 0 ? at.t_s != 0.0 : !(at.t_s > way.knots[k - 1].t_s))
      return said(k, "times do not ascend from 0");
  }
  std::int64_t before = 0;
  for (std::size_t n = 0; n < way.switch_mm.size(); ++n) {
    const auto counts = std::int64_t(std::llround(way.switch_mm[n] * config.counts_per_mm));
    if (counts <= before)
      return "switch " + std::to_string(n) + " of the shutter is not behind the one before";
    before = counts;
  }
  return std::nullopt;
}

void push_way(const StageWay& way, std::int64_t sample_period_ms, const StageConfig& config,
              const ensemble::Table& table, Link& link) {
  const auto set = [&](const char* name, std::int64_t index) -> Line {
    return Line(table, Repeat::kSetup, stage_tag::kPlain).text(name).text("(").integer(index).text(")=");
  };
  link.push(set("IGLOBAL", config.dialect.path_count_iglobal).integer(std::int64_t(way.knots.size())));
  if (sample_period_ms > 0) {
    link.push(set("IGLOBAL", config.dialect.path_period_iglobal).integer(sample_period_ms));
    link.push(set("IGLOBAL", config.dialect.path_samples_iglobal).integer(0));
  }
  for (std::size_t k = 0; k < way.knots.size(); ++k) {
    const WayKnot& at = way.knots[k];
    // The start is where the stage stands, to the rounding of its target.
    const double numbers[] = {at.t_s, at.x_mm, at.y_mm, at.vx_mm_s, at.vy_mm_s};
    for (std::size_t n = 0; n < 5; ++n) link.push(set("DGLOBAL", std::int64_t(5 * k + n)).fixed9(numbers[n]));
  }
  const auto setup = [&](std::string_view verb, std::string_view rest) {
    link.push(ensemble::setting(table, verb, 0, rest, stage_tag::kPlain));
  };
  setup("PSOCONTROL @", " RESET");
  if (on(config.pulse_terminal)) setup("PSOOUTPUT @", " CONTROL 1");
  setup("PSOOUTPUT @", " TOGGLE");
  setup(config.dialect.path_track, "");
  if (way.switch_mm.empty()) return;
  std::int64_t before = 0;
  for (std::size_t n = 0; n < way.switch_mm.size(); ++n) {
    const auto counts = std::int64_t(std::llround(way.switch_mm[n] * config.counts_per_mm));
    link.push(set("IGLOBAL", table.first_iglobal + std::int64_t(n)).integer(counts - before));
    before = counts;
  }
  Line array(table, Repeat::kSetup, stage_tag::kPlain);
  link.push(array.text("PSOARRAY ")
                .axis(0)
                .text(",")
                .integer(table.first_iglobal)
                .text(",")
                .integer(std::int64_t(way.switch_mm.size())));
  setup("PSODISTANCE @", " ARRAY");
  Line arm(table, Repeat::kNever, stage_tag::kMotion);
  link.push(with_axis(arm, "PSOCONTROL @", 0).text(" ARM"));
}

}  // namespace firn::drivers
