// Recorder writes every logged channel into log.lcm: whole messages, each once, in the order of each channel.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "files/record/event_log.h"
#include "runtime/process.h"
#include "runtime/station.h"

namespace firn {

/// Outside replay: it may lose messages that the write-ahead files still have (the log is then filled from
/// them), but it loses nothing that it can ask for again, and it says when the disk is full.
class Recorder {
 public:
  Recorder(const ProcessOptions& options, Bus& bus);

  /// READY, then records until STOP or the end of the control line. @returns exit code
  int run();

 private:
  void record(const ChannelInfo& row, std::span<const std::byte> message);
  void write_out(std::int64_t wall_us);
  void trouble(const std::string& what);

  ProcessOptions options_;
  logfile::EventLogWriter log_;
  Station station_;
  std::int64_t next_flush_us_ = 0;
  bool told_ = false;  ///< the fault that stops the print
};

}  // namespace firn
