// Writes the outputs of firn plan besides the trajectory file.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "files/record/part_file.h"
#include "print/prepare/plan_job.h"

namespace firn {

/// Writes a text file under a temporary name beside its own; the file is removed unless finished.
class TextOutput {
 public:
  explicit TextOutput(const std::filesystem::path& file);  ///< @throws UsageError naming the file
  ~TextOutput();
  void write(const std::string& text);  ///< @throws std::runtime_error naming the file
  void finish();                        ///< @throws std::runtime_error naming the file

 private:
  std::filesystem::path file_;
  record::PartFile part_;
  std::FILE* out_ = nullptr;
};

/// Returns the header of the trajectory CSV: "t_s,x_mm,y_mm,joint_1_rad,joint_2_rad"; a stage's columns end
/// in _mm.
std::string csv_header(const std::vector<std::string>& axis_units);
/// Returns one line per tick; x, y in the frame of the paths, the first two axes. Shortest digits that read
/// back the same.
std::string csv_lines(const PlannedItem& item);

/// Holds the maximum ratio of each limit over all paths.
struct WorstRatio {
  LimitRatio ratio;
  std::int64_t path = 0;
};
void take_worst(std::vector<WorstRatio>& worst, const Certificate& certificate, std::int64_t path);

/// Returns one JSON object: the certificate and the planner's results for a path.
std::string item_json(const PlannedItem& item);

}  // namespace firn
