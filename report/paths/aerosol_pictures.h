// Draws pictures of a shuttered printer's plan: the path over the segments, speeds, positions and errors
// against time.
#pragma once

#include <string>

#include "core/motion/aerosol/plan.h"

namespace firn::report {

/// Draws the nozzle's path over the substrate in true proportion, coloured by speed where the shutter is
/// open. [Thompson 2014, Fig. 8]
std::string aerosol_path_picture(const PrintJob& job, const motion::AerosolPlan& plan,
                                 const std::string& title);

/// Draws the speeds of both axes and of the nozzle; grey where the shutter is closed. [Fig. 9]
std::string aerosol_speed_picture(const motion::AerosolPlan& plan, const std::string& title);
std::string aerosol_position_picture(const motion::AerosolPlan& plan, const std::string& title);

/// Draws speed error [%] and position error [um] against time while the shutter is open. [Figs. 10, 12]
std::string aerosol_speed_error_picture(const PrintJob& job, const motion::AerosolPlan& plan,
                                        const std::string& title);
std::string aerosol_path_error_picture(const PrintJob& job, const motion::AerosolPlan& plan,
                                       const std::string& title);

/// Draws the acceleration of both axes; the limit as a dashed line.
std::string aerosol_acceleration_picture(const motion::AerosolPlan& plan,
                                         const motion::AerosolMachine& machine, const std::string& title);

/// Draws all of the above in one file of its own.
std::string aerosol_plot(const PrintJob& job, const motion::AerosolPlan& plan,
                         const motion::AerosolMachine& machine, const std::string& title);

}  // namespace firn::report
