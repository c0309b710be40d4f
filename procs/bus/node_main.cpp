#include "procs/bus/node_main.h"

#include <csignal>
#include <cstdio>
#include <exception>

#include "files/run_paths.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/build_info.h"
#include "runtime/control_line.h"
#include "runtime/process_args.h"

namespace firn {

std::string_view lcm_type_texts();

int node_main(int argc, char** argv, NodeId node, MakeNode make) {
  std::signal(SIGINT, SIG_IGN);  // the launcher handles Ctrl-C
  std::signal(SIGHUP, SIG_IGN);  // and the end of the terminal
  std::signal(SIGPIPE, SIG_IGN);
  const char* name = info(node).name.data();
  ProcessArgs args;
  try {
    args = parse_process_args({argv + 1, argv + argc});
    if (args.options.node != node)
      throw std::invalid_argument(std::string("--node: this program is ") + name);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    return 2;
  }
  try {
    ProcessOptions& o = args.options;
    const std::string config = read_text_file(RunPaths(o.run_dir).experiment_path());
    auto made = make(config, read_blobs(args));
    o.head = {name,
              o.run_id,
              o.incarnation,
              build_commit(),
              platform_description(),
              config,
              std::string(lcm_type_texts()),
              args.blobs};
    LcmBus bus(args.bus_url, take_bus_key(args));
    const int status = run_process(o, std::move(made), bus);
    if (const std::string dropped = bus.dropped_text(); !dropped.empty())
      std::fprintf(stderr, "%s: %s\n", name, dropped.c_str());
    return status;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    ControlLine(args.options.control_fd).say(std::string("ERROR ") + e.what());
    return 2;
  }
}

}  // namespace firn
