// PathLoop sequences the commands of a print along paths: PATH_JOB, PULSE_LIST, HEIGHT_MAP, CONTROL_SURFACE,
// TEMPERATURE, ANSWER_*, STATE_*, ENABLE, SAFE_STOP -> ROBOT_COMMAND, VALVE_A_COMMAND, VALVE_B_COMMAND,
// LASER_COMMAND, HEATER_COMMAND, PATH_REPORT, LAYER_METRICS, RUN_END.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/slice/paths/print_paths.h"
#include "firn/control_surface_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/temperature_t.hpp"
#include "procs/scheduler/path_batch.h"
#include "procs/scheduler/scheduler.h"

namespace firn {

/// Coordinates one print along paths [Barnett 2012, ch. 2, 5]: heaters, home, then for each interval its
/// deposition paths (load trajectory and pulses, arm the valve, run the arm, disarm and count, report), its
/// measurement paths (load, arm the laser's storage, run, collect), the height map, the control surface, the
/// next paths.
///
/// A path whose run is in doubt after a crash is never run again: the next map shows the deposit, and the
/// open loop, which does not use maps, asks the operator. Interlocks by their numbers: I6 nozzle would
/// scrape, I7 time slip, I8 path refused, I10 too cold, I13 map rejected.
class PathLoop final : public Scheduler {
 public:
  /// @param tick_s of the trajectories
  PathLoop(const Experiment& experiment, slice::PrintPaths paths, double tick_s);

  using Scheduler::on;
  void on(const path_job_t&, Time now, Outbox&);
  void on(const pulse_list_t&, Time now, Outbox&);
  void on(const height_map_t&, Time now, Outbox&);
  void on(const control_surface_t&, Time now, Outbox&);
  void on(const temperature_t&, Time now, Outbox&);

 private:
  void proceed(Phase next, Time now, Outbox&) override;
  void answered(const answer_t&, Time now, Outbox&) override;
  void answered_late(const answer_t&) override;
  bool only_counts() const override { return phase_ == Phase::kDisarmValve; }
  void after_resume(Time now, Outbox&) override;
  void operator_accepted(Time now, Outbox&) override;
  std::int64_t act_size() const override;
  void scan_again(Time now, Outbox&) override;
  int command_layer() const override;
  std::string awaited() const override;
  std::string doubt() const override;

  std::string place() const;  ///< "before path 12 of layer 7", "before the scan of layer 7"
  bool depositing() const { return at_ < deposition_.size(); }
  const PathTask& task() const { return deposition_[at_]; }
  bool waits_for_operator() const;
  void next_path(Time now, Outbox&);  ///< the next deposition path, or the measurement
  void next_scan_path(Time now, Outbox&);
  void measure_again(Time now, Outbox&);
  void act_on_batch(Time now, Outbox&);
  void act_on_map(Time now, Outbox&);
  void act_on_surface(Time now, Outbox&);
  void act_on_temperature(Time now, Outbox&);
  /// Layers that the deposition of the batch in hand covers, up to `layer`.
  int layers_laid(int layer) const;
  /// Interlock 15: the bare table and the first interval's place, against the calibrated uncertainty: a
  /// warning and another scan, then a stop. Returns false for a map to act on.
  bool doubted(const height_map_t&, Time now, Outbox&);
  /// A resume measures again first.
  void stop_for_operator(const std::string& who, const Violation& reason, Outbox&);
  void settle_list(const answer_t& count, Time now, Outbox&);
  void next_list(Time now, Outbox&);
  void report(Outbox&);
  void publish_metrics(const height_map_t&, Outbox&);

  void send_robot(RobotVerb verb, const PathTask* task, int list, int signals, double allowed_s, Time now,
                  Outbox&);
  void send_valve(ValveVerb verb, Time now, Outbox&);
  void send_laser(LaserVerb verb, Time now, Outbox&);
  void send_heater(Time now, Outbox&);

  bool table_first_;         ///< the bare table is measured before the first layer: ice.map_table
  slice::PrintPaths paths_;  ///< with the table as layer 0 then
  double tick_s_;

  PathBatch batch_;                   ///< as it arrives
  std::int64_t batch_done_ = 0;       ///< number of the batch that was taken last
  std::vector<PathTask> deposition_;  ///< of the batch in hand
  std::vector<PathTask> scan_;        ///< measurement paths of the last layer that was measured or is to be
  std::vector<PathTask> next_scan_;   ///< of the batch in hand, until its deposition is done
  std::size_t at_ = 0;                ///< in deposition_
  int list_ = 0;                      ///< of that path
  std::size_t scan_at_ = 0;

  std::optional<answer_t> late_count_;  ///< the valve's count, reported after a crash
  int attempt_ = 0;                     ///< times that the path has been begun in vain
  bool closed_ = false;                 ///< in doubt: the rest of the path is not run
  bool in_doubt_ = false;               ///< something since the last map
  std::int64_t pulses_counted_ = 0;     ///< of the path
  double measured_s_ = 0.0;
  int outcome_ = 0;  ///< of the path, as answer_t
  Time begun_;

  std::optional<height_map_t> map_;  ///< arrived, not acted on yet
  std::optional<control_surface_t> surface_;
  std::optional<temperature_t> temperature_;
  HeightMap newest_;        ///< the map that was accepted last
  bool untouched_ = false;  ///< since then no path has deposited, and nobody was at the lab
  HeightMap below_;         ///< that of the interval before; empty = the table
  int mapped_layers_ = 0;   ///< deposition layers in newest_
  Violation dry_;           ///< a valve that gives nothing or too much, by newest_
  int much_layer_ = 0;      ///< of the first of maps in a row that rose too much
  int dry_told_ = 0;        ///< deposition layers when that stopped the print last
  int scan_attempt_ = 0;
  std::int64_t scan_id_ = 0;
  std::int64_t map_id_ = 0;
  std::int64_t pulses_interval_ = 0, pulses_total_ = 0;
  int slips_ = 0;            ///< paths in a row that took longer or shorter than planned
  bool raised_ = false;      ///< for a path that would scrape: the map has been measured anew once
  bool one_heater_ = false;  ///< (a) has failed and that was said
  Phase after_homing_ = Phase::kAwaitPaths;
};

}  // namespace firn
