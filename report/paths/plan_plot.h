// Draws pictures of a planned path [Barnett 2012, Figs. 4-7, 4-8, 4-11]: speed, acceleration and jerk against
// time with their limits, in total and for each joint; the path coloured by its speed, and over the points'
// polygon by its deviation; each limit's activity along the path.
#pragma once

#include <string>
#include <vector>

#include "core/motion/kinematics/limits.h"
#include "core/motion/planner.h"

namespace firn::report {

struct PlanPlot {
  std::string title;
  std::vector<motion::TraceSample> trace;
  motion::MotionLimits limits;
  Certificate certificate;
  std::vector<Point2> points;            ///< of the path; empty: no deviation is drawn
  double deviation_mm = 0.0;             ///< proved bound
  std::vector<std::string> joint_names;  ///< those with a limit
  std::vector<std::string> joint_units;  ///< "rad" or "mm"; angles are drawn in degrees
};

/// Returns one self-contained SVG. @pre at least two samples
std::string plan_picture(const PlanPlot& plot);
/// Returns two plans beside each other, with one axis of time, as one SVG.
std::string plan_pictures_beside(const PlanPlot& left, const PlanPlot& right);

/// Computes a trace by differences of the emitted samples: for methods that have no continuous motion behind
/// them.
std::vector<motion::TraceSample> trace_of_samples(const Trajectory& trajectory,
                                                  const std::vector<Point2>& tool);

/// Draws only the path, coloured by speed: for embedding (classes and colours of report/draw/style.cpp).
/// Where s_mm falls, another path begins.
std::string speed_map(const std::vector<motion::TraceSample>& trace, double top_mm_s,
                      const std::string& title);

}  // namespace firn::report
