#include "core/control/mpc/reference_governor.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "core/control/prediction.h"
#include "core/grid/random.h"
#include "tests/core/control/closed_loop.h"
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
      s.mask.at(i, j) = r2 <= 30;
      s.rim.at(i, j) = r2 <= 30 && r2 > 20;
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
  return a.kind == b.kind && a.drops == b.drops && a.objective_mm == b.objective_mm &&
         a.objective_none_mm == b.objective_none_mm;
}

}  // namespace

TEST_CASE(
    "The first target lies K layers of the first model under the last, on the rim the rim's share of that, "
    "and never under the ground") {
  Setup s = small_disc(0.04, 0.8);
  s.target.at(6, 6) = 0.005;
  ReferenceGovernor mpc(s, options_of(2.5, 1));
  for (const double factor : {1.0, 1.3}) {  // the estimate of the flow does not move it
    mpc.use_models(s.model.times(factor), s.model_b.times(factor));
    const HeightMap h = mpc.first_stage_target();
    for (std::size_t c = 0; c < h.size(); ++c) {
      const double down = 2.5 * 7.6e-3 * (s.rim.cells[c] ? 0.8 : 1.0);
      CHECK(h.cells[c] == Approx(std::max(0.0, s.target.cells[c] - down)).margin(1e-12));
    }
  }
}

TEST_CASE(
    "While a layer betters the first target the decision is that of MPC on it, and afterwards the plan whose "
    "J^2 + n (w l)^2 is least") {
  int first_stage = 0, last_stage = 0, shorter = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    Setup s = small_disc(0.05, 0.85);
    const ControlOptions o = options_of(2.0, 3);
    HeightMap h(s.grid);
    const double deep = random.uniform(0.0, 0.03);
    for (std::size_t c = 0; c < h.size(); ++c)
      h.cells[c] = s.mask.cells[c] ? 0.05 - deep - random.uniform(0.0, 0.003) : 0.0;
    const Measurement m{h, 5, 0, 1e-4};
    const Decision d = ReferenceGovernor(s, o).decide(m);
    Setup lower = s;
    lower.target = ReferenceGovernor(s, o).first_stage_target();
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
      const double cost = plan.objective_mm * plan.objective_mm +
                          n * std::pow(ReferenceGovernor::kProcessNoiseStd * 7.6e-3, 2);
      if (plan.kind == Decision::Kind::kPrint && cost < least) {
        best = plan;
        least = cost;
        shorter += n < 3;
      }
    }
    if (best)
      CHECK(same(d, *best));
    else
      CHECK(d.kind == Decision::Kind::kEnd);
  }
  CHECK(first_stage > 5);
  CHECK(last_stage > 5);
  CHECK(shorter > 0);
}

TEST_CASE(
    "Where droplets at the rim add less, no inside is finished before the rim is within K layers, and the "
    "print ends with both at the target") {
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
      // The rim at the first target, but for errors that single droplets cannot correct.
      const bool rim_up = lowest(s, h, true) > 0.06 - k * layer_mm * 0.5 - 0.6 * layer_mm;
      h = nature.after(h, d.drops, places(s));
      early = early || (lowest(s, h, false) > 0.06 - 0.5 * layer_mm && !rim_up);
    }
    CHECK(ended);
    CHECK(error_stats(h, s.target, s.mask).rms_mm < 1.5e-3);
    if (layers > 0.0)
      CHECK_FALSE(early);
    else
      CHECK(early);  // without it the inside is finished first
  }
}

