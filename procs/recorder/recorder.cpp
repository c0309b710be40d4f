#include "procs/recorder/recorder.h"

#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "files/run_paths.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "runtime/control_line.h"
#include "runtime/transport_wire.h"

namespace firn {
namespace {

constexpr std::int64_t kFlushUs = 100'000;    // so much of the log may be lost by a kill (and filled again)
constexpr std::int64_t kRetryUs = 1'000'000;  // when the disk refuses
constexpr std::int64_t kLingerUs = 500'000;   // after STOP, for messages on their way
constexpr std::int64_t kQuietUs = 60'000;     // nothing has come for so long: done
constexpr std::int64_t kLookUs = 20'000;      // while something is still missing

record::EventLogWriter::Options log_options(const ProcessOptions& o) {
  record::EventLogWriter::Options w;
  w.mode = o.incarnation > 0 ? record::File::Mode::kAppend : record::File::Mode::kCreate;
  return w;
}

}  // namespace

Recorder::Recorder(const ProcessOptions& options, Bus& bus)
    : options_(options),
      log_(RunPaths(options.run_dir).log_path(), log_options(options)),
      station_(options, bus,
               [this](const ChannelInfo& row, std::span<const std::byte> m) { record(row, m); }) {
  for (const ChannelInfo& row : channel_table())
    if (row.logged) station_.subscribe(row.name);
  if (options.incarnation > 0) {
    const record::EventLogFile file(RunPaths(options.run_dir).log_path());
    auto reader = file.reader();
    while (const auto event = reader.next())
      if (!event->damaged) station_.restore_received(event->channel, event->data);
  }
}

int Recorder::run() {
  ControlLine control(options_.control_fd);
  station_.join();
  station_.set_state(Heartbeat::kRunning);
  control.say("READY");
  std::int64_t stop_at_us = INT64_MAX, last_us = monotonic_us();
  std::uint64_t delivered = 0;
  for (;;) {
    const std::int64_t wall = monotonic_us();
    std::int64_t until = std::min({station_.due_us(), next_flush_us_, stop_at_us});
    if (stop_at_us != INT64_MAX) until = std::min(until, std::max(last_us + kQuietUs, wall + kLookUs));
    pollfd fds[] = {{station_.fd(), POLLIN, 0}, {control.closed() ? -1 : control.fd(), POLLIN, 0}};
    const timespec timeout = poll_timeout(until - wall);
    ::ppoll(fds, 2, &timeout, nullptr);
    station_.service();
    const std::int64_t now = monotonic_us();
    write_out(now);
    for (const std::string& n : station_.take_notices()) std::fprintf(stderr, "recorder: %s\n", n.c_str());
    while (const auto line = control.next())
      if (line->starts_with("STOP")) stop_at_us = std::min(stop_at_us, now + kLingerUs);
    if (control.closed()) stop_at_us = std::min(stop_at_us, now + kLingerUs);
    if (const auto n = station_.transport().stats().delivered; n != delivered) {
      delivered = n;
      last_us = now;
    }
    if (now >= stop_at_us ||
        (stop_at_us != INT64_MAX && now - last_us > kQuietUs && !station_.transport().waiting()))
      break;
  }
  try {
    log_.sync();
    log_.close();
  } catch (const std::exception& e) {
    trouble(e.what());
    control.say(std::string("ERROR ") + e.what());
    return 1;
  }
  return 0;
}

void Recorder::record(const ChannelInfo& row, std::span<const std::byte> message) {
  if (next_flush_us_ == INT64_MAX) next_flush_us_ = monotonic_us() + kFlushUs;
  const auto header = wire::read_header(message);
  try {
    log_.append(header ? header->utime_us : 0, row.name, message);
  } catch (const record::FileError& e) {
    trouble(e.what());
  }
}

void Recorder::write_out(std::int64_t wall_us) {
  if (wall_us < next_flush_us_) return;
  next_flush_us_ = INT64_MAX;
  try {
    log_.flush();
  } catch (const record::FileError& e) {
    next_flush_us_ = wall_us + kRetryUs;
    trouble(e.what());
  }
}

void Recorder::trouble(const std::string& what) {
  if (std::exchange(told_, true)) return;
  std::fprintf(stderr, "recorder: %s\n", what.c_str());
  fault_t fault{};
  fault.severity = std::int8_t(Severity::kStop);
  fault.code = 0;
  fault.node = "recorder";
  fault.text = "cannot record: " + what;
  station_.send(channels::fault(NodeId::kRecorder), fault);
}

}  // namespace firn
