# The instruments: one row each. docs/write-a-driver.md says what else a new one needs.
#   firn_instrument(NAME DRIVER sources in drivers/NAME TWIN sources in plant/twins TEST sources in tests/drivers)
# procs/NAME holds its node and its programs.
function(firn_instrument name)
  cmake_parse_arguments(ARG "" "" "DRIVER;TWIN;TEST" ${ARGN})
  list(TRANSFORM ARG_DRIVER PREPEND ${name}/)
  list(TRANSFORM ARG_TWIN PREPEND twins/)
  set(FIRN_INSTRUMENTS ${FIRN_INSTRUMENTS} ${name} PARENT_SCOPE)
  set(FIRN_INSTRUMENT_NODES ${FIRN_INSTRUMENT_NODES} firn_node_${name} PARENT_SCOPE)
  set(FIRN_DRIVER_${name} ${ARG_DRIVER} PARENT_SCOPE)
  set(FIRN_INSTRUMENT_TWINS ${FIRN_INSTRUMENT_TWINS} ${ARG_TWIN} PARENT_SCOPE)
  set(FIRN_INSTRUMENT_TESTS ${FIRN_INSTRUMENT_TESTS} ${ARG_TEST} PARENT_SCOPE)
endfunction()

firn_instrument(stage DRIVER controller_parameters.cpp ensemble.cpp grbl.cpp grbl_link.cpp grbl_stage.cpp pulse_outputs.cpp raster.cpp script_stage.cpp stage.cpp stage_driver.cpp stage_link.cpp
                stage_service.cpp stage_way.cpp way_readout.cpp
                TWIN grbl.cpp path_follower.cpp servo.cpp stage.cpp stage_dialect.cpp stage_path.cpp track.cpp TEST stage_test.cpp stage_setup_test.cpp stage_trace_test.cpp stage_followed_test.cpp grbl_test.cpp)
firn_instrument(jet DRIVER jetdrive.cpp jet.cpp jet_driver.cpp jet_kinds.cpp jet_service.cpp microdrop.cpp script_jet.cpp TWIN jet.cpp microdrop.cpp
                TEST jet_test.cpp microdrop_test.cpp)
firn_instrument(laser_profiler DRIVER ljv.cpp laser_profiler.cpp laser_profiler_service.cpp point_scan.cpp script_profiler.cpp TWIN laser_profiler.cpp point_scan.cpp profile_sensor.cpp TEST laser_profiler_test.cpp point_scan_test.cpp)
firn_instrument(lamp DRIVER omnicure.cpp lamp.cpp lamp_status.cpp script_lamp.cpp
                TWIN lamp.cpp TEST lamp_test.cpp lamp_status_test.cpp script_lamp_test.cpp script_kinds_test.cpp)
firn_instrument(robot DRIVER fvp.cpp robot.cpp robot_link.cpp robot_paths.cpp
                TWIN arm_controller.cpp fvp.cpp robot.cpp robot_paths.cpp vplus_robot.cpp vplus/controller.cpp vplus/evaluator.cpp vplus/executor.cpp
                vplus/expression_parser.cpp vplus/lexer.cpp vplus/machine.cpp
                vplus/parser.cpp vplus/statement_parser.cpp vplus/tcp_server.cpp vplus/variables.cpp TEST robot_test.cpp robot_reset_test.cpp fake_robot.cpp)
firn_instrument(valve DRIVER fvb.cpp valve.cpp valve_service.cpp TWIN firmware_valve.cpp valve.cpp fvb.cpp TEST valve_test.cpp fake_valve.cpp)
firn_instrument(laser_point DRIVER lkg.cpp laser_point.cpp script_point.cpp TWIN laser_point.cpp lkg.cpp TEST laser_point_test.cpp fake_laser.cpp)
firn_instrument(heater DRIVER thermostat.cpp heater.cpp heater_driver.cpp script_heater.cpp TWIN heater.cpp firmware_heater.cpp TEST heater_test.cpp)
firn_instrument(gas DRIVER alicat.cpp gas.cpp gas_driver.cpp script_gas.cpp TWIN gas.cpp TEST gas_test.cpp)
firn_instrument(camera DRIVER picture_line.cpp camera.cpp camera_driver.cpp script_camera.cpp TWIN camera.cpp TEST camera_test.cpp camera_world_test.cpp)
