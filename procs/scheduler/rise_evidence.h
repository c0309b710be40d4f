// RiseEvidence holds the evidence of a layer's two maps about the ink that was fired between them: sums over
// cells of the measured and the expected rise, with the variance that the maps themselves show.
#pragma once

#include <array>
#include <vector>

#include "config/experiment.h"
#include "core/grid/grid.h"
#include "core/grid/material.h"
#include "core/grid/offsets.h"

namespace firn {

/// Sums over cells that are judged together. The rise x of a cell is expected to be e, of which c counts, and
/// has the variance v.
struct RiseSum {
  double cells = 0.0, measured_mm = 0.0, expected_mm = 0.0;
  double variance_mm2 = 0.0;    ///< of measured_mm
  double information = 0.0;     ///< sum of c^2 / v
  double share = 0.0;           ///< sum of c x / v; by information: the share of c that is there
  double share_variance = 0.0;  ///< of `share`; information if cells are independent
  void add(const RiseSum& r);
  /// The share is below, or above, `limit` by so many standard deviations.
  bool below(double limit, double sigmas) const;
  bool above(double limit, double sigmas) const;
  /// The sum of the rise is above `limit` times the expected one by so many.
  bool sum_above(double limit, double sigmas) const;
};

/// A layer's evidence. The expected rise of a cell is that of the model on flat ground: h1 of its own
/// droplets, h2 and h3 of its neighbours' (g1, g2, g3 of ink B), of droplets beside the centres that of their
/// kernels.
///
/// v = sigma_1^2 + sigma_2^2 + (kScatter e)^2: noise of the two maps, and droplets that add more or less
/// than the mean. Beside a wall two scans differ by more than their noise, as they meet it at slightly
/// different places of a cell: by up to 20 um of 400. So v is multiplied by the variance of (x - e) / sqrt(v)
/// over the layer's cells where that is above 1 [Birge, Phys. Rev. 40, 1932]: apart for level ground, tops
/// and feet of walls, and about the mean of cells with droplets, near them and far from them.
///
/// A profile has errors that its cells share, along all of a row or a stretch of it. Sums over cells show
/// them, where the noise of single cells does not. Their variance is that of the rows' and stretches' means
/// over the whole map beyond that of the cells [DerSimonian and Laird, Controlled Clinical Trials 7 (1986)
/// 177], and counts in each sum with the square of its share of a row.
struct RiseEvidence {
  static constexpr double kScatter = 0.3;    ///< standard deviation of a cell's rise, of the expected one
  static constexpr double kEdgeShare = 0.3;  ///< of the expected rise that counts beside an edge
  static constexpr int kNear_cells = 2;      ///< ink of the model lies so far from its droplet at most
  static constexpr int kWide_cells = 5;      ///< flow that carries it farther is not ruled out
  static constexpr int kFar_cells = 6;       ///< flow carries none so far within a layer

  struct Layer {
    const HeightMap &before, &after;           ///< [mm] below and above the layer; NaN: not measured
    double before_std_mm = 0.0, std_mm = 0.0;  ///< noise of one cell; 0: not known
    const DropletPattern& drops;               ///< all of them fired
    const MaterialMap& materials;              ///< without cells: one ink
    const OffsetMap& offsets;                  ///< without cells: all in the centres
  };
  struct Ink {
    RiseSum own;     ///< cells with its droplets
    RiseSum spread;  ///< the same volume spread evenly over kNear_cells around each droplet
    RiseSum wide;    ///< and over kWide_cells
    RiseSum much;    ///< cells with its droplets, all inks expected, for too much
    RiseSum reach;   ///< cells within kNear_cells that it raises more than the other ink does
  };
  std::array<Ink, 2> inks;
  RiseSum bare;   ///< cells without a droplet within kNear_cells; expected: a layer
  RiseSum far;    ///< within kFar_cells
  RiseSum whole;  ///< all measured cells and all ink

  RiseEvidence() = default;
  RiseEvidence(const Experiment& experiment, const Layer& layer);
  void add(const RiseEvidence& e);
};

}  // namespace firn
