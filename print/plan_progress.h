// Progress of a long job with the time that is left: a line that is rewritten on a terminal, a plain line
// every two seconds elsewhere, nothing within the first two seconds. On stderr.
#pragma once

#include <chrono>
#include <string>

namespace firn {

class JobProgress {
 public:
  explicit JobProgress(std::string title);
  ~JobProgress();
  /// @param fraction 0 to 1 @param done what stands behind it: "1234 paths"
  void show(double fraction, const std::string& done);

 private:
  std::string title_;
  bool terminal_, line_open_ = false;
  std::chrono::steady_clock::time_point began_, shown_;
};

}  // namespace firn
