// world serves the nature of one run behind Unix sockets. Configuration: RUN/experiment.toml.
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "config/include.h"
#include "plant/world/serve.h"
#include "plant/world/setup.h"

int main(int argc, char** argv) {
  int control_fd = -1;
  try {
    const auto options = firn::plant::parse_serve_options({argv + 1, argv + argc});
    control_fd = options.control_fd;
    const firn::Experiment experiment = firn::load_experiment(options.run / "experiment.toml");
    firn::plant::serve(options, firn::plant::world_config(experiment));
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "world: %s\n", e.what());
    const std::string line = std::string("ERROR ") + e.what() + "\n";
    if (control_fd >= 0 && ::write(control_fd, line.data(), line.size()) < 0) return 1;
    return 1;
  }
}