TEST_CASE(
    "While the rim is behind by more than L layers the target is the first one lowered by what the rest "
    "misses, else the first one") {
  int waiting = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    Setup s = small_disc(0.05, 0.8);
    for (std::size_t c = 0; c < s.target.size(); ++c)
      s.target.cells[c] += s.mask.cells[c] ? random.uniform(0.0, 0.02) : 0.0;
    ControlOptions o = options_of(double(seed % 3), 1);
    o.mpc.rim_lead_layers = random.uniform(0.5, 3.0);
    ReferenceGovernor mpc(s, o);
    HeightMap h(s.grid);
    const double behind = random.uniform(0.0, 0.03);
    for (std::size_t c = 0; c < h.size(); ++c)
      h.cells[c] = random.uniform(0.03, 0.06) - (s.rim.cells[c] ? behind : 0.0);
    const HeightMap first = mpc.first_stage_target(), held = mpc.governed_target(h);
    double missing[2] = {}, cells[2] = {};
    for (std::size_t c = 0; c < h.size(); ++c)
      if (s.mask.cells[c]) {
        missing[s.rim.cells[c]] += first.cells[c] - h.cells[c];
        cells[s.rim.cells[c]] += 1.0;
      }
    const double rest = missing[0] / cells[0], rim = missing[1] / cells[1];
    const double back = rest > 0.0 && rim - rest > o.mpc.rim_lead_layers * 7.6e-3 ? rest : 0.0;
    waiting += back > 0.0;
    for (std::size_t c = 0; c < h.size(); ++c)
      CHECK(held.cells[c] == Approx(std::max(0.0, first.cells[c] - back)).margin(1e-12));
    s.rim = Mask(s.grid);  // no rim: nothing to wait for
    CHECK(ReferenceGovernor(s, o).governed_target(h) == ReferenceGovernor(s, o).first_stage_target());
  }
  CHECK(waiting > 10);
  CHECK(waiting < 40);
}

TEST_CASE(
    "The inside stays within L layers of a rim where droplets add less, with a number of last layers or "
    "without, and the print ends at the target") {
  const Setup s = small_disc(0.06, 0.5);
  const double layer_mm = s.model.layer_height_mm();
  const auto mean = [&s](const HeightMap& h, bool rim) {
    double sum = 0.0, cells = 0.0;
    for (std::size_t c = 0; c < h.size(); ++c)
      if (s.mask.cells[c] && (s.rim.cells[c] != 0) == rim) {
        sum += h.cells[c];
        cells += 1.0;
      }
    return sum / cells;
  };
  for (const double last : {0.0, 1.0})
    for (const double lead : {0.0, 0.5, 1.0}) {
      ControlOptions o = options_of(last, 2);
      o.mpc.rim_lead_layers = lead;
      const auto mpc = make_controller(s, o);
      Predictor nature(s);
      HeightMap h(s.grid);
      double ahead = 0.0;
      bool ended = false;
      for (int layer = 0; layer < 80 && !ended; ++layer) {
        const Decision d = mpc->decide({h, layer, 0, 0.0});
        ended = d.kind == Decision::Kind::kEnd;
        h = nature.after(h, d.drops, places(s));
        ahead = std::max(ahead, mean(h, false) - mean(h, true));
      }
      INFO("L = " << lead << ", K = " << last);
      CHECK(ended);
      CHECK(error_stats(h, s.target, s.mask).rms_mm < 2e-3);
      if (lead > 0.0)
        CHECK(ahead < (lead + 1.0) * layer_mm);
      else
        CHECK(ahead > 2.2 * layer_mm);
    }
}

