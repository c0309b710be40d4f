// Runs the process `recorder`: see procs/recorder/recorder.h.
#include <csignal>
#include <cstdio>

#include "procs/bus/lcm_bus.h"
#include "procs/recorder/recorder.h"
#include "runtime/process_args.h"

int main(int argc, char** argv) try {
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is reported like a full disk
  const firn::ProcessArgs args = firn::parse_process_args({argv + 1, argv + argc});
  if (const std::string warning = firn::receive_buffer_warning(); !warning.empty())
    std::fprintf(stderr, "recorder: %s\n", warning.c_str());
  firn::LcmBus bus(args.bus_url, firn::take_bus_key(args));
  return firn::Recorder(args.options, bus).run();
} catch (const std::exception& e) {
  std::fprintf(stderr, "recorder: %s\n", e.what());
  return 1;
}
