// RiseCheck compares the rise of the surface with the droplets of the last layers: a nozzle that is dead,
// blocked or leaking shows in the maps, whatever the pulse counters say.
#pragma once

#include <array>
#include <deque>
#include <span>
#include <vector>

#include "config/experiment.h"
#include "core/grid/figure.h"
#include "core/grid/grid.h"
#include "core/grid/material.h"
#include "core/grid/offsets.h"

namespace firn {

/// Tests three hypotheses after each layer. The expected rise e of a cell is that of the model: h1 of its own
/// droplets, h2 and h3 of its neighbours' (g1, g2, g3 of ink B), of droplets beside the centres that of their
/// kernels.
///   drops without rise: the cells with droplets of one ink rose by less than process.least_rise_share of e;
///   rise without drops: they rose by more than process.most_rise_share times e, and so did the sum over all
///     cells within two of its droplets (near both inks: those that it raises more). Ink that runs from a
///     high cell to a low one is in the sum wherever it lies, so it needs no model of the flow; the cells
///     with droplets need no model of how far a droplet spreads. Or the cells without a droplet within two
///     cells rose by more than least_rise_share of one droplet's layer height.
///
/// The rise x of a cell has the variance v = sigma_1^2 + sigma_2^2 + (kScatter e)^2: noise of the two maps
/// and what single droplets add more or less. Weighted by 1 / v, the share x / e of n cells has the standard
/// deviation 1 / sqrt(I), I = sum of e^2 / v; sums have the variance sum of v, with most_rise_share e in
/// place of e. Beside a wall two scans differ by more than their noise, as they meet it at slightly
/// different places of a cell: by up to 20 um of 400. So v is multiplied by the variance of (x - e) / sqrt(v)
/// over the layer's cells where that is above 1 [Birge, Phys. Rev. 40, 1932]: apart for level
/// ground, tops and feet of walls, and about the mean of cells with droplets, near them and far from them. A
/// dead nozzle shifts all cells alike, which does not change it. A hypothesis is accepted when the share is
/// beyond its limit by kSigmas such standard deviations, over the last layer or the last 2, 4 or 8 together:
/// four tests a layer, each wrong once in 40,000 layers, so that a nozzle that is just good enough is stopped
/// at most once in 10,000 layers. A dead nozzle is found as soon as
///   sqrt(I) > kSigmas / least_rise_share,
/// which is 20 to 30 cells away from an edge, in one layer or in two [docs/safety.md].
///
/// Ink runs off the part where the ground beside a cell is two layers lower. There a droplet that is alone
/// may add nothing: it is no evidence. Droplets of a full layer hold each other: the cell counts with
/// kEdgeShare of e.
class RiseCheck {
 public:
  static constexpr double kSigmas = 4.06;    ///< one-sided probability 1 / 40,000
  static constexpr double kScatter = 0.3;    ///< standard deviation of a cell's rise, of the expected one
  static constexpr double kEdgeShare = 0.3;  ///< of the expected rise that counts beside an edge

  struct Layer {
    const HeightMap &before, &after;           ///< [mm] below and above the layer; NaN: not measured
    double before_std_mm = 0.0, std_mm = 0.0;  ///< noise of one cell; 0: not known
    const DropletPattern& drops;               ///< all of them fired
    const MaterialMap& materials;              ///< without cells: one ink
    const OffsetMap& offsets;                  ///< without cells: all in the centres
  };
  /// Returns the disturbance: its figure is the rise as a share of the expected one, of a leak the rise [um].
  Violation check(const Experiment& experiment, const Layer& layer);
  /// Forgets the last layers: somebody was at the nozzle.
  void restart() { layers_.clear(); }

 private:
  /// One cell: its rise (without what the other ink's droplets give, where one ink is judged), the expected
  /// one, the part of that which counts, and v.
  struct Sample {
    double rise_mm, expected_mm, counted_mm, variance_mm2;
  };
  using Samples = std::vector<Sample>;
  /// Sums of (x - e) / sqrt(v) over cells of one kind.
  class Scatter {
   public:
    void add(double z);

   private:
    friend RiseCheck;
    double n_ = 0.0, sum_ = 0.0, squares_ = 0.0;
  };
  /// The variance about the mean of its own kind, over the cells of all kinds; at least 1.
  static double birge_ratio(std::span<const Scatter> kinds);
  struct Rise {
    double cells = 0.0, measured_mm = 0.0, expected_mm = 0.0, variance_mm2 = 0.0;  // sums
    double information = 0.0, share = 0.0;  // sums of e^2 / v and e x / v
    void add(const Rise& r);
    void add(const Samples& samples, double ratio);
  };
  struct Evidence {
    std::array<Rise, 2> of_ink;  // cells with a droplet, for a dead nozzle
    std::array<Rise, 2> much;    // the same for too much
    std::array<Rise, 2> reach;   // all cells that the droplets of one ink can reach
    Rise bare;                   // cells that none can reach; expected: nothing
    void add(const Evidence& e);
  };
  static Evidence evidence_of(const Experiment& experiment, const Layer& layer);
  static Violation judge(const ProcessConfig& process, const Evidence& sum, int layers);

  std::deque<Evidence> layers_;  // newest first
};

}  // namespace firn
