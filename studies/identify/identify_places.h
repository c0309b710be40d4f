// identify_places() computes the heights that droplets at each place inside their cells add, from a print of
// rows of single droplets (experiments/places.toml), and proposes the keys of a lab file.
#pragma once

#include <string>
#include <vector>

#include "core/grid/offsets.h"
#include "estimators/droplet/place_prints.h"
#include "print/folder/observed_run.h"

namespace firn {

struct PlaceIdentification {
  OffsetOptions options;  ///< whose table the kernels are of
  OffsetTable printed, table;
  int layers = 0;
  droplet::PlacePrints prints;
  /// Largest difference of each place's kernel from the mixture of model.h1_mm..h3_mm that the run had, a
  /// share of the droplet's height.
  std::vector<double> mixed_error;
  std::string uninformative;  ///< reason for which the run does not tell the heights; "" = none
};

/// Returns true if a run prints single droplets at places beside the centres.
bool prints_places(const Experiment& experiment);

/// @param kind of the wanted table, with the run's numbers of places
PlaceIdentification identify_places(const ObservedRun& run, OffsetKind kind = OffsetKind::kGrid);

/// Returns actuation.* as TOML, for a lab file. @pre identified
std::string places_toml(const PlaceIdentification& id);

}  // namespace firn
