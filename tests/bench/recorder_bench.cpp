// recorder_bench [seconds]: a sender process and the recorder over loopback UDP. Prints messages/s, MB/s, the
// losses before and after repair, and the receive buffer that the kernel granted.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "files/record/event_log.h"
#include "firn/height_profile_t.hpp"
#include "print/process/bus_port.h"
#include "print/process/child_process.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/process_args.h"
#include "runtime/station.h"
#include "runtime/transport_wire.h"
#include "tests/bench/bench.h"

namespace firn::bench::recorder_bench {

namespace fs = std::filesystem;
using namespace firn;

namespace {

struct Load {
  const char* name;
  int points;             ///< of each HEIGHT_PROFILE
  double messages_per_s;  ///< asked
};

/// Sends for `seconds`, then stays until all losses have been asked for. @returns messages sent
std::int64_t send(const ProcessOptions& options, const std::string& url, const Load& load, double seconds) {
  LcmBus bus(url);
  Station station(options, bus, [](const ChannelInfo&, std::span<const std::byte>) {});
  station.join();
  height_profile_t m{};
  m.n = load.points;
  m.z_mm.assign(std::size_t(load.points), 0.5f);
  const std::int64_t began = monotonic_us();
  std::int64_t sent = 0;
  for (;;) {
    const double t = double(monotonic_us() - began) * 1e-6;
    if (t >= seconds) break;
    while (double(sent) < t * load.messages_per_s &&
           station.transport().backlog_bytes() < (std::size_t(8) << 20)) {
      station.send(channels::kHeightProfile, m);
      ++sent;
      if (sent % 16 == 0) break;
    }
    station.service();
  }
  const double took = double(monotonic_us() - began) * 1e-6;
  for (std::int64_t quiet = monotonic_us(), resent = -1; monotonic_us() - quiet < 1'000'000;) {
    station.service();
    if (const auto n = std::int64_t(station.transport().stats().resent);
        n != resent || station.transport().backlog_bytes() > 0) {
      resent = n;
      quiet = monotonic_us();
    }
    ::usleep(100);
  }
  const double bytes = double(m.getEncodedSize());
  std::printf("%-6s %9.0f messages/s %8.1f MB/s of %6.0f bytes; lost before repair (sent again): %llu; ",
              load.name, double(sent) / took, double(sent) * bytes / took * 1e-6, bytes,
              static_cast<unsigned long long>(station.transport().stats().resent));
  return sent;
}

}  // namespace

FIRN_BENCH(recorder_bench) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 3.0;
  std::printf("receive buffer granted: %d bytes, wanted %d\n", granted_receive_buffer(),
              kWantedReceiveBuffer);
  for (const Load& load : {Load{"small", 8, 45'000}, Load{"large", 14'000, 2'900}}) {
    std::string folder = (fs::temp_directory_path() / "firn-bench-XXXXXX").string();
    if (!::mkdtemp(folder.data())) return 1;
    fs::create_directories(fs::path(folder) / "nodes");
    ProcessArgs args;
    args.options.run_dir = folder;
    args.options.run_id = 9;
    args.options.epoch_ns = monotonic_ns();
    args.options.control_fd = ChildProcess::kControlFd;
    args.bus_url = default_bus_url(free_bus_port(monotonic_ns())) + "&key=none";
    args.options.node = NodeId::kRecorder;
    std::int64_t sent = 0, recorded = 0;
    {
      ChildProcess recorder("recorder", FIRN_BINARY_DIR "/bin/recorder", to_arguments(args),
                            fs::path(folder) / "err");
      while (!recorder.control().next()) ::usleep(1000);
      args.options.node = NodeId::kLaserProfiler;
      sent = send(args.options, args.bus_url, load, seconds);
      recorder.control().say("STOP");
      while (recorder.running()) ::usleep(1000);
    }
    const record::EventLogFile log(fs::path(folder) / "log.lcm");
    auto reader = log.reader();
    while (const auto event = reader.next()) recorded += event->channel == "HEIGHT_PROFILE";
    std::printf("lost after repair: %lld of %lld\n", static_cast<long long>(sent - recorded),
                static_cast<long long>(sent));
    fs::remove_all(folder);
  }
  return 0;
}

}  // namespace firn::bench::recorder_bench
