// identify_beads() computes the law of beads, ln dh = a ln v + b, from an imported record of speeds and
// heights.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/statistics/held_out.h"
#include "estimators/bead/bead_law.h"

namespace firn {

struct SegmentLaw {
  std::uint32_t segment = 0;  ///< cell of the grid
  std::int64_t beads = 0;
  bead::BeadLaw law;  ///< by recursive least squares, from the common law on
};

struct BeadIdentification {
  bead::BeadFit fit;          ///< of all layers
  std::int64_t left_out = 0;  ///< cells of printed layers without a measured height above 0 or a speed
  double mean_height_mm = 0.0;
  std::vector<SegmentLaw> segments;
  statistics::HeldOut
      common;  ///< predictions by one law for all segments, of the first two thirds of the layers
  statistics::HeldOut
      recursive;              ///< by each segment's law, which learns from each layer once it is predicted
  std::string uninformative;  ///< reason for which the record does not tell a; "" = none
  bool a_found() const {
    return uninformative.empty() && !(fit.a_half_width >= (fit.law.a < 0 ? -fit.law.a : fit.law.a));
  }
};

/// @throws UsageError naming the run: no imported record with inputs, fewer than three beads
BeadIdentification identify_beads(const std::filesystem::path& run);

/// The beads of a run, sorted by layer. @throws UsageError as above
std::vector<bead::Bead> recorded_beads(const std::filesystem::path& run);

/// The same of beads in memory. @param beads sorted by layer
BeadIdentification identify_beads(const std::vector<bead::Bead>& beads);

}  // namespace firn
