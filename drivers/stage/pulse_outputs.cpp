#include "drivers/stage/pulse_outputs.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "drivers/stage/stage_tag.h"

namespace firn::drivers {

using ensemble::Line;

namespace {

void push_arm(int axis, const ensemble::Table& table, Link& link) {
  Line line(table, Repeat::kNever, stage_tag::kMotion);
  link.push(with_axis(line, "PSOCONTROL @", axis).text(" ARM"));
}

}  // namespace

void PulseOutputs::forget(int increments) {
  held_.assign(std::size_t(std::max(increments, 0)), -1);
  set_up_.fill(false);
}

void PulseOutputs::lend_to_way() {
  set_up_[0] = false;
  std::fill(held_.begin(), held_.end(), -1);
}

void PulseOutputs::set_up(int axis, const StageConfig& config, const ensemble::Table& table, Link& link) {
  if (set_up_[std::size_t(axis)]) return;
  const auto setup = [&](std::string_view verb, std::string_view rest) {
    link.push(ensemble::setting(table, verb, axis, rest, stage_tag::kPlain));
  };
  setup("PSOCONTROL @", " RESET");
  if (on(config.pulse_terminal)) setup("PSOOUTPUT @", " CONTROL 1");
  setup("PSOOUTPUT @", " PULSE");
  setup("PSOPULSE @", " TIME " + std::to_string(config.dialect.pulse_total_us) + "," +
                          std::to_string(config.dialect.pulse_on_us));
  setup("PSOTRACK @", " INPUT " + std::to_string(table.feedback_input));
  set_up_[std::size_t(axis)] = true;
}

void PulseOutputs::arm_scan(int axis, double pitch_mm, const StageConfig& config,
                            const ensemble::Table& table, Link& link) {
  set_up(axis, config, table, link);
  Line line(table, Repeat::kSetup, stage_tag::kPlain);
  link.push(line.text("PSODISTANCE ").axis(axis).text(" FIXED ").fixed4(pitch_mm).text(" UNITS"));
  push_arm(axis, table, link);
}

void PulseOutputs::arm_row(int axis, std::span<const std::int64_t> wanted, const StageConfig& config,
                           const ensemble::Table& table, Link& link) {
  set_up(axis, config, table, link);
  // An increment that the controller still holds is kept if the pulse lands within the tolerance: grid
  // pitches are seldom whole counts, and exact rounding would rewrite most of a full row each time.
  std::int64_t error = 0;  // of the pulse before, counts
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::int64_t held = held_[i];
    if (held > 0 && std::abs(error + held - wanted[i]) <= config.dialect.pulse_tolerance_counts) {
      error += held - wanted[i];
      continue;
    }
    const std::int64_t exact = wanted[i] - error;
    error = 0;
    held_[i] = -2 - exact;  // held once acknowledged
    Request r = Line(table, Repeat::kSetup, stage_tag::kIncrement)
                    .text("IGLOBAL(")
                    .integer(table.first_iglobal + std::int64_t(i))
                    .text(")=")
                    .integer(exact);
    r.argument = std::int32_t(i);
    link.push(r);
  }
  Line line(table, Repeat::kSetup, stage_tag::kPlain);
  link.push(line.text("PSOARRAY ")
                .axis(axis)
                .text(",")
                .integer(table.first_iglobal)
                .text(",")
                .integer(std::int64_t(wanted.size())));
  link.push(ensemble::setting(table, "PSODISTANCE @", axis, " ARRAY", stage_tag::kPlain));
  push_arm(axis, table, link);
}

}  // namespace firn::drivers
