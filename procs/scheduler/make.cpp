// The table of the labs' loops.
#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "config/machine.h"
#include "core/grid/npy.h"
#include "core/path/job_codec.h"
#include "procs/scheduler/droplet_loop.h"
#include "procs/scheduler/line_loop.h"
#include "procs/scheduler/path_loop.h"

namespace firn {
namespace {

std::unique_ptr<Node> droplet_loop(const Experiment& e, const Blobs& blobs) {
  return std::make_unique<DropletLoop>(e, height_map_from_npy(blob(blobs, "target").bytes, e.grid, "target"),
                                       mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"));
}

std::unique_ptr<Node> path_loop(const Experiment& e, const Blobs& blobs) {
  const auto& machine = blob(blobs, "machine").bytes;
  const std::string text(reinterpret_cast<const char*>(machine.data()), machine.size());
  return std::make_unique<PathLoop>(e, slice::decode_print_paths(blob(blobs, "paths").bytes),
                                    parse_machine(text, "machine").tick_s);
}

std::unique_ptr<Node> line_loop(const Experiment& e, const Blobs& blobs) {
  return std::make_unique<LineLoop>(e, height_map_from_npy(blob(blobs, "target").bytes, e.grid, "target"),
                                    mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"),
                                    decode_job(blob(blobs, "job").bytes));
}

struct LabLoop {
  std::string_view lab;  ///< lab.kind
  std::unique_ptr<Node> (*make)(const Experiment&, const Blobs&);
};
constexpr LabLoop kLoops[] = {
    {"inkjet", &droplet_loop},
    {"ice", &path_loop},
    {"aerosol", &line_loop},
};

}  // namespace

std::unique_ptr<Node> make_scheduler(const std::string& config_toml, const Blobs& blobs) {
  const Experiment e = parse_recorded_experiment(config_toml, "experiment.toml");
  const auto loop = std::ranges::find(kLoops, std::string_view(e.lab.kind), &LabLoop::lab);
  if (loop == std::end(kLoops))
    throw std::invalid_argument("lab.kind = \"" + e.lab.kind + "\": scheduler has no loop for it");
  return loop->make(e, blobs);
}

}  // namespace firn
