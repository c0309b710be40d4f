// Rules between the keys of the ice lab.
#include <algorithm>

#include "config/lab_checks.h"
#include "core/control/python_scheme.h"
#include "core/control/surface/surface_controller.h"

namespace firn {
namespace {

void check_valve(Rules& r, const char* table_hz, const ValveLineConfig& v) {
  r.require(v.table_hz.size() == v.table_mm3_s.size(), {table_hz}, "needs as many frequencies as flows");
  bool ascends = true;
  for (std::size_t n = 1; n < std::min(v.table_hz.size(), v.table_mm3_s.size()); ++n)
    ascends = ascends && v.table_hz[n] > v.table_hz[n - 1] && v.table_mm3_s[n] > v.table_mm3_s[n - 1];
  r.require(ascends, {table_hz}, "both columns of the flow curve must ascend");
}

}  // namespace

void check_ice_lab(Rules& r) {
  const Experiment& e = r.experiment();
  if (!control::is_python_scheme(e.control.scheme)) r.scheme_of(control::surface_schemes());
  const auto needs = [&](const char* key, const std::string& file) {
    r.require(!file.empty(), {key, "lab.kind"}, "an ice lab needs this file");
  };
  if (e.ice.paths.empty()) {
    needs("ice.mesh", e.ice.mesh);
    needs("ice.slice", e.ice.slice);
  }
  r.require(e.ice.paths.empty() || e.ice.mesh.empty(), {"ice.paths", "ice.mesh"},
            "the part is sliced already; set ice.mesh = \"\"");
  needs("ice.machine", e.ice.machine);
  const Range& limit = control::kSurfaceOutputLimit.range;
  r.require(limit.holds(e.control.smf.output_limit), {"control.smf.output_limit", "lab.kind"},
            "must lie in " + text(limit) + " where lab.kind = " + r.value("lab.kind"));
  r.require(e.ice.nozzle_gap_mm > e.ice.clearance_mm, {"ice.nozzle_gap_mm", "ice.clearance_mm"},
            "must be above ice.clearance_mm = " + r.value("ice.clearance_mm"));
  check_valve(r, "valve_a.table_hz", e.valve_a);
  check_valve(r, "valve_b.table_hz", e.valve_b);
  const IcePlantConfig& p = e.plant.ice;
  r.require(p.foot_mm.empty() || p.foot_mm.size() == 4, {"plant.ice.foot_mm"}, "needs four heights");
  r.require(p.screw_mm.empty() || p.screw_mm.size() == 9, {"plant.ice.screw_mm"}, "needs nine heights");
  r.require(p.jig_mm.size() % 5 == 0 && p.jig_mm.size() <= 80, {"plant.ice.jig_mm"},
            "needs five numbers of each of at most 16 blocks");
  r.require((p.field_width_mm > 0.0) == (p.field_depth_mm > 0.0),
            {"plant.ice.field_width_mm", "plant.ice.field_depth_mm"},
            "must be 0 together with plant.ice.field_depth_mm = " + r.value("plant.ice.field_depth_mm"));
  r.require(e.heater.low_degC < e.heater.tip_degC && e.heater.tip_degC < e.heater.high_degC,
            {"heater.tip_degC", "heater.low_degC", "heater.high_degC"},
            "must lie between heater.low_degC = " + r.value("heater.low_degC") +
                " and heater.high_degC = " + r.value("heater.high_degC"));
}

}  // namespace firn
