// Plans every path of a stream, some threads at a time, and passes the results on in the paths' order.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/machine.h"
#include "core/motion/planner.h"
#include "files/path/path_file.h"
#include "print/prepare/plan_pulses.h"

namespace firn {

struct PlanJobOptions {
  motion::PlanOptions plan;  ///< without point_noise_mm
  Point2 origin;             ///< of the part's frame in the machine's
  int threads = 1;
  std::int64_t traced = 0;  ///< the number of the path whose trace is kept (for a plot); 0: no path
  bool keep_tool = false;   ///< keep PlanResult::tool
  bool pulses = false;      ///< plan the valve's pulses too; paths get rests where its lists need them
  std::function<void(struct PlannedItem&)>
      describe;                            ///< run for each planned path by the thread that planned it
  std::optional<double> point_noise_mm{};  ///< of every path; none: from the decimals of its points
};

struct PlannedItem {
  InputPath input;
  double length_mm = 0.0;
  motion::PlanResult result;
  std::vector<std::byte> encoded;  ///< of the trajectory file; empty with a fault
  deposition::PulsePlan pulse_plan;
  std::vector<AddedStop> added_stops;
  std::string csv, json, pulses, gcode, pvt;  ///< written by PlanJobOptions::describe
  std::string problem;                        ///< reason for which the path is refused after all
};
using PlannedSink = std::function<void(PlannedItem&&)>;

/// A path is planned from itself alone (every one prefers the machine's arm configuration), so the results do
/// not depend on the number of threads. Memory: two batches of some 100,000 points, or two paths if these are
/// longer.
class PlanJob {
 public:
  PlanJob(const Machine& machine, const PlanJobOptions& options, PlannedSink sink);
  ~PlanJob();
  void add(InputPath&& path);  ///< @throws the sink's exceptions; UsageError naming an unknown tool and the
                               ///< nearest known
  void finish();               ///< passes on the remaining results

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace firn
