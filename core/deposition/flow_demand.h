// FlowDemand holds the flow that a path needs [Barnett 2012, 6.2]. Everything is sampled at the planner's
// tick: instant i is at i * step_s. Between instants speed and flow are linear, so length and volume are
// exact integrals of the same samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/grid/grid.h"
#include "core/path/path.h"

namespace firn::deposition {

/// The path's speed at each tick, from the emitted tool positions; the flow must match it. At rest at both
/// ends.
std::vector<double> speeds_at_ticks(std::span<const Point2> tool, double tick_s);

/// Eq. (6.2): q_nom = w dh_d c. @pre sizes equal
void nominal_flow(double width_mm, double layer_height_mm, std::span<const double> speed_mm_s,
                  std::span<double> flow_mm3_s);

/// Eq. (6.3): q_cor,i = (u_i + 1) q_nom,i; u below -1 gives zero flow. @pre sizes equal
void corrected_flow(std::span<const double> nominal_mm3_s, std::span<const double> action,
                    std::span<double> flow_mm3_s);

/// A(x, y): the control action surface between its cells, bilinear; 0 (no correction) beyond the outermost
/// cells or where one of the four is NaN.
double action_at(const HeightMap& surface, const Point2& at);

/// Flow and speed along one path.
struct FlowDemand {
  double step_s = 0.016;           ///< delta of Eq. (6.5)
  std::vector<double> flow_mm3_s;  ///< corrected flow at the instants
  std::vector<double> speed_mm_s;  ///< c there
  std::vector<std::size_t> stops;  ///< instants inside the path at which the tool is at rest, ascending
  double duration_s() const { return flow_mm3_s.size() < 2 ? 0.0 : step_s * double(flow_mm3_s.size() - 1); }
};
/// @throws std::invalid_argument naming the instant: sizes equal, at least two, all finite and not negative,
/// step above 0, stops ascending and inside.
void check(const FlowDemand& demand);

/// Volume removed by clip_flow().
struct Shortfall {
  double volume_mm3 = 0.0;
  std::size_t instants = 0;  ///< how many asked for more than there is
  std::size_t first = 0;     ///< the first of them
};
/// Flow above `capacity` becomes `capacity`: the valve cannot do more.
Shortfall clip_flow(FlowDemand& demand, double capacity_mm3_s);

/// Running integral of a demand: volume wanted and length covered since the start of the path.
class DemandIntegral {
 public:
  explicit DemandIntegral(const FlowDemand& demand);
  double volume_mm3(double time_s) const { return value(demand_.flow_mm3_s, volume_, time_s); }
  double length_mm(double time_s) const { return value(demand_.speed_mm_s, length_, time_s); }
  double flow_mm3_s(double time_s) const;
  /// The first instant at which the path is `length` mm long; clamped to the path.
  double time_at_length_s(double length_mm) const;
  double total_volume_mm3() const { return volume_.back(); }
  double total_length_mm() const { return length_.back(); }

 private:
  struct Place {
    std::size_t interval;
    double into_s;
  };
  Place place(double time_s) const;
  double value(const std::vector<double>& rate, const std::vector<double>& sum, double time_s) const;

  const FlowDemand& demand_;
  std::vector<double> volume_, length_;  // at the instants
};

/// tau >= 0 with rate0 tau + (rate1 - rate0) tau^2 / (2 step) = amount: when a linearly changing rate has
/// delivered it.
/// @pre 0 <= amount <= step (rate0 + rate1) / 2
double time_to_deliver(double rate0, double rate1, double step_s, double amount);

}  // namespace firn::deposition
