#include "studies/calibrate/lab_calibrations.h"

#include <fmt/core.h>

namespace firn::lab_calibrations {

Experiment with_field(Experiment e, double x_mm, double y_mm, double width_mm, double depth_mm) {
  IcePlantConfig& p = e.plant.ice;
  p.field_x0_mm = x_mm;
  p.field_y0_mm = y_mm;
  p.field_width_mm = width_mm;
  p.field_depth_mm = depth_mm;
  return e;
}

Experiment with_jig(Experiment e) {
  const CalibrationConfig& c = e.calibration;
  if (e.plant.ice.jig_mm.empty())
    e.plant.ice.jig_mm = {c.jig_x_mm, c.jig_y_mm, c.jig_x_mm + c.jig_width_mm, c.jig_y_mm + c.jig_depth_mm,
                          c.jig_height_mm};
  return e;
}

void check_intervals(const LabCalibration& c) {
  for (const FoundKey& k : c.keys)
    for (std::size_t n = 0; n < k.value.size(); ++n)
      if (k.tolerance > 0.0 && !(k.ci95_half_width[n] <= k.tolerance))
        throw calibration::Unidentifiable(fmt::format("{}.{} is known to +- {:.{}f} {} only; {} {} is needed",
                                                      k.section, k.key, k.ci95_half_width[n], k.digits,
                                                      k.unit, k.tolerance, k.unit));
}

}  // namespace firn::lab_calibrations
