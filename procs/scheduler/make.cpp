// Which loop an experiment's lab has.
#include "config/machine.h"
#include "core/grid/npy.h"
#include "procs/scheduler/droplet_loop.h"
#include "procs/scheduler/path_loop.h"

namespace firn {

std::unique_ptr<Node> make_scheduler(const std::string& config_toml, const Blobs& blobs) {
  const Experiment e = parse_experiment(config_toml, "experiment.toml");
  if (is_ice(e)) {
    const auto& machine = blob(blobs, "machine").bytes;
    const std::string text(reinterpret_cast<const char*>(machine.data()), machine.size());
    return std::make_unique<PathLoop>(e, slice::decode_print_paths(blob(blobs, "paths").bytes),
                                      parse_machine(text, "machine").tick_s);
  }
  return std::make_unique<DropletLoop>(e, height_map_from_npy(blob(blobs, "target").bytes, e.grid, "target"),
                                       mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"));
}

}  // namespace firn
