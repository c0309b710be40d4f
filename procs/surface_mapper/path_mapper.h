// PathMapper computes the height map of a scan of a path printer: TRAJECTORY, LASER_SAMPLES -> HEIGHT_MAP,
// HEIGHT_PREVIEW.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "config/experiment.h"
#include "config/machine.h"
#include "core/slice/paths/print_paths.h"
#include "estimators/surface/path_readings.h"
#include "firn/laser_samples_t.hpp"
#include "firn/trajectory_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Gathers the readings of one scan, path by path in any order, and answers the last with the map of the
/// layer's own grid (core/slice/coverage/footprint.h): each reading is placed at the laser's position on the
/// path's trajectory, laser_point.latency_s after the storage began; the surface is linear between them and,
/// with control.smoothing, smoothed. quality: measured = on the footprint and near a reading, else filled
/// from the nearest. measured_fraction = valid readings over those that the paths' durations should have
/// given. A repeated path, or one of an older scan, changes nothing; a newer scan_id drops the unfinished
/// scan.
class PathMapper final : public Node {
 public:
  PathMapper(const Experiment& experiment, const Machine& machine, slice::PrintPaths paths);
  void on(const trajectory_t&, Time now, Outbox&);
  void on(const laser_samples_t&, Time now, Outbox&);

 private:
  bool complete() const;
  void publish(Outbox&);

  slice::PrintPaths paths_;
  std::unique_ptr<motion::Arm> arm_;
  surface::LaserFrame frame_;
  double pitch_mm_;
  surface::ScatterOptions options_;
  std::map<std::int64_t, Trajectory> motions_;    ///< of measurement paths, by path
  std::map<std::int32_t, laser_samples_t> scan_;  ///< by index
  std::int64_t scan_id_ = -1;
  bool mapped_ = true;
  std::int64_t maps_ = 0;
};

}  // namespace firn
