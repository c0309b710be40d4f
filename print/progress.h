// What a person sees while something takes more than two seconds: a line that is rewritten on a terminal,
// plain lines elsewhere. Always on stderr.
#pragma once

#include <chrono>
#include <string>

#include "firn/layer_metrics_t.hpp"

namespace firn {

/// One line that is rewritten on a terminal; elsewhere a line every two seconds, which is enough for a log.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  void show(const std::string& text, bool last);
  void done();  ///< ends the line
  bool terminal() const { return terminal_; }

 private:
  bool terminal_;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point shown_;
};

class PrintProgress {
 public:
  explicit PrintProgress(std::string title);
  /// Layer, height, RMS about the target, and when it will be over.
  void layer(const layer_metrics_t& metrics);
  /// Ends the line.
  void done() { line_.done(); }

 private:
  std::string title_;
  ProgressLine line_;
  std::chrono::steady_clock::time_point began_;
};

/// How far a study of many prints is.
class StudyProgress {
 public:
  explicit StudyProgress(std::size_t all) : all_(all), began_(std::chrono::steady_clock::now()) {}
  void printed(std::size_t done, std::size_t failed);  ///< of those that were to do
  void done() { line_.done(); }
  double elapsed_s() const;

 private:
  std::size_t all_;
  ProgressLine line_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace firn
