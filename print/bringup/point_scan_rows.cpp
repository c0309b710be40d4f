// Rows of a point laser that the stage moves in the profiler's place (docs/devices/point_scan.md).
#include <cmath>

#include "config/device_kinds.h"
#include "drivers/laser_point/lkg.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

using drivers::lkg::Status;
using drivers::lkg::Value;

Value value_now(BringupLab& lab, const std::string& node) {
  const std::string reply = lab.line(node)->ask_line("M1\r", '\r');
  constexpr std::string_view kName = "M1,";
  if (!reply.starts_with(kName)) throw BringupStop("M1 is answered " + drivers::shown_line(reply));
  return drivers::lkg::parse_value(
      std::string_view(reply).substr(kName.size(), reply.size() - kName.size() - 1));
}

// The driver selects the program and reads it back before it is safe.
BringupFinding point_measures(BringupLab& lab, const std::string& node) {
  if (const std::string why = lab.drive(node, "stop"); !why.empty())
    return {false, why, "program " + std::to_string(lab.e.laser_profiler.program),
            "laser_profiler.program, or the controller's panel is locked"};
  const Value v = value_now(lab, node);
  return {v.status == Status::kOk, v.status == Status::kOk ? number_text(v.mm) + " mm" : "no value",
          "a value", "the surface is out of the head's range, or its kind is another than the program's"};
}

BringupFinding point_gauge(BringupLab& lab, const std::string& node) {
  constexpr double kGauge_mm = 0.5, kTolerance_mm = 0.05;
  const Value before = value_now(lab, node);
  const auto laid =
      lab.ask(67, "lay a gauge block of " + number_text(kGauge_mm) + " mm under the spot; done?");
  if (!laid) return {false, "", "", "needs a person"};
  const Value after = value_now(lab, node);
  const double sign = lab.e.laser_profiler.z_sign == drivers::ZSign::kUp ? 1.0 : -1.0;
  const double rise_mm = sign * (after.mm - before.mm);
  const bool turned = std::abs(rise_mm + kGauge_mm) <= kTolerance_mm;
  return {std::abs(rise_mm - kGauge_mm) <= kTolerance_mm,
          number_text(std::round(rise_mm * 1e3) / 1e3) + " mm", "+" + number_text(kGauge_mm) + " mm",
          turned ? std::string("it counts downwards: laser_profiler.z_sign = \"") +
                       (sign > 0.0 ? "down" : "up") + "\""
                 : "wrong unit or scaling of output 1: the controller's panel"};
}

constexpr BringupRow kPointScanRows[] = {
    {65, "laser_profiler", "takes laser_profiler.program, and M1 gives a value [C]", "laser_profiler.program",
     &point_measures},
    {66, "laser_profiler",
     "one `TG,1,...` a pulse of the stage's Y output at its timing input, none without: at a terminal [P]",
     "the controller's RS-232C output"},
    {67, "laser_profiler", "sign and unit of z by a gauge block", "laser_profiler.z_sign", &point_gauge},
};

}  // namespace

std::span<const BringupRow> point_scan_rows() { return kPointScanRows; }

}  // namespace firn
