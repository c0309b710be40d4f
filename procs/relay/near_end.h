// NearEnd is the launcher's side of a host: it starts `firn host` there by ssh, gives it all that the
// processes need, relays the bus and their control lines, and keeps a copy of their records.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procs/relay/hello.h"
#include "procs/relay/port_tunnel.h"
#include "procs/relay/ssh.h"
#include "runtime/control_line.h"
#include "runtime/relay/link.h"

namespace firn {
class LcmBus;
}

namespace firn::relay {

/// Lines from the launcher: "TO NODE LINE" for a process there, "STOP CAUSE": the run is over, collect.
/// Lines to it: "READY": all processes there have started; "FROM NODE LINE"; "ENDED NODE CODE SIGNAL";
/// "BUS URL": of the host's own bus; "PIDS NODE=PID …"; "CLOCK AHEAD_NS BOUND_NS ROUND_TRIP_NS"; "COLLECTED";
/// "ERROR TEXT", "FAULT TEXT".
class NearEnd {
 public:
  /// @param bus null: only collects the records there
  NearEnd(HostOrder order, std::string key_line, std::filesystem::path run, LcmBus* bus,
          ControlLine& control);
  /// @returns 0: all records of the host are here, 1: not, which ERROR or FAULT has explained
  int run();

 private:
  void turn();
  void take(const Frame& frame);
  void take_hello(const std::string& text);
  void take_line(std::string_view node, std::string_view line);
  void take_records(const std::string& json);
  void listen_to_launcher();
  void keep_clock(const std::string& numbers);

  HostOrder order_;
  std::string key_line_;
  std::filesystem::path run_;
  LcmBus* bus_;
  ControlLine& control_;
  HostFacts facts_;
  Ssh ssh_;
  Link link_;
  std::vector<std::unique_ptr<Ssh>> lanes_;
  PortTunnel tunnel_;
  FileSource source_;
  FileSink sink_;
  std::ofstream facts_file_, clock_file_;
  std::int64_t began_ns_;
  bool greeted_ = false, started_ = false, files_told_ = true, collected_ = false;
  bool begun_ = false;  // the launcher has said START: instruments may act
  bool collecting_;     // the processes there have ended, or never began
};

}  // namespace firn::relay
