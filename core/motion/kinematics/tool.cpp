#include "core/motion/kinematics/tool.h"

#include "core/exact/exact_math.h"

namespace firn::motion {
namespace {

/// out = in + sign * R(yaw) offset. With u = o exp(i phi):
/// u' = i phi' u, u'' = (i phi'' - phi'^2) u, u''' = (i (phi''' - phi'^3) - 3 phi' phi'') u.
void shift(const Tool& tool, double sign, const Jets& in, Jets& out) {
  for (std::size_t n = 0; n < in.samples(); ++n) {
    const double phi = in.of(kYaw, 0)[n], f1 = in.of(kYaw, 1)[n], f2 = in.of(kYaw, 2)[n],
                 f3 = in.of(kYaw, 3)[n];
    const auto [s, c] = exact::sincos(phi);
    const double ux = sign * (c * tool.x_mm - s * tool.y_mm), uy = sign * (s * tool.x_mm + c * tool.y_mm);
    const double real[4] = {1.0, 0.0, -f1 * f1, -3.0 * f1 * f2};
    const double imaginary[4] = {0.0, f1, f2, f3 - f1 * f1 * f1};
    for (int order = 0; order < 4; ++order) {
      out.of(kX, order)[n] = in.of(kX, order)[n] + real[order] * ux - imaginary[order] * uy;
      out.of(kY, order)[n] = in.of(kY, order)[n] + real[order] * uy + imaginary[order] * ux;
      out.of(kZ, order)[n] = in.of(kZ, order)[n] + (order == 0 ? sign * tool.z_mm : 0.0);
      out.of(kYaw, order)[n] = in.of(kYaw, order)[n];
    }
  }
}

}  // namespace

std::vector<Tool> cobra600_tools() {
  return {{"flange", 0.0, 0.0, 0.0},
          {"water", 0.1, 0.3, 0.0},
          {"scaffold", -0.2, -8.2, 0.0},
          {"laser", 30.0, -19.0, 0.0}};
}

void tool_to_flange(const Tool& tool, const Jets& tool_pose, Jets& flange) {
  shift(tool, -1.0, tool_pose, flange);
}

void flange_to_tool(const Tool& tool, const Jets& flange, Jets& tool_pose) {
  shift(tool, 1.0, flange, tool_pose);
}

}  // namespace firn::motion
