#include "tests/core/control/closed_loop.h"

#include "core/grid/random.h"

namespace firn::control {

LoopResult run_loop(LayerController& controller, const Setup& s, const LoopConditions& q) {
  LoopResult r;
  r.height = HeightMap(s.grid);
  RandomStream substrate(q.seed, Purpose::kSurface);
  for (double& h : r.height.cells) h = q.roughness_mm * substrate.uniform();
  deposition::HeightChange<1> model(s.grid, deposition::stencil_of(s.model), s.border);
  std::vector<deposition::Stencil<1>> droplets(s.grid.size());
  while (r.layers < q.most_layers) {
    HeightMap measured = r.height;
    RandomStream noise(q.seed, Purpose::kSensorNoise, std::uint32_t(r.layers));
    if (q.noise_std_mm > 0.0)
      for (double& h : measured.cells) h += q.noise_std_mm * noise.normal();
    Decision d = controller.decide({measured, r.layers, 0, q.noise_std_mm});
    r.decisions.push_back(d);
    if (d.kind != Decision::Kind::kPrint) {
      r.ended = d.kind == Decision::Kind::kEnd;
      break;
    }
    r.drops += d.drops.total();
    for (int pass = 0; pass < d.drops.passes(); ++pass) {
      for (std::size_t c = 0; c < droplets.size(); ++c) {
        const DrawKey key{q.seed, Purpose::kDropletSize, std::uint32_t(r.layers), std::uint32_t(pass),
                          std::uint32_t(c)};
        const double f = 1.0 + q.variation * random_uniform(key);
        droplets[c] = deposition::stencil_of({f * s.model.h1_mm, f * s.model.h2_mm, f * s.model.h3_mm});
      }
      model.step(r.height.data(), d.drops.data(), pass, droplets);
    }
    ++r.layers;
  }
  r.stats = error_stats(r.height, s.target, s.mask);
  return r;
}

Setup cylinder_setup(double diameter_cells, double height_mm) {
  const double pitch = 0.263256;
  const GridSpec g{40, 40, pitch, pitch};
  ShapeSpec shape;
  shape.height_mm = height_mm;
  shape.diameter_mm = diameter_cells * pitch;
  const Target t = make_shape(shape, g);
  return {g, t.height, t.mask, {}, deposition::Border::kLose, 1};
}

}  // namespace firn::control
