#include "cli/block_trial.h"

#include <time.h>

#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "plant/model.h"
#include "plant/setup.h"
#include "procs/controller/node.h"

namespace firn {
namespace {

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

HeightMap measured(const HeightMap& truth, const Experiment& e, int layer) {
  HeightMap map = truth;
  for (std::uint32_t c = 0; c < map.size(); ++c)
    map.cells[c] += e.plant.sensor_noise_mm *
                    random_normal({e.plant.seed, Purpose::kSensorNoise, std::uint32_t(layer), 0, c});
  return map;
}

void deposit(const control::Decision& d, plant::Model& model) {
  const GridSpec& g = d.drops.spec;
  for (int pass = 0; pass < d.drops.passes(); ++pass) {
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i)
        if (d.drops.at(i, j) > pass)
          model.fire({0, g.x_mm(i), g.y_mm(j), 0.0, 0.0, d.materials.of(g.index(i, j))});
    model.end_pass();
  }
}

}  // namespace

BlockTrial print_block(const Experiment& e, const Blobs& inputs) {
  const control::Setup setup = control_setup(
      e, height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target"),
      mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask"),
      std::make_shared<const Geometry>(geometry_from_bytes(blob(inputs, "geometry").bytes, e.grid, "geometry")));
  const auto scheme = control::make_controller(setup, control_options(e));
  const auto model = plant::make_model(plant::world_config(e));
  BlockTrial trial;
  for (;; ++trial.layers) {
    model->measured();
    const HeightMap map = measured(model->cell_means(), e, trial.layers);
    const double begin = cpu_s();
    const control::Decision d = scheme->decide({map, trial.layers, 0, e.plant.sensor_noise_mm});
    trial.decide_cpu_s += cpu_s() - begin;
    trial.ended = d.kind == control::Decision::Kind::kEnd;
    if (d.kind != control::Decision::Kind::kPrint) break;
    deposit(d, *model);
    trial.droplets += d.drops.total();
    model->expose(trial.layers);
  }
  trial.printed = model->materials();
  trial.height = model->cell_means();
  return trial;
}

}  // namespace firn
