#include "core/motion/kinematics/tool.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace firn::motion;

namespace {

Jets turning_pose(double t) {
  Jets pose(kTaskAxes, 1);
  const double values[kTaskAxes][4] = {{400 + 20 * t, 20, 0, 0},
                                       {5 * t * t, 10 * t, 10, 0},
                                       {3, 0, 0, 0},
                                       {0.4 + t + t * t * t, 1 + 3 * t * t, 6 * t, 6}};
  for (int axis = 0; axis < kTaskAxes; ++axis)
    for (int order = 0; order < 4; ++order) pose.of(axis, order)[0] = values[axis][order];
  return pose;
}

}  // namespace

TEST_CASE(
    "Table 3-1: the flange stands at the building frame's origin when the tool is over the part's origin") {
  const auto tools = cobra600_tools();
  REQUIRE(tools.size() == 4);
  const double frames[4][2] = {{0, 0}, {-0.1, -0.3}, {0.2, 8.2}, {-30, 19}};
  for (std::size_t i = 0; i < 4; ++i) {
    Jets part(kTaskAxes, 1), flange(kTaskAxes, 1);
    part.of(kX, 0)[0] = 260;
    part.of(kY, 0)[0] = -100;
    tool_to_flange(tools[i], part, flange);
    CHECK(flange.of(kX, 0)[0] == Approx(260 + frames[i][0]));
    CHECK(flange.of(kY, 0)[0] == Approx(-100 + frames[i][1]));
  }
}

TEST_CASE("A tool turned by the yaw keeps its distance from the flange, and the way back is exact") {
  const Tool tool{"pen", 30, -19, 7};
  const Jets pose = turning_pose(0.3);
  Jets flange(kTaskAxes, 1), back(kTaskAxes, 1);
  tool_to_flange(tool, pose, flange);
  const double dx = pose.of(kX, 0)[0] - flange.of(kX, 0)[0], dy = pose.of(kY, 0)[0] - flange.of(kY, 0)[0];
  CHECK(std::sqrt(dx * dx + dy * dy) == Approx(std::sqrt(30.0 * 30 + 19 * 19)));
  CHECK(pose.of(kZ, 0)[0] - flange.of(kZ, 0)[0] == Approx(7));
  flange_to_tool(tool, flange, back);
  for (int axis = 0; axis < kTaskAxes; ++axis)
    for (int order = 0; order < 4; ++order)
      CHECK(back.of(axis, order)[0] == Approx(pose.of(axis, order)[0]).margin(1e-12));
}

TEST_CASE("Derivatives of the flange under a turning tool agree with differences") {
  const Tool tool{"pen", 30, -19, 7};
  const double h = 1e-4;
  Jets before(kTaskAxes, 1), here(kTaskAxes, 1), after(kTaskAxes, 1);
  tool_to_flange(tool, turning_pose(0.3 - h), before);
  tool_to_flange(tool, turning_pose(0.3), here);
  tool_to_flange(tool, turning_pose(0.3 + h), after);
  for (int axis = 0; axis < kTaskAxes; ++axis)
    for (int order = 0; order < 3; ++order)
      CHECK(here.of(axis, order + 1)[0] ==
            Approx((after.of(axis, order)[0] - before.of(axis, order)[0]) / (2 * h))
                .epsilon(1e-6)
                .margin(1e-6));
}
