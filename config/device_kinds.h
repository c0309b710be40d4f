// Kinds of instruments: the words of `[devices.NODE] kind`, and which classes take a driver in Python.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "config/experiment.h"
#include "drivers/jet/jet_config.h"
#include "drivers/script/script_options.h"

namespace firn {

struct DeviceKinds {
  std::string_view node;
  std::array<std::string_view, 2> words;  ///< the first is the default; "" = no more
  bool or_python;                         ///< or "python:FILE.py:CLASS"
};
inline constexpr DeviceKinds kDeviceKinds[] = {
    {"stage", {"ensemble", "grbl"}, true},
    {"jet", drivers::kJetKindWords, true},
    {"jet_b", drivers::kJetKindWords, true},
    {"laser_profiler", {"ljv", "lkg"}, true},
    {"lamp", {"omnicure"}, true},
    {"robot", {"fvp"}, false},
    {"valve_a", {"fvb"}, false},
    {"valve_b", {"fvb"}, false},
    {"laser_point", {"lkg"}, true},
    {"heater", {"thermostat"}, true},
    {"camera", {"picture_line"}, true},
    {"gas", {"alicat"}, true},
};

/// Returns devices.NODE.kind as it was given; empty: it was not.
const std::string& device_kind(const Experiment& experiment, std::string_view node);

/// Returns whether the stage is a GRBL board.
bool has_grbl_stage(const Experiment& experiment);

/// Returns whether a point laser that the stage moves takes the profiler's place.
bool has_point_scan(const Experiment& experiment);

/// Returns whether the instrument is driven by a class in Python.
bool is_python_driver(const Experiment& experiment, std::string_view node);

/// Returns whether such a class reaches its instrument by itself (port "python:"), so that no bytes pass
/// here.
bool has_own_port(const Experiment& experiment, std::string_view node);

/// Returns the class that drives the instrument. @pre is_python_driver(experiment, node)
drivers::ScriptOptions script_options(const Experiment& experiment, std::string_view node,
                                      double host_latency_s);

}  // namespace firn
