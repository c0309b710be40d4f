// Computes random decisions and prints for the guard of MPC: no layer is worse than an empty one, and every
// print ends.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "core/control/controller.h"
#include "core/control/prediction.h"
#include "core/grid/random.h"

namespace firn::control {

/// Grid, mask, border, relief, inks, surface, alpha, horizon and method at random.
struct GuardCase {
  Setup setup;
  HeightMap height;
  ControlOptions options;
  std::string method;
  double alpha = 1.0;
};

inline GuardCase random_case(std::uint64_t seed) {
  RandomStream random(seed, Purpose::kTest);
  const GridSpec g{4 + int(random.below(11)), 4 + int(random.below(11))};
  const double target_mm = random.uniform(0.02, 0.06);
  GuardCase c{{g,
               HeightMap(g, target_mm),
               Mask(g, 1),
               {},
               random.below(2) ? deposition::Border::kLose : deposition::Border::kKeep,
               seed},
              HeightMap(g),
              {},
              {}};
  for (auto& m : c.setup.mask.cells) m = random.below(6) != 0;
  c.setup.mask.cells[0] = 1;
  if (random.below(3) == 0)  // a relief
    for (double& t : c.setup.target.cells) t -= random.uniform(0.0, 0.01);
  c.setup.model.h2_mm = c.setup.model.h1_mm * random.uniform(0.0, 0.6);
  c.setup.model.h3_mm = c.setup.model.h2_mm * random.uniform(0.0, 0.6);
  if (random.below(4) == 0) {  // two inks
    std::vector<std::vector<Span>> spans(g.size());
    for (auto& s : spans)
      if (random.below(2)) s = {{0.0, target_mm}};
    c.setup.geometry = std::make_shared<const Geometry>(g, target_mm, spans);
    c.setup.model_b = {0.8 * c.setup.model.h1_mm, 0.9 * c.setup.model.h2_mm, 0.9 * c.setup.model.h3_mm};
  }
  const double deep = random.uniform(-0.004, 0.02), rough = random.uniform(0.0, 0.012);
  for (std::size_t n = 0; n < g.size(); ++n)
    c.height.cells[n] = c.setup.target.cells[n] - deep - random.uniform(0.0, rough);
  c.alpha = random.below(4) == 0 ? 1.0 : random.uniform(0.02, 1.0);
  c.options.mpc.alpha = {{1, c.alpha}};
  c.options.mpc.horizon = 1 + int(random.below(3));
  c.options.mpc.anneal_sweeps = 30;
  const int method = int(random.below(3));
  c.method = method == 0 ? "greedy" : method == 1 ? "descent" : "strip_dp";
  c.options.mpc.method = method == 0   ? MpcMethod::kGreedy
                         : method == 1 ? MpcMethod::kDescent
                                       : MpcMethod::kStripDp;
  c.options.mpc.start_ones = random.below(2);
  return c;
}

/// The objectives that a decision reports are the model's, and its layer is better than none (for N = 1 by
/// the model itself).
inline bool right(const GuardCase& c, const Decision& d) {
  const double none = objective_mm(c.height, c.setup.target, c.setup.mask, c.alpha);
  if (std::abs(none - d.objective_none_mm) > 1e-12) return false;
  if (d.kind != Decision::Kind::kPrint) return d.drops.total() == 0 && d.objective_mm == d.objective_none_mm;
  if (!(d.objective_mm < none) || d.drops.total() == 0) return false;
  for (std::size_t n = 0; n < d.drops.size(); ++n)
    if (d.drops.cells[n] && !c.setup.mask.cells[n]) return false;
  if (c.options.mpc.horizon > 1) return true;
  const double after = objective_mm(Predictor(c.setup).after(c.height, d.drops, d.materials), c.setup.target,
                                    c.setup.mask, c.alpha);
  return after < none && std::abs(after - d.objective_mm) < 1e-12;
}

/// Layers until the controller ends the print; -1: never, as far as `most` layers tell.
inline int print_until_end(const GuardCase& c, double variation, double noise_mm, int most) {
  const auto controller = make_controller(c.setup, c.options);
  HeightMap height(c.setup.grid);
  deposition::HeightChange<1> model(c.setup.grid, deposition::stencil_of(c.setup.model), c.setup.border);
  std::vector<deposition::Stencil<1>> droplets(height.size());
  for (int layer = 0; layer < most; ++layer) {
    HeightMap measured = height;
    RandomStream sensor(c.setup.seed, Purpose::kSensorNoise, std::uint32_t(layer));
    for (double& h : measured.cells) h += noise_mm * sensor.normal();
    const Decision d = controller->decide({measured, layer, 0, noise_mm});
    if (d.kind != Decision::Kind::kPrint) return layer;
    RandomStream sizes(c.setup.seed, Purpose::kDropletSize, std::uint32_t(layer));
    for (std::size_t n = 0; n < droplets.size(); ++n) {
      const Material m = d.materials.size() ? d.materials.of(n) : Material::kA;
      const double f = 1.0 + variation * (sizes.uniform() - 0.5);
      const deposition::DropletModel& of = c.setup.model_of(m);
      droplets[n] = deposition::stencil_of({f * of.h1_mm, f * of.h2_mm, f * of.h3_mm});
    }
    model.step(height.data(), d.drops.data(), 0, droplets);
  }
  return -1;
}

}  // namespace firn::control
