# Sources of the labs, by room; each room's CMakeLists.txt takes its own. docs/write-a-lab.md
set(FIRN_CONFIG_LABS aerosol_lab.cpp ice_lab.cpp ice_lab_checks.cpp)
set(FIRN_PLANT_LABS aerosol/deposit.cpp aerosol/line_picture.cpp aerosol/source.cpp world/aerosol_lab.cpp world/ice_lab.cpp world/inkjet_lab.cpp)
set(FIRN_SCHEDULER_LABS line_loop.cpp line_supply.cpp droplet_loop.cpp path_loop.cpp path_commands.cpp path_map_check.cpp)
set(FIRN_REPORT_LABS run/report_followed.cpp run/report_lines.cpp run/report_ice.cpp run/report_ice_data.cpp run/report_inks.cpp)
set(FIRN_PRINT_LABS labs/aerosol_print.cpp labs/ice_print.cpp)
