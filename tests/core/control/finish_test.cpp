#include "core/control/mpc/finish.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "tests/core/control/closed_loop.h"
#include "core/control/prediction.h"
#include "core/grid/random.h"
#include "tests/core/control/guard_cases.h"

namespace firn::control {
namespace {

ControlOptions options_of(double layers, int horizon) {
  ControlOptions o;
  o.mpc.method = MpcMethod::kStripDp;
  o.mpc.error = ErrorKind::kSquare;
  o.mpc.horizon = horizon;
  o.mpc.anneal_sweeps = 10;
  o.mpc.finish_layers = layers;
  return o;
}

// A disc of 11 cells whose outermost cells are the rim, where droplets add `share` of the model's height.
Setup small_disc(double height_mm, double share) {
  const GridSpec g{13, 13};
  Setup s{g, HeightMap(g), Mask(g), {}, deposition::Border::kLose, 3};
  s.rim = Mask(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const int r2 = (i - 6) * (i - 6) + (j - 6) * (j - 6);
      s.mask.at(i, j) = r2 <= 30, s.rim.at(i, j) = r2 <= 30 && r2 > 20;
      s.target.at(i, j) = r2 <= 30 ? height_mm : 0.0;
    }
  s.model_b = s.model.times(share);
  return s;
}

MaterialMap places(const Setup& s) {
  MaterialMap m(s.grid);
  for (std::size_t c = 0; c < m.size(); ++c) m.set(c, s.rim.cells[c] ? Material::kB : Material::kA);
  return m;
}

double lowest(const Setup& s, const HeightMap& h, bool rim) {
  double low = 1e9;
  for (std::size_t c = 0; c < h.size(); ++c)
    if (s.mask.cells[c] && (s.rim.cells[c] != 0) == rim) low = std::min(low, h.cells[c]);
  return low;
}

bool same(const Decision& a, const Decision& b) {
  return a.kind == b.kind && a.drops == b.drops && a.objective_mm == b.objective_mm && a.objective_none_mm == b.objective_none_mm;
}

}  // namespace

TEST_CASE("The first target lies K layers of the first model under the last, on the rim the rim's share of that, and never under the ground") {
  Setup s = small_disc(0.04, 0.8);
  s.target.at(6, 6) = 0.005;
  FinishTogether mpc(s, options_of(2.5, 1));
  for (const double factor : {1.0, 1.3}) {  // what is learned of the flow does not move it
    mpc.use_models(s.model.times(factor), s.model_b.times(factor));
    const HeightMap h = mpc.first_target();
    for (std::size_t c = 0; c < h.size(); ++c) {
      const double down = 2.5 * 7.6e-3 * (s.rim.cells[c] ? 0.8 : 1.0);
      CHECK(h.cells[c] == Approx(std::max(0.0, s.target.cells[c] - down)).margin(1e-12));
    }
  }
}

TEST_CASE("While a layer betters the first target the decision is that of MPC on it, and afterwards the plan whose J^2 + n (w l)^2 is least") {
  int first_stage = 0, last_stage = 0, shorter = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    Setup s = small_disc(0.05, 0.85);
    const ControlOptions o = options_of(2.0, 3);
    HeightMap h(s.grid);
    const double deep = random.uniform(0.0, 0.03);
    for (std::size_t c = 0; c < h.size(); ++c) h.cells[c] = s.mask.cells[c] ? 0.05 - deep - random.uniform(0.0, 0.003) : 0.0;
    const Measurement m{h, 5, 0, 1e-4};
    const Decision d = FinishTogether(s, o).decide(m);
    Setup lower = s;
    lower.target = FinishTogether(s, o).first_target();
    const Decision first = Mpc(lower, o).decide(m);
    if (first.kind == Decision::Kind::kPrint) {
      ++first_stage;
      CHECK(same(d, first));
      continue;
    }
    ++last_stage;
    std::optional<Decision> best;
    double least = 1e9;
    for (int n = 1; n <= 3; ++n) {
      ControlOptions one = o;
      one.mpc.horizon = n;
      const Decision plan = Mpc(s, one).decide(m);
      const double cost = plan.objective_mm * plan.objective_mm + n * std::pow(FinishTogether::kWander * 7.6e-3, 2);
      if (plan.kind == Decision::Kind::kPrint && cost < least) best = plan, least = cost, shorter += n < 3;
    }
    if (best) CHECK(same(d, *best));
    else CHECK(d.kind == Decision::Kind::kEnd);
  }
  CHECK(first_stage > 5);
  CHECK(last_stage > 5);
  CHECK(shorter > 0);
}

TEST_CASE("Where droplets at the rim add less, no inside is finished before the rim is within K layers, and the print ends with both at the target") {
  const Setup s = small_disc(0.06, 0.5);
  const double k = 2.0, layer_mm = s.model.layer_height_mm();
  for (const double layers : {0.0, k}) {
    const ControlOptions o = options_of(layers, 3);
    const auto mpc = make_controller(s, o);
    Predictor nature(s);
    HeightMap h(s.grid);
    bool ended = false, early = false;
    for (int layer = 0; layer < 60 && !ended; ++layer) {
      const Decision d = mpc->decide({h, layer, 0, 0.0});
      ended = d.kind == Decision::Kind::kEnd;
      if (ended) break;
      // The rim at the first target, but for what single droplets cannot mend.
      const bool rim_up = lowest(s, h, true) > 0.06 - k * layer_mm * 0.5 - 0.6 * layer_mm;
      h = nature.after(h, d.drops, places(s));
      early = early || (lowest(s, h, false) > 0.06 - 0.5 * layer_mm && !rim_up);
    }
    CHECK(ended);
    CHECK(error_stats(h, s.target, s.mask).rms_mm < 1.5e-3);
    if (layers > 0.0) CHECK_FALSE(early);
    else CHECK(early);  // without it the inside is finished first
  }
}

TEST_CASE("Two stages end every print, whatever the part, the inks, alpha and the method") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    GuardCase c = random_case(seed);
    if (c.options.mpc.method == MpcMethod::kGreedy) continue;  // which has no guard
    c.options.mpc.finish_layers = 1.0 + double(seed % 3);
    const auto mpc = make_controller(c.setup, c.options);
    LoopConditions loop{0.3, 3e-4, 1e-3, seed, 120};
    INFO("case " << seed << " " << c.method);
    CHECK(run_loop(*mpc, c.setup, loop).ended);
  }
}

TEST_CASE("A number of last layers that is none is refused by name") {
  for (const double bad : {-1.0, std::nan("")})
    CHECK_THROWS_WITH(FinishTogether(small_disc(0.04, 0.8), options_of(bad, 1)), Catch::Contains("finish_layers"));
}

}  // namespace firn::control
