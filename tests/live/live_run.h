// LiveRun runs a live print of a tiny part in a process of its own, so that a test can kill any process of
// the print, also the launcher.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/live/launcher.h"
#include "tests/support/lateness.h"

namespace firn::test {

/// 9 cells wide, a few layers, node time ten times faster than the wall clock.
Experiment tiny_part(std::uint64_t seed);
/// The same size in random layers, whose droplets are at 3 x 3 places inside their cells, in every second
/// print of two sizes.
Experiment tiny_part_beside_centres(std::uint64_t seed);
/// A pipe inside a block of support, in four sub-patterns.
Experiment tiny_part_of_two_inks(std::uint64_t seed);
/// tiny_part() whose jet is seen by a camera before every layer.
Experiment tiny_watched_part(std::uint64_t seed);
/// The aerosol printer's: two short lines in three layers, node time ten times faster than the wall clock.
Experiment tiny_lines(std::uint64_t seed);
/// The same without a profiler.
Experiment tiny_lines_by_camera(std::uint64_t seed);

/// The ice printer's: a block of about 9 x 9 mm in six layers, two intervals, node time ten times faster than
/// the wall clock.
Experiment tiny_ice(std::uint64_t seed);
/// Returns the inputs of RunFolder::create(): mesh, slicing settings and machine come from the source tree
/// and `scratch`.
Blobs tiny_ice_inputs(Experiment& experiment, const std::filesystem::path& scratch);

/// Empty, or why live tests cannot run here.
std::string multicast_refused();

class LiveRun {
 public:
  explicit LiveRun(const Experiment& experiment);
  /// Kills all processes that still run; removes the folder unless `keep`.
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /// Starts the launcher as a process of its own.
  void start(bool resume, const std::filesystem::path& programs = FIRN_BINARY_DIR "/bin");
  /// Waits until all processes have begun; false if the launcher ended before.
  bool wait_started();
  /// SIGKILL of "jet", "launcher", …; the CLOCK_BOOTTIME time just before, in ns.
  std::int64_t kill(const std::string& name);
  void interrupt();
  /// Sends a signal to all processes of the run, as a terminal does.
  void signal_all(int signal);
  int pid_of(const std::string& name) const { return pids_.at(name); }
  std::vector<std::string> processes() const;  ///< names that kill() knows
  /// Waits until the launcher has ended. @returns its exit code, -1 = killed
  int wait();
  /// The same of a print that must finish. Where it was stopped because somebody came too late, while this
  /// computer itself let threads wait, it is resumed, three times at most.
  int wait_finished();
  /// How often wait_finished() has resumed it.
  int late_stops() const { return late_stops_; }
  /// Waits until no process of the run is left.
  void wait_all_gone();
  bool running();

  const bool lines;              ///< a print of lines
  std::vector<LabFault> faults;  ///< of the simulated instruments; set before start()
  std::string bus_url;           ///< of the next start; empty: the launcher's choice
  std::string page_token;        ///< of the next start; empty: no page
  /// Waits for the page. @returns its address; empty: the launcher ended before
  std::string page_address();

  /// State of the disk under the run folder, for all processes but the launcher.
  enum class Disk : char { kSound = '-', kStalled = 's', kFull = 'f' };
  /// Takes effect at once, in prints whose start() came after the first call. A write that meets a stalled
  /// disk waits until it is sound again, 8 s at most.
  void set_disk(Disk state);

  const runs::RunFolder& folder() const { return *folder_; }
  std::filesystem::path path() const { return folder_->path(); }
  /// Returns the launcher's output on stderr.
  std::string said() const;
  /// Node time of a CLOCK_BOOTTIME time in this incarnation.
  std::int64_t node_time_us(std::int64_t mono_ns) const;
  /// Injected faults over all nodes.
  std::uint64_t injected() const;

 private:
  std::filesystem::path disk_file() const { return root_ / "disk"; }
  std::string late_stop() const;

  std::filesystem::path root_;
  std::optional<runs::RunFolder> folder_;
  std::map<std::string, int> pids_;
  int launcher_ = -1;
  int incarnation_ = -1;
  int late_stops_ = 0;
  Lateness lateness_;
};

}  // namespace firn::test
