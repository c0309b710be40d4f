// What a person sees while something takes more than two seconds: a line that is rewritten on a terminal, plain lines
// elsewhere. Always on stderr.
#pragma once

#include <chrono>
#include <string>

#include "firn/layer_metrics_t.hpp"

namespace firn {

class PrintProgress {
 public:
  explicit PrintProgress(std::string title);
  ~PrintProgress();
  /// Layer, height, RMS about the target, and when it will be over.
  void layer(const layer_metrics_t& metrics);
  /// Ends the line.
  void done();

 private:
  void show(const std::string& text, bool last);

  std::string title_;
  bool terminal_;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point began_, shown_;
};

}  // namespace firn
