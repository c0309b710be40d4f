// run_process runs one node as a process: events in, write-ahead file, outputs out. The bus is handed in, so
// that LCM stays outside.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "files/port_address.h"
#include "runtime/bus.h"
#include "runtime/lossy.h"
#include "runtime/node.h"
#include "runtime/run_clock.h"
#include "runtime/write_ahead.h"

namespace firn {

struct ProcessOptions {
  NodeId node = NodeId::kScheduler;
  std::string run_dir;
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  std::int64_t epoch_ns = 0;  ///< CLOCK_BOOTTIME at node time offset_us
  std::int64_t offset_us = 0;
  double time_scale = 1.0;
  int control_fd = -1;
  bool record = false;                            ///< ports onto RUN/cassettes/NODE.cassette
  LossyOptions faults;                            ///< injected into received datagrams
  std::map<std::string, PortAddress> real_ports;  ///< by name; the others are sockets of the simulated world
  WalHead head;                                   ///< of the write-ahead file
};

inline constexpr int kExitResume = 1;   ///< the write-ahead file does not bring the node back
inline constexpr int kExitHandler = 3;  ///< the node's handler threw, or a file could not be written

/// Comes back (incarnation > 0), says READY, waits for START, then works until STOP or end of the control
/// line; a driver then gets up to a second to make its instrument safe.
/// @returns the exit code of the process; trouble is told on stderr and to the launcher
int run_process(const ProcessOptions& options, std::unique_ptr<Node> node, Bus& bus);

}  // namespace firn