TEST_CASE(
    "Rising together, the last stage prints full layers while more than two are missing, and no lean one "
    "before they are worth their time") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const Setup s = small_disc(0.05, 0.85);
    ControlOptions o = options_of(3.0, 3);
    o.mpc.rim_lead_layers = 1.5;
    HeightMap h(s.grid);
    const double missing = random.uniform(2.1, 2.9) * s.model.layer_height_mm();
    for (std::size_t c = 0; c < h.size(); ++c)
      h.cells[c] = s.mask.cells[c] ? 0.05 - missing * (s.rim.cells[c] ? 0.85 : 1.0) : 0.0;
    const Decision full = ReferenceGovernor(s, o).decide({h, 5, 0, 1e-4});
    REQUIRE(full.kind == Decision::Kind::kPrint);
    CHECK(full.drops.total() > 0.97 * double(std::count(s.mask.cells.begin(), s.mask.cells.end(), 1)));
    // A rim of the first stage that is short by a few single droplets does not hold that layer up.
    const HeightMap first = ReferenceGovernor(s, o).first_stage_target();
    HeightMap near = first;
    int low = 0;
    for (std::size_t c = 0; c < near.size() && low < 2; ++c)
      if (s.rim.cells[c] && c % 3 == seed % 3) {
        near.cells[c] -= 2.6e-3;
        ++low;
      }
    Setup lower = s;
    lower.target = first;
    const Decision lean = Mpc(lower, o).decide({near, 5, 0, 1e-4}),
                   next = ReferenceGovernor(s, o).decide({near, 5, 0, 1e-4});
    CHECK(lean.drops.total() <= 4);
    CHECK(next.drops.total() > 50);
  }
}

TEST_CASE("Two stages end every print, whatever the part, the inks, alpha and the method") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    GuardCase c = random_case(seed);
    if (c.options.mpc.method == MpcMethod::kGreedy) continue;  // which has no guard
    c.options.mpc.finish_layers = double(seed % 3);
    c.options.mpc.rim_lead_layers = seed % 2 ? 1.5 : 0.0;
    const auto mpc = make_controller(c.setup, c.options);
    LoopConditions loop{0.3, 3e-4, 1e-3, seed, 120};
    INFO("case " << seed << " " << c.method);
    CHECK(run_loop(*mpc, c.setup, loop).ended);
  }
}

TEST_CASE(
    "A stage whose layers no longer better the part gives way to the next: whatever the outline and the rim, "
    "no print ends a stage short") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    Setup s = small_disc(0.06, 0.8);
    for (std::size_t c = 0; c < s.mask.size(); ++c)  // a ragged outline
      if (s.rim.cells[c] && random.uniform() < 0.3) s.mask.cells[c] = s.rim.cells[c] = 0;
    ControlOptions o = options_of(3.0, 2);
    o.mpc.rim_lead_layers = seed % 4 == 0 ? 0.0 : 1.5;
    const auto mpc = make_controller(s, o);
    Setup printer = s;  // on the true rim almost all ink runs off
    printer.model_b = s.model.times(random.uniform(0.0, 0.02));
    Predictor nature(printer);
    HeightMap h(s.grid);
    Decision d;
    int layer = 0;
    bool waited = false;
    for (; layer < 120; ++layer) {
      d = mpc->decide({h, layer, 0, 0.001});
      if (d.kind != Decision::Kind::kPrint) break;
      waited = waited || d.reason.find("waits for the rim") != std::string::npos;
      h = nature.after(h, d.drops, places(s));
    }
    double missing = 0.0, cells = 0.0;
    for (std::size_t c = 0; c < h.size(); ++c)
      if (s.mask.cells[c] && !s.rim.cells[c]) {
        missing += s.target.cells[c] - h.cells[c];
        cells += 1.0;
      }
    INFO("seed " << seed << ", " << layer << " layers, " << d.reason);
    CHECK(d.kind == Decision::Kind::kEnd);
    CHECK(waited == (o.mpc.rim_lead_layers > 0.0));
    CHECK(missing / cells < 0.5 * s.model.layer_height_mm());
  }
}

TEST_CASE("A number of last layers that is none is refused by name") {
  for (const double bad : {-1.0, std::nan("")}) {
    CHECK_THROWS_WITH(ReferenceGovernor(small_disc(0.04, 0.8), options_of(bad, 1)),
                      Catch::Contains("finish_layers"));
    ControlOptions o = options_of(1.0, 1);
    o.mpc.rim_lead_layers = bad;
    CHECK_THROWS_WITH(ReferenceGovernor(small_disc(0.04, 0.8), o), Catch::Contains("rim_lead_layers"));
  }
}

}  // namespace firn::control
