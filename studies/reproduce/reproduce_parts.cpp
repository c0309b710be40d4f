#include "studies/reproduce/reproduce_parts.h"

namespace firn {

// {paper, name, title, seconds on one core, function of reproduce_parts.h}
const std::vector<ReproducePart>& reproduce_parts() {
  static const std::vector<ReproducePart> parts{
      {"lu", "model-check", "III-C, V-D.1, Figs. 8, 21, 22: what the models foretell", 4, reproduce_lu_model},
      {"lu", "alpha", "(8), IV-C: what alpha and the horizon do", 60, reproduce_lu_alpha},
      {"lu", "figs-11-12", "Figs. 11, 12: the cylinder under model variation", 30, reproduce_lu_cylinder},
      {"lu", "table-2", "Table II: the small square", 5, reproduce_lu_table_2},
      {"lu", "identification", "IV-C, V-C, Table I: exact recovery, identification prints, spacing", 40,
       &reproduce_lu_identification},
      {"lu", "figs-13-15", "Figs. 13-15: two materials, the junction of two pipes", 50,
       &reproduce_lu_materials},
      {"barnett", "slicing", "ch. 3: Tables 3-2 to 3-5, Figs. 3-2 and 3-7", 5, &reproduce_barnett_slicing},
      {"barnett", "motion", "ch. 4: minimum-time trajectory shaping, Figs. 4-2 to 4-16", 1,
       reproduce_barnett_motion},
      {"barnett", "pulses", "chapter 6: valve pulses, Figs. 6-2 and 6-3, FM against PWM", 1,
       &reproduce_barnett_pulses},
      {"barnett", "fig-6-1", "6.1, Fig. 6-1: the flow of a valve by its frequency, weighed", 5,
       &reproduce_barnett_flow},
      {"barnett", "gains",
       "5.4 to 5.7: SMF's poles, optimal gains, simulations, Figs. 5-12 to 5-15, Tables 5-2, 5-3", 2,
       reproduce_barnett_gains},
      {"barnett", "build-time", "4.4: the part of Fig. 4-15 by three ways of moving, 11.6 / 7.4 / 2.6 h", 5,
       &reproduce_barnett_build_time},
      {"barnett", "gear", "5.3, Figs. 5-8, 5-9: the helical gear with and without feedback, 0.84 and 0.12 mm",
       200, &reproduce_barnett_gear},
      {"barnett", "part", "5.3: the part of Fig. 4-15 printed in the simulated lab and measured, Table 5-1",
       80, &reproduce_barnett_part},
      {"thompson", "corners", "Figs. 7 to 12, speed and position errors at corners", 1,
       reproduce_thompson_corners},
      {"thompson", "misprints", "formulas that are wrong as printed", 1, reproduce_thompson_misprints},
      {"thompson", "corner-modes", "the paper's corners, loops, rounded corners", 1,
       reproduce_thompson_corner_modes},
  };
  return parts;
}

}  // namespace firn
