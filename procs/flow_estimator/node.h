// FlowEstimatorNode estimates the flow of the valves: TRAJECTORY, PULSE_LIST, PATH_REPORT, HEIGHT_MAP ->
// FLOW_MODEL.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "config/experiment.h"
#include "config/machine.h"
#include "core/slice/paths/print_paths.h"
#include "estimators/flow/flow_estimator.h"
#include "estimators/flow/laid_volume.h"
#include "firn/height_map_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/pulse_list_t.hpp"
#include "firn/trajectory_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Keeps the planned deposit of each path and the fired pulses of each report. After each height map (of at
/// least process.min_measured_fraction) the node publishes the flow of the valves relative to their
/// calibrated curves. The table counts as flat before the first map. A path whose outcome is in doubt makes
/// the places it passes unknown for its interval. A second map of the same layer replaces the first.
class FlowEstimatorNode final : public Node {
 public:
  /// @throws std::invalid_argument: paths without a layer, materials whose tools the machine lacks
  FlowEstimatorNode(const Experiment& experiment, const Machine& machine, const slice::PrintPaths& paths);
  void on(const trajectory_t&, Time now, Outbox&);
  void on(const pulse_list_t&, Time now, Outbox&);
  void on(const path_report_t&, Time now, Outbox&);
  void on(const height_map_t&, Time now, Outbox&);

 private:
  using Laid = std::array<HeightMap, 2>;
  Laid nothing() const { return {HeightMap(grid_, 0.0), HeightMap(grid_, 0.0)}; }
  void add(const path_report_t& report);

  GridSpec grid_;  ///< holds every layer's footprint
  std::unique_ptr<motion::Arm> arm_;
  std::array<motion::Tool, 2> tools_;
  std::array<double, 2> latency_s_;
  Point2 origin_;
  double min_measured_fraction_;
  flow::FlowEstimator estimator_;
  std::map<std::int64_t, Trajectory> motions_;  ///< of paths not yet reported
  std::map<std::int64_t, std::vector<pulse_list_t>> lists_;
  std::map<std::int64_t, path_report_t> early_;  ///< reports that overtook their path
  Laid laid_, laid_before_;                      ///< since the newest map, and in the interval that it ended
  HeightMap newest_, before_;                    ///< maps; NaN = not measured
  int layer_ = 0;                                ///< of the newest map
};

std::unique_ptr<Node> make_flow_estimator(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
