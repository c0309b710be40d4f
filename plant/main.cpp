// world serves the nature of one run behind Unix sockets. Configuration: RUN/experiment.toml.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "config/include.h"
#include "files/run_paths.h"
#include "plant/world/serve.h"
#include "plant/world/setup.h"
#include "runtime/process_args.h"

int main(int argc, char** argv) {
  int control_fd = -1;
  try {
    const auto options = firn::plant::parse_serve_options({argv + 1, argv + argc});
    control_fd = options.control_fd;
    const firn::Experiment experiment = firn::load_experiment(firn::RunPaths(options.run).experiment_path());
    firn::ProcessArgs inputs;
    inputs.options.run_dir = options.run.string();
    inputs.blobs = options.blobs;
    firn::plant::WorldConfig config = firn::plant::world_config(experiment, firn::read_blobs(inputs));
    config.line_speed = options.line_speed;
    if (options.quick)
      for (firn::plant::JetParams* jet : {&config.jet, &config.jet_b}) jet->reset_us = jet->pulse_us = 0;
    if (options.steady) firn::plant::make_steady(config.ice);
    firn::plant::serve(options, config);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "world: %s\n", e.what());
    std::string line = std::string("ERROR ") + e.what();
    std::ranges::replace(line, '\n', ' ');  // of a traceback
    line += '\n';
    if (control_fd >= 0 && ::write(control_fd, line.data(), line.size()) < 0) return 1;
    return 1;
  }
}
