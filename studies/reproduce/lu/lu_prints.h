// print_seeds makes the prints behind the rows of `firn reproduce lu`: one experiment, many seeds, all
// threads.
#pragma once

#include <functional>
#include <vector>

#include "core/grid/shapes.h"
#include "print/simulated/memory_print.h"
#include "studies/reproduce/reproduce.h"

namespace firn {

/// Returns Lu's lab without drop-outs, for a centred square or disc of the given number of cells across.
Experiment lu_lab(const std::string& shape, double cells_across, double height_mm);

/// Returns target and mask of an analytic part.
Target lu_target(const Experiment& experiment);

/// Prints `experiment` with plant seeds 1 to `seeds`; the reports are in the order of the seeds, for any
/// number of threads. Progress goes from `from` to `to_fraction` of the part. @throws the exceptions of
/// print_in_memory
std::vector<MemoryPrintReport> print_seeds(const Experiment& experiment, int seeds, Reproduction& to,
                                           double from, double to_fraction, const std::string& doing);

double mean_of(const std::vector<MemoryPrintReport>& prints,
               const std::function<double(const MemoryPrintReport&)>& value);
double largest_of(const std::vector<MemoryPrintReport>& prints,
                  const std::function<double(const MemoryPrintReport&)>& value);

/// Holds heights along the row through the middle [um] against x [mm].
struct HeightProfile {
  std::vector<double> x_mm, height_um;
};
HeightProfile middle_row(const HeightMap& height, const GridSpec& grid);

}  // namespace firn
