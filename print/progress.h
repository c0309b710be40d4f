// ProgressLine shows the state of a long job on stderr: one line that is rewritten on a terminal, plain lines
// elsewhere.
#pragma once

#include <chrono>
#include <map>
#include <string>

#include "config/labs.h"
#include "firn/layer_metrics_t.hpp"

namespace firn {

class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  /// Minimum time before the first line, and between two lines on a terminal and elsewhere.
  struct Pauses {
    std::chrono::milliseconds first{0};
    std::chrono::milliseconds terminal{0};
    std::chrono::milliseconds plain{2000};
  };

  explicit ProgressLine(const Pauses& pauses);
  ~ProgressLine() { done(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Returns true if the pause is over: show() would write.
  bool due() const;
  /// @param last written in any case
  void show(const std::string& text, bool last = false);
  /// Writes a message as a line of its own; the state of the job follows on the next line.
  void note(const std::string& text);
  void done();   ///< ends the line
  void erase();  ///< removes the line from a terminal

  bool terminal() const { return terminal_; }
  /// Returns the width of the terminal; a wide line elsewhere.
  int columns() const;
  double elapsed_s() const;
  /// Returns "[####......] " on a terminal, nothing elsewhere.
  std::string bar(double fraction) const;
  /// Returns "  ETA 12 s", computed from the mean rate until now; nothing at fraction 0.
  std::string eta(double fraction) const;

 private:
  Pauses pauses_;
  bool terminal_;
  bool line_open_ = false;
  bool shown_once_ = false;
  std::string text_;  ///< shown last on a terminal
  Clock::time_point began_ = Clock::now();
  Clock::time_point shown_ = began_;
};

/// Returns the line about a layer with as much as fits into `columns`: layer, RMS, time left, height, title,
/// bar, in this order of importance.
/// @param left_s time to the end; negative: unknown, as for layers beyond the expected number
std::string layer_text(const std::string& title, const LabWords& words, const layer_metrics_t& metrics,
                       double left_s, int columns);

/// Shows the progress of one print.
class PrintProgress {
 public:
  PrintProgress(std::string title, const LabWords& words);
  /// Takes when a simulation of the scheme was done with each layer [s of node time]; empty: nothing is
  /// foretold. @param time_scale node time over wall time
  void foretell(std::map<int, double> layer_s, double time_scale);
  /// Shows layer, height, RMS about the target, lost rows of the scan and the time that is left.
  void layer(const layer_metrics_t& metrics);
  /// Shows a message; the scheduler's of a pause stop the clock of the time that is left.
  void note(const std::string& text);
  void done() { line_.done(); }

 private:
  double printing_s() const { return (held_since_s_ < 0.0 ? line_.elapsed_s() : held_since_s_) - held_s_; }

  std::string title_;
  LabWords words_;
  ProgressLine line_;
  std::map<int, double> foretold_s_;           ///< wall time
  double held_s_ = 0.0, held_since_s_ = -1.0;  ///< of pauses that are over; of this one, negative: none
  int first_layer_ = -1;  ///< that this process has shown; earlier ones are of before a resume
  double first_s_ = 0.0;
};

/// Shows the progress of a study of many results.
class StudyProgress {
 public:
  /// @param noun one of them: "print", "case"
  StudyProgress(std::size_t all, std::string noun);
  /// @param done results of those that were to do, failed ones included
  void made(std::size_t done, std::size_t failed);
  void done() { line_.done(); }
  double elapsed_s() const { return line_.elapsed_s(); }

 private:
  std::size_t all_;
  std::string noun_;
  ProgressLine line_;
};

/// Shows the progress of a job of known length. Nothing is shown within the first two seconds.
class JobProgress {
 public:
  explicit JobProgress(std::string title);
  /// @param fraction 0 to 1
  /// @param done the last words of the line: "1234 paths"
  void show(double fraction, const std::string& done);
  void done() { line_.done(); }

 private:
  std::string title_;
  ProgressLine line_;
};

}  // namespace firn
