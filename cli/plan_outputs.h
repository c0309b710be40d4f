// What firn plan writes besides the trajectory file.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/plan_job.h"
#include "core/deposition/pulses.h"

namespace firn {

/// A text file that grows under a temporary name beside its own; removed unless finished.
class TextOutput {
 public:
  explicit TextOutput(const std::filesystem::path& file);  ///< @throws UsageError naming the file
  ~TextOutput();
  void write(const std::string& text);  ///< @throws std::runtime_error naming the file
  void finish();                        ///< @throws std::runtime_error naming the file

 private:
  std::filesystem::path file_, part_;
  std::FILE* out_ = nullptr;
};

/// Header of the trajectory CSV: "t_s,x_mm,y_mm,joint_1_rad,joint_2_rad"; a stage's columns end in _mm.
std::string csv_header(const std::vector<std::string>& axis_units);
/// One line per tick; x, y in the frame of the paths, the first two axes. Shortest digits that read back the same.
std::string csv_lines(const PlannedItem& item);

/// Largest ratio of each limit over all paths.
struct WorstRatio {
  LimitRatio ratio;
  std::int64_t path = 0;
};
void take_worst(std::vector<WorstRatio>& worst, const Certificate& certificate, std::int64_t path);

/// One JSON object: the certificate and what the planner says of a path.
std::string item_json(const PlannedItem& item);

/// The path's speed at each tick, from the emitted tool positions: what flow must match.
std::vector<double> speeds_at_ticks(const std::vector<Point2>& tool, double tick_s);
/// Instants inside a path at which it rests. The instant of rest lies between two ticks, so it shows as a dip of the
/// sampled speed: below 1 mm/s, and at most half of what the four ticks around it reach.
std::vector<std::size_t> stops_of(const std::vector<double>& speed_mm_s);
/// Nominal pulses of a planned path (6.2), (6.4)-(6.6), cut at its stops where the controller's limits need it.
/// @throws std::runtime_error: more flow than the valve gives, or no stop where one is needed
deposition::PulsePlan nominal_pulses(const PlannedItem& item, const ValveConfig& valve);

}  // namespace firn
