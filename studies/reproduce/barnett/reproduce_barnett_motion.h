// Chapter4 holds the trajectories of chapter 4 of [Barnett 2012], which the rows and the pictures share.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/path_input.h"
#include "core/motion/thesis/thesis.h"
#include "studies/reproduce/reproduce.h"

namespace firn::barnett {

/// Emitted samples seen from outside: differences at the tick. Rates of sample n belong to (n + 1/2) ticks
/// and so on.
struct Sampled {
  std::vector<double> t_s, s_mm;                  ///< n: time, travelled distance
  std::vector<Point2> at;                         ///< n
  std::vector<double> speed, acceleration, jerk;  ///< total: n - 1, n - 2, n - 3
  struct Joint {
    std::vector<double> angle, rate, acceleration, jerk;  ///< deg, deg/s, ...
  };
  std::vector<Joint> joints;  ///< J1 and J2
  double duration_s() const { return t_s.back(); }
};
Sampled sampled(const Trajectory& trajectory, const motion::Arm& arm);

double largest(const std::vector<double>& values);

/// The path of Fig. 4-2 at both places of Fig. 4-3, by the thesis's method and by the two older ones.
struct Chapter4 {
  std::vector<Point2> points;
  std::unique_ptr<motion::Arm> arm;
  motion::ThesisResult well, poor;
  Sampled well_seen, poor_seen, fallback_seen;  ///< fallback: the "default" technique of 4.4
  double fallback_blend_s = 0.0;
};
Chapter4 plan_chapter_4();

/// The box of Fig. 4-15: walls between the contour of Fig. 4-2 and a 116 mm one (Table 5-1), boundaries 1.5
/// mm wide, fill 3 mm wide (4.2), as closed contours `offset` mm outside the inner one.
std::vector<Point2> box_contour(double offset_mm, double spacing_mm = 0.4);
struct BoxLayer {
  std::vector<std::vector<Point2>> boundaries, contours;  ///< concentric fill
  std::vector<std::vector<Point2>> lines;  ///< straight fill across the walls, not linked (ZZFILL)
};
BoxLayer box_layer();

void pictures(Reproduction& to, const Chapter4& planned);

}  // namespace firn::barnett
