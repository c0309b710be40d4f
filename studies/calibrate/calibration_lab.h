// CalibrationLab runs the ice lab under one operator's commands: the nodes of its instruments and of safety
// and their drivers, one act after the other, on real ports or on the byte-level twins. Its results are the
// instruments' answers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "config/machine.h"
#include "core/motion/kinematics/tool.h"
#include "core/path/path.h"

namespace firn {

/// Holds a straight pass of one tool, from rest to rest.
struct LabPass {
  std::vector<Point2> points;  ///< of the tool, part frame
  motion::Tool tool;           ///< as the lab believes it to be
  double z_mm = 0.0;           ///< of the tool, above the part's origin
  double speed_mm_s = 50.0;
  double yaw_rad = 0.0;  ///< of the flange
};

/// Reports whether the experiment's lab has the instruments that the calibrations command.
bool has_calibrations(const Experiment& experiment);

class CalibrationLab {
 public:
  /// Reads the balance: material, number of the weighing. @returns mg
  using Weigh = std::function<double(int, int)>;
  /// Without a port outside the simulation the lab runs in simulated time, else by the clock.
  /// @param machine_toml as [ice] machine names it
  /// @param weigh the balance of a lab with real ports; null: it has none
  /// @throws ConfigError, std::invalid_argument: a configuration that is no ice lab's
  CalibrationLab(const Experiment& experiment, const std::string& machine_toml, Weigh weigh = {});
  ~CalibrationLab();

  const Experiment& experiment() const;
  const Machine& machine() const;
  /// Returns the machine's tool, the laser with the offset of laser_point.*.
  /// @throws std::invalid_argument: no tool has this name
  motion::Tool tool(const std::string& name) const;

  // All acts throw std::runtime_error with the message of the instrument or of safety when one fails.
  void get_ready();  ///< heaters on, tip warm, arm at home: before any other act
  /// @throws std::runtime_error: out of reach, a limit
  Trajectory plan(const LabPass& pass) const;
  /// Returns a trajectory at rest for `seconds`, the tool at the pass's first point.
  Trajectory stand(const LabPass& pass, double seconds) const;
  /// Runs it with the laser's signal and storage. @returns readings at laser_point.rate_hz, NaN = no value
  std::vector<float> scan(const Trajectory& motion, int material);
  /// Moves the laser over (x, y), its reference distance at z, and returns one reading; NaN: no surface in
  /// range.
  double reading(double x_mm, double y_mm, double z_mm);
  bool reaches(double x_mm, double y_mm) const;  ///< the laser can be moved over it
  /// Returns the height of the surface, coming down from 16 mm above the part's origin until the laser sees
  /// it.
  /// @throws std::runtime_error: no surface down to 11 mm below it
  double surface_mm(double x_mm, double y_mm);
  /// Runs it with the valve's signal. @param ticks of the valve's clock (deposition::ValveLimits::tick_s)
  /// @returns pulses that the valve counted
  std::int64_t fire(const Trajectory& motion, int material, const std::vector<std::int32_t>& ticks);
  double tip_degC() const;  ///< the last reading of its thermocouple
  /// The balance's reading for the cup beside the surface. @throws std::runtime_error: there is no balance
  double weigh_mg(int material);
  void wait(double seconds);
  double now_s() const;  ///< since the lab was started

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace firn
