// FarEnd is a host's side of a run: the process `firn host`, which the launcher's relay starts here by ssh.
// It runs the host's processes on a bus of this computer's loopback, and relays that bus and their control
// lines.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "print/hosts/lane.h"
#include "print/process/child_process.h"
#include "procs/bus/lcm_bus.h"
#include "procs/relay/hello.h"
#include "procs/relay/port_tunnel.h"
#include "runs/folder/run_lock.h"
#include "runtime/process_args.h"
#include "runtime/relay/link.h"

namespace firn {

class FarEnd {
 public:
  /// @param runs the folders of runs here are HOST/RUN in it
  /// @param programs the folder of the processes' programs
  FarEnd(std::filesystem::path runs, std::filesystem::path programs);
  /// Serves the relay at standard input and output until it is gone and every process here has ended.
  /// @returns 0: the relay has all records; 1: not, which stderr and the relay were told
  int run(int in_fd, int out_fd);

  /// "$XDG_STATE_HOME/firn/hosts", or "~/.local/state/firn/hosts". @throws UsageError: there is no home
  static std::filesystem::path default_runs();

 private:
  void turn();
  void take(const relay::Frame& frame);
  void take_hello(const std::string& text);
  void take_line(const std::string& process, const std::string& line);
  void hold_folder();
  void enter_folder(const std::string& launcher_boot_id);
  void reach_simulated(const std::string& launcher_boot_id);
  bool has(const std::string& name, const relay::FileState& state) const;
  bool clock_is_known();
  double longest_silence_s() const;
  void start();
  void service_children();
  void steer_clocks();
  void stop_all(const std::string& cause);
  void hand_over();
  bool all_ended();

  std::filesystem::path runs_, programs_, folder_;
  relay::HostFacts facts_;
  relay::HostOrder order_;
  std::string key_line_;
  ProcessArgs args_;
  std::int64_t launcher_epoch_ns_ = 0;
  std::optional<runs::RunLock> lock_;
  std::optional<relay::Link> link_;
  LaneDoor door_;
  std::optional<relay::FileSource> source_;
  std::optional<relay::FileSink> sink_;
  std::optional<LcmBus> bus_;
  std::optional<relay::PortTunnel> tunnel_;  // of simulated instruments at another computer's world
  std::vector<std::unique_ptr<ChildProcess>> children_;
  std::vector<std::string> told_ended_;
  bool greeted_ = false, have_files_ = false, started_ = false, begun_ = false, stopping_ = false,
       collecting_ = false, sending_last_ = false, handed_over_ = false;
  std::int64_t greeted_ns_ = 0, looked_ns_ = 0, steered_ns_ = 0, told_clock_ns_ = 0, stopped_ns_ = 0,
               turned_ns_ = 0;
};

}  // namespace firn
