// Recorder writes every logged channel into log.lcm: whole messages, each once, in the order of each channel.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "files/record/event_log.h"
#include "runtime/process.h"
#include "runtime/station.h"

namespace firn {

/// Not part of replay. The recorder may lose messages that the write-ahead files still hold (the log is then
/// filled from these files), but does not lose messages that can be requested again, and reports a full disk.
class Recorder {
 public:
  Recorder(const ProcessOptions& options, Bus& bus);

  /// Sends READY, then records until STOP or the end of the control line. @returns exit code
  int run();

 private:
  void record(const ChannelInfo& row, std::span<const std::byte> message);
  void write_out(std::int64_t wall_us);
  void trouble(const std::string& what);

  ProcessOptions options_;
  record::EventLogWriter log_;
  Station station_;
  std::int64_t next_flush_us_ = 0;
  bool told_ = false;  ///< the fault that stops the print
};

}  // namespace firn
