// Plans against all plans there are, on grids small enough to try them all.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/mpc.h"
#include "core/control/prediction.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::test;

namespace {

// Part of a block of two inks, or one ink; the surface up to `layers` layers below the target.
Setup small_setup(std::uint64_t seed, int side, bool two_inks) {
  StripInstance in = random_instance(seed, side, side, false);
  if (two_inks) {
    RandomStream random(seed, Purpose::kInstance);
    std::vector<std::vector<Span>> spans(in.setup.grid.size());
    for (auto& s : spans)
      if (random.below(2)) s = {{0.0, 0.1}};
    in.setup.geometry = std::make_shared<const Geometry>(in.setup.grid, 0.1, spans);
  }
  return in.setup;
}

HeightMap surface(const Setup& s, double layers) {
  RandomStream random(s.seed, Purpose::kSurface);
  HeightMap h(s.grid);
  for (double& v : h.cells) v = 0.1 - random.uniform(0.0, layers * s.model.layer_height_mm());
  return h;
}

void set_bits(DropletPattern& u, std::uint32_t bits) {
  for (std::size_t c = 0; c < u.size(); ++c) u.cells[c] = bits >> c & 1;
}
bool allowed(const Setup& s, const DropletPattern& u) {
  for (std::size_t c = 0; c < u.size(); ++c)
    if (u.cells[c] && !s.mask.cells[c]) return false;
  return true;
}

// The least objective of any plan of `layers` layers.
double best_mm(const Setup& s, const HeightMap& h, double alpha, int layers, int layer = 0) {
  if (layer == layers) return objective_mm(h, s.target, s.mask, alpha);
  Predictor predict(s);
  DropletPattern u(s.grid);
  double best = 1e9;
  const MaterialMap inks = materials_at(s, surface(s, layers), layer * s.model.layer_height_mm());
  for (std::uint32_t bits = 0; bits < 1u << s.grid.size(); ++bits) {
    set_bits(u, bits);
    if (allowed(s, u)) best = std::min(best, best_mm(s, predict.after(h, u, inks), alpha, layers, layer + 1));
  }
  return best;
}

double found_mm(const Setup& s, const HeightMap& h, double alpha, int horizon) {
  ControlOptions o;
  o.mpc.method = MpcMethod::kStripDp;
  o.mpc.horizon = horizon;
  o.mpc.alpha = {{1, alpha}};
  const Decision d = Mpc(s, o).decide({h, 0, 0, 0.0});
  return d.kind == Decision::Kind::kPrint ? d.objective_mm : d.objective_none_mm;
}

}  // namespace

TEST_CASE(
    "Two layers on 3 x 2 cells: strips and annealing find the best of all plans, with one ink and two") {
  int exact = 0, tried = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    Setup s = small_setup(seed, 3, seed % 2);
    for (int i = 0; i < 3; ++i) s.mask.cells[std::size_t(6 + i)] = 0;  // the last row stays bare
    const HeightMap h = surface(s, 2.0);
    const double best = best_mm(s, h, 1.0, 2), found = found_mm(s, h, 1.0, 2);
    CHECK(found >= best - 1e-9);
    exact += found <= best + 1e-9;
    ++tried;
  }
  CHECK(exact >= tried - 1);
}

TEST_CASE(
    "One layer on 4 x 4 cells with two inks: strips find the best of all, at alpha = 1 and nearly always "
    "below") {
  int exact = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Setup s = small_setup(seed, 4, true);
    const HeightMap h = surface(s, 1.0);
    const double alpha = seed % 2 ? 1.0 : 0.6;
    const double best = best_mm(s, h, alpha, 1), found = found_mm(s, h, alpha, 1);
    CHECK(found >= best - 1e-9);
    if (alpha == 1.0) CHECK(found <= best + 1e-8);
    exact += found <= best + 1e-8;
  }
  CHECK(exact >= 7);
}
