#include "core/control/mpc/guard.h"

#include <catch2/catch.hpp>

#include "tests/core/control/guard_cases.h"

using namespace firn;
using namespace firn::control;

TEST_CASE(
    "No decision is worse than printing nothing, whatever alpha, horizon, method, mask and inks, and each "
    "tells the model's objectives") {
  int printed = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const GuardCase c = random_case(seed);
    const Decision d = make_controller(c.setup, c.options)->decide({c.height, int(seed % 60), 0, 0.0});
    printed += d.kind == Decision::Kind::kPrint;
    INFO("seed " << seed << ", " << c.method << ", alpha " << c.alpha << ", N " << c.options.mpc.horizon);
    CHECK(right(c, d));
  }
  CHECK(printed > 200);
}

TEST_CASE(
    "Erratum (8), for ever: even with alpha below 0.1 and a noisy sensor that nobody told about, strips and "
    "descent end every print") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    GuardCase c = random_case(seed);
    if (c.options.mpc.method == MpcMethod::kGreedy) c.options.mpc.method = MpcMethod::kDescent;
    RandomStream random(seed, Purpose::kInstance);
    c.alpha = random.uniform(0.01, 0.1);
    c.options.mpc.alpha = {{1, c.alpha}};
    c.options.noise_gate = 0.0;
    const int full = int(0.06 / c.setup.model.h1_mm) + 1;
    INFO("seed " << seed << ", alpha " << c.alpha);
    CHECK(print_until_end(c, 0.4, 0.001, 20 * full) >= 0);
  }
}

TEST_CASE("A layer is useful by the share of its height that goes where height is missing") {
  const GridSpec g{7, 7};
  Setup s{g, HeightMap(g, 0.1), Mask(g, 1), {}, deposition::Border::kKeep, 1};
  s.model.h2_mm = s.model.h3_mm = 0.0;
  HeightMap h(g, 0.1);
  h.at(3, 3) -= 0.25 * s.model.h1_mm;
  DropletPattern u(g);
  CHECK(mpc::useful_share(s, h, u, {}) == 0.0);
  u.at(3, 3) = 1;
  CHECK(mpc::useful_share(s, h, u, {}) == Approx(0.25));
  u.at(1, 1) = 1;
  CHECK(mpc::useful_share(s, h, u, {}) == Approx(0.125));
}
