// Computes random layer problems, and their cost by the height-change model itself.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/control/mpc/layer/layer_problem.h"
#include "core/grid/random.h"

namespace firn::test {

struct StripInstance {
  control::Setup setup;
  HeightMap height;
  MaterialMap materials;
};

/// A random surface somewhat below the target, with holes in the mask, either border, and two inks or one.
inline StripInstance random_instance(std::uint64_t seed, int nx, int ny, bool two_inks) {
  RandomStream random(seed, Purpose::kTest);
  const GridSpec g{nx, ny};
  StripInstance in{{g,
                    HeightMap(g, 0.1),
                    Mask(g, 1),
                    {},
                    random.below(2) ? deposition::Border::kLose : deposition::Border::kKeep,
                    seed},
                   HeightMap(g),
                   {}};
  in.setup.model.h2_mm = in.setup.model.h1_mm * random.uniform(0.0, 1.0);
  in.setup.model.h3_mm = in.setup.model.h2_mm / 3.0;
  in.setup.model_b = in.setup.model;
  in.setup.model_b.h1_mm *= 0.6;
  for (std::size_t c = 0; c < g.size(); ++c) {
    in.height.cells[c] = 0.1 - random.uniform(0.0, in.setup.model.layer_height_mm());
    if (random.below(8) == 0) in.setup.mask.cells[c] = 0;
  }
  in.setup.mask.cells[0] = 1;
  if (two_inks) {
    in.materials = MaterialMap(g);
    for (auto& m : in.materials.cells) m = std::uint8_t(random.below(2) ? Material::kB : Material::kA);
  }
  return in;
}

/// Sum of |error| over the mask by the height-change model itself, in double precision.
inline double by_model_mm(const StripInstance& in, const DropletPattern& u) {
  HeightMap h = in.height;
  std::vector<deposition::Stencil<1>> stencils(h.size());
  for (std::size_t c = 0; c < h.size(); ++c)
    stencils[c] =
        deposition::stencil_of(in.setup.model_of(in.materials.size() ? in.materials.of(c) : Material::kA));
  deposition::HeightChange<1> model(in.setup.grid, stencils[0], in.setup.border);
  model.step(h.data(), u.data(), 0, stencils);
  double sum = 0.0;
  for (std::size_t c = 0; c < h.size(); ++c)
    if (in.setup.mask.cells[c]) sum += std::abs(h.cells[c] - in.setup.target.cells[c]);
  return sum;
}

inline DropletPattern random_drops(const StripInstance& in, RandomStream& random) {
  DropletPattern u(in.setup.grid);
  for (std::size_t c = 0; c < u.size(); ++c) u.cells[c] = in.setup.mask.cells[c] && random.below(2);
  return u;
}

inline constexpr double kSinglePrecision_mm = 2e-7;  // of a sum over some dozen cells of 0.01 mm

/// The least cost of any layer, by trying all of them. @pre 16 cells
inline double best_by_brute_force_mm(const StripInstance& in) {
  double best = 1e9;
  DropletPattern u(in.setup.grid);
  for (std::uint32_t bits = 0; bits < 1u << 16; ++bits) {
    bool allowed = true;
    for (std::size_t c = 0; c < 16; ++c) {
      u.cells[c] = bits >> c & 1;
      allowed = allowed && (!u.cells[c] || in.setup.mask.cells[c]);
    }
    if (allowed) best = std::min(best, by_model_mm(in, u));
  }
  return best;
}

}  // namespace firn::test
