// Declares the parts of firn reproduce: one declaration here and one row in reproduce_parts.cpp for each.
#pragma once

#include "studies/reproduce/reproduce.h"

namespace firn {

void reproduce_lu_cylinder(Reproduction& to);
void reproduce_lu_alpha(Reproduction& to);
void reproduce_lu_model(Reproduction& to);
void reproduce_lu_table_2(Reproduction& to);
void reproduce_lu_identification(Reproduction& to);
void reproduce_lu_materials(Reproduction& to);
void reproduce_barnett_motion(Reproduction& to);
void reproduce_barnett_pulses(Reproduction& to);
void reproduce_barnett_gains(Reproduction& to);
void reproduce_barnett_part(Reproduction& to);
void reproduce_barnett_build_time(Reproduction& to);
void reproduce_barnett_gear(Reproduction& to);
void reproduce_barnett_flow(Reproduction& to);
void reproduce_barnett_slicing(Reproduction& to);
void reproduce_thompson_corners(Reproduction& to);
void reproduce_thompson_misprints(Reproduction& to);
void reproduce_thompson_corner_modes(Reproduction& to);

}  // namespace firn
