// Holds an experiment that sets keys of every kind, for the tests of config/.
#pragma once

namespace firn::test {

inline constexpr const char* kExperiment = R"(# a comment
[run]
name = "cylinder-8"

[grid]
nx = 48
ny = 44
pitch_x_mm = 0.25
pitch_y_mm = 0.25
origin_x_mm = 1.5

[part]
shape = "pipe"
height_mm = 0.5
diameter_mm = 9
inner_diameter_mm = 4.25

[control]
scheme = "mpc"
smf.kp = 0.9
mpc = { horizon = 2, alpha = [{from_layer = 1, alpha = 0.8}, {from_layer = 20, alpha = 1.0}], seed = 7 }

[plant]
model = "lu2015"
seed = 9007199254740993
)";

}  // namespace firn::test
