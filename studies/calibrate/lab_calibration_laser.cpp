// Computes offset and latency of the point laser from passes over a block.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/grid/random.h"
#include "estimators/calibration/laser.h"
#include "studies/calibrate/calibration_lab.h"
#include "studies/calibrate/lab_calibrations.h"

namespace firn {
namespace {

using calibration::Jig;
using calibration::LaserPass;
using calibration::LaserUnknowns;

constexpr double kOffsetTolerance_mm = 0.2, kLatencyTolerance_s = 0.002;  // 5.2.1
constexpr double kAbove_mm =
    3.0;  // the nozzles pass at this height over the table; the block lies within the laser's range
constexpr double kRunUp_s = 0.7;     // for the end effector's ringing to die down
constexpr double kBeside_mm = 15.0;  // of the block, where the table's height is read
constexpr double kReach_mm = 6.0;    // maximum error of the offset

Jig jig_of(const Experiment& e) {
  const CalibrationConfig& c = e.calibration;
  return {c.jig_x_mm, c.jig_y_mm, c.jig_x_mm + c.jig_width_mm, c.jig_y_mm + c.jig_depth_mm};
}

struct PassPlan {
  bool along_x = true, forward = true;
  double speed_mm_s = 0.0, yaw_rad = 0.0;
};

/// Starts and speeds are drawn, so that readings fall differently on the sides: equal passes would repeat
/// their error.
LabPass pass_over(const CalibrationLab& lab, const Jig& jig, double table_mm, const PassPlan& p,
                  RandomStream& random) {
  LabPass pass;
  pass.tool = lab.tool("laser");
  pass.z_mm = table_mm + kAbove_mm;
  pass.yaw_rad = p.yaw_rad;
  pass.speed_mm_s = p.speed_mm_s * random.uniform(0.85, 1.0);
  const double run_up = kReach_mm + kRunUp_s * p.speed_mm_s + random.uniform(0.0, 5.0);
  const double low = (p.along_x ? jig.x0_mm : jig.y0_mm) - run_up,
               high = (p.along_x ? jig.x1_mm : jig.y1_mm) + run_up;
  const double side = p.along_x ? jig.y1_mm - jig.y0_mm : jig.x1_mm - jig.x0_mm;
  const double aside = (p.along_x ? jig.y0_mm : jig.x0_mm) + side * random.uniform(0.4, 0.6);
  const auto at = [&](double s) { return p.along_x ? Point2{s, aside} : Point2{aside, s}; };
  pass.points = p.forward ? std::vector<Point2>{at(low), at(high)} : std::vector<Point2>{at(high), at(low)};
  return pass;
}

std::vector<LaserPass> run(CalibrationLab& lab, const Jig& jig, const std::vector<PassPlan>& plans,
                           const LabCalibrationOptions& o) {
  RandomStream random(o.seed, Purpose::kInstrument);
  std::vector<LaserPass> passes;
  lab.get_ready();
  const double table_mm = lab.surface_mm(jig.x0_mm - kBeside_mm, 0.5 * (jig.y0_mm + jig.y1_mm));
  for (const PassPlan& p : plans) {
    LaserPass pass{
        lab.plan(pass_over(lab, jig, table_mm, p, random)), 1.0 / lab.experiment().laser_point.rate_hz, {}};
    pass.reading_mm = lab.scan(pass.motion, 0);
    passes.push_back(std::move(pass));
    if (o.progress) o.progress(double(passes.size()) / double(plans.size()));
  }
  return passes;
}

calibration::LaserBelief belief(const CalibrationLab& lab, const motion::Arm& arm) {
  const Experiment& e = lab.experiment();
  return {arm, lab.tool("laser"), {e.ice.origin_x_mm, e.ice.origin_y_mm}, e.laser_point.latency_s, kReach_mm,
          0.2};
}

calibration::LaserCalibration measured(CalibrationLab& lab, const std::vector<PassPlan>& plans,
                                       LaserUnknowns parameters, const LabCalibrationOptions& o) {
  const Jig jig = jig_of(lab.experiment());
  const std::vector<LaserPass> passes = run(lab, jig, plans, o);
  const auto arm = make_arm(lab.machine());
  return calibration::calibrate_laser(passes, jig, belief(lab, *arm), parameters);
}

void add_fit(const calibration::LaserCalibration& c, LabCalibration& out) {
  out.data = c.fit.data;
  out.outliers = c.fit.outliers;
  out.residual_std = c.fit.residual_std;
  out.residual_unit = "mm";
  out.plot = {"speed across the side [mm/s]",
              "spot off the side [mm]",
              {{"sides across x", {}, {}}, {"sides across y", {}, {}}}};
  for (const auto& r : c.residuals) {
    ResidualPlot::Group& g = out.plot.groups[r.along_x ? 0 : 1];
    g.x.push_back(r.speed_mm_s);
    g.y.push_back(r.off_mm);
  }
  std::erase_if(out.plot.groups, [](const ResidualPlot::Group& g) { return g.x.empty(); });
}

std::vector<double> speeds_or(const LabCalibrationOptions& o, std::vector<double> own) {
  return o.speeds_mm_s.empty() ? own : o.speeds_mm_s;
}

}  // namespace

LabCalibration calibrate_laser_offset(const Experiment& experiment, const std::string& machine_toml,
                                      const LabCalibrationOptions& o) {
  using namespace lab_calibrations;
  CalibrationLab lab(with_jig(with_field(experiment, -60.0, -60.0, 10.0, 10.0)), machine_toml);
  std::vector<PassPlan> plans;
  for (int n = 0; n < (o.repeats > 0 ? o.repeats : 5); ++n)
    for (const double yaw : {0.0, std::numbers::pi})
      for (const double speed : speeds_or(o, {30.0}))
        for (const bool along_x : {true, false})
          for (const bool forward : {true, false}) plans.push_back({along_x, forward, speed, yaw});
  const auto c = measured(lab, plans, LaserUnknowns::kOffset, o);
  LabCalibration out;
  out.what = "laser-offset";
  const LaserPointConfig& l = experiment.laser_point;
  const ToolConfig& tool = lab.machine().laser;
  out.keys = {{"laser_point",
               "offset_x_mm",
               "mm",
               {c.x_mm.value - tool.x_mm},
               {c.x_mm.ci95_half_width},
               {l.offset_x_mm},
               3,
               false,
               kOffsetTolerance_mm},
              {"laser_point",
               "offset_y_mm",
               "mm",
               {c.y_mm.value - tool.y_mm},
               {c.y_mm.ci95_half_width},
               {l.offset_y_mm},
               3,
               false,
               kOffsetTolerance_mm}};
  out.also.emplace_back("latency [s]", c.latency_s);
  if (c.block_x_mm) out.also.emplace_back("block beyond calibration.jig_x_mm [mm]", *c.block_x_mm);
  if (c.block_y_mm) out.also.emplace_back("block beyond calibration.jig_y_mm [mm]", *c.block_y_mm);
  out.lines.push_back(
      std::to_string(plans.size()) +
      " passes over the block, half of them with the flange turned by 180 degrees: the yaw is read off the "
      "joints, and the block's own place is found with the offset");
  add_fit(c, out);
  out.lab_s = lab.now_s();
  check_intervals(out);
  return out;
}

LabCalibration calibrate_laser_latency(const Experiment& experiment, const std::string& machine_toml,
                                       const LabCalibrationOptions& o) {
  using namespace lab_calibrations;
  CalibrationLab lab(with_jig(with_field(experiment, -60.0, -60.0, 10.0, 10.0)), machine_toml);
  std::vector<PassPlan> plans;
  for (int n = 0; n < (o.repeats > 0 ? o.repeats : 16); ++n)
    for (const double speed : speeds_or(o, {100.0}))
      for (const bool forward : {true, false}) plans.push_back({true, forward, speed, 0.0});
  const auto c = measured(lab, plans, LaserUnknowns::kLatency, o);
  LabCalibration out;
  out.what = "laser-latency";
  out.keys = {{"laser_point",
               "latency_s",
               "s",
               {c.latency_s.value},
               {c.latency_s.ci95_half_width},
               {experiment.laser_point.latency_s},
               5,
               false,
               kLatencyTolerance_s}};
  out.lines.push_back(std::to_string(plans.size()) +
                      " passes both ways over two sides of the block, whose place need not be known");
  add_fit(c, out);
  out.lab_s = lab.now_s();
  check_intervals(out);
  return out;
}

}  // namespace firn
