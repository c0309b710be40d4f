// Computes the frames between a tool point and an arm's flange.
#pragma once

#include <string>
#include <vector>

#include "core/motion/kinematics/jets.h"

namespace firn::motion {

/// A tool point in the frame of the flange (the end effector), whose x axis points along the yaw.
struct Tool {
  std::string name = "flange";
  double x_mm = 0.0;
  double y_mm = 0.0;
  double z_mm = 0.0;
};

/// The three tools of the ice printer. [Barnett 2012, Table 3-1] gives origins of building frames in the
/// end-effector frame, (-0.1, -0.3) water, (0.2, 8.2) scaffold, (-30, 19) laser: where the flange must be so
/// that the tool is over the part's origin. A tool's offset is therefore minus its frame's origin.
std::vector<Tool> cobra600_tools();

/// Flange poses for tool poses: flange = tool point - R(yaw) offset, with all derivatives (in place allowed).
void tool_to_flange(const Tool& tool, const Jets& tool_pose, Jets& flange);
/// And back.
void flange_to_tool(const Tool& tool, const Jets& flange, Jets& tool_pose);

}  // namespace firn::motion
