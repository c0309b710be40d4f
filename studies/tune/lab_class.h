// LabClass holds a class of laboratories that a log may come from: its parameters with their distribution
// before any log is read. The plant section of a recorded experiment is never one of its sources: a
// laboratory is known by its log alone.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "config/labs.h"
#include "plant/config/world_config.h"

namespace firn::tune {

/// A parameter is centre x exp(spread x z), or centre + spread x z where it has either sign, held within
/// [low, high]; z is standard normal before the log.
struct LabParameter {
  std::string_view name;  ///< of the key, or a name of its own
  std::string_view unit;
  double centre, spread, low, high;
  bool either_sign = false;

  double value(double z) const;
};

struct LabClass {
  std::string_view name;
  std::string_view meaning;
  std::span<const LabParameter> parameters;
  /// Sets the plant keys. @param values as many as parameters
  void (*set)(std::span<const double> values, Experiment& experiment);
  /// Sets the parameters without a key; nullptr: none.
  void (*nature)(std::span<const double> values, plant::WorldConfig& world);
  bool one_spacing = false;  ///< the parameters are those of the recorded grid

  std::vector<double> values(std::span<const double> z) const;
};

/// Returns the classes that are compared. Of droplets: those that land, flow and drift; the height-change
/// model with droplets of varying size [Lu 2015, V-A]. Of paths: valves that flow and drift over ice that
/// freezes rough. Of lines: none.
std::span<const LabClass> lab_classes(Deposition deposition = Deposition::kDroplets);

/// Returns the recorded experiment in a simulated laboratory of unknown parameters: no plant key of the
/// record is left, no real instrument and no fault of the bus.
Experiment without_plant(Experiment experiment);

}  // namespace firn::tune
