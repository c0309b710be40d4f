#include "core/control/registration.h"

#include <algorithm>

#include "core/options/require.h"

namespace firn::control {
namespace {

constexpr std::string_view kWhere = "control.registration";

}  // namespace

std::vector<Mark> registration_marks(const Mask& mask, int spacing_cells) {
  std::vector<Mark> marks;
  const GridSpec& g = mask.spec;
  const int edge = spacing_cells / 2;
  for (int row = 0, j = edge; j < g.ny - edge; ++row, j += spacing_cells)
    for (int column = 0, i = edge; i < g.nx - edge; ++column, i += spacing_cells)
      if (mask.at(i, j)) marks.push_back({i, j, (row + column) % 2 == 0 ? Material::kA : Material::kB});
  return marks;
}

RegistrationPrint::RegistrationPrint(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      layers_(options.registration.layers),
      predict_(setup),
      drops_(setup.grid),
      materials_(setup.grid) {
  const RegistrationOptions& o = options.registration;
  require(!setup.geometry, kWhere, "marks are printed without a geometry");
  check_options(kWhere, kRegistrationOptions, o);
  int of_a = 0, of_b = 0;
  for (const Mark& m : registration_marks(setup.mask, o.spacing_cells)) {
    drops_.at(m.i, m.j) = 1;
    ++(m.material == Material::kA ? of_a : of_b);
  }
  require(of_a >= 3 && of_b >= 3, kWhere,
          "the part has room for " + std::to_string(of_a) + " and " + std::to_string(of_b) +
              " marks of the two nozzles; three of each are the least");
  for (std::size_t c = 0; c < drops_.size(); ++c)
    if (setup.mask.cells[c]) materials_.set(c, Material::kA);
  for (const Mark& m : registration_marks(setup.mask, o.spacing_cells))
    materials_.set(setup.grid.index(m.i, m.j), m.material);
}

Decision RegistrationPrint::decide(const Measurement& m) {
  check(m, setup_);
  Decision d;
  const bool more = m.layer < layers_;
  d.kind = more ? Decision::Kind::kPrint : Decision::Kind::kEnd;
  d.drops = more ? drops_ : DropletPattern(setup_.grid);
  d.materials = materials_;
  d.reason =
      more ? "droplet " + std::to_string(m.layer + 1) + " of " + std::to_string(layers_) + " on each mark"
           : "each mark has its " + std::to_string(layers_) + " droplets";
  predict_.score(d, known_heights(m), 1.0);
  return d;
}

}  // namespace firn::control
