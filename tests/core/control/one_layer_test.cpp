#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/bound/bound.h"
#include "core/control/mpc/layer/one_layer.h"
#include "core/control/mpc/mpc.h"
#include "core/control/prediction.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::test;

TEST_CASE(
    "The mean error a few rows at a time is the whole model's to the last bit, wherever the bands are cut") {
  for (const int ny : {1, 2, 63, 64, 65, 66, 129}) {
    const StripInstance in = random_instance(std::uint64_t(ny), 11, ny, false);
    RandomStream random(7, Purpose::kTest);
    const DropletPattern u = random_drops(in, random);
    CHECK(mpc::mean_error_mm(in.setup, in.height, u) ==
          objective_mm(Predictor(in.setup).after(in.height, u), in.setup.target, in.setup.mask, 1.0));
  }
}

TEST_CASE(
    "One layer by strips tells the model's objectives, whether the surface off the part is known or not") {
  for (const MpcMethod method : {MpcMethod::kStripDp, MpcMethod::kCertified}) {
    StripInstance in = random_instance(3, 30, 70, false);
    ControlOptions o;
    o.mpc.method = method;
    for (std::size_t c = 0; c < in.height.size(); ++c)
      if (!in.setup.mask.cells[c]) in.height.cells[c] = 0.0;
    const Decision d = Mpc(in.setup, o).decide({in.height, 0});
    REQUIRE(d.kind == Decision::Kind::kPrint);
    CHECK(d.objective_mm ==
          objective_mm(Predictor(in.setup).after(in.height, d.drops), in.setup.target, in.setup.mask, 1.0));
    CHECK(d.objective_none_mm == objective_mm(in.height, in.setup.target, in.setup.mask, 1.0));
    HeightMap unknown = in.height;
    for (std::size_t c = 0; c < unknown.size(); ++c)
      if (!in.setup.mask.cells[c]) unknown.cells[c] = std::nan("");
    CHECK(Mpc(in.setup, o).decide({unknown, 0}).drops == d.drops);
  }
}

TEST_CASE(
    "A rim whose droplets add as much as all others changes no decision, and one that takes less is planned "
    "with that") {
  StripInstance in = random_instance(12, 16, 14, false);
  ControlOptions o;
  o.mpc.method = MpcMethod::kStripDp;
  Setup rim = in.setup;
  rim.rim = Mask(in.setup.grid);
  for (int i = 0; i < 16; ++i) rim.rim.at(i, 0) = rim.rim.at(i, 1) = 1;
  rim.model_b = rim.model;
  const Decision plain = Mpc(in.setup, o).decide({in.height, 0}), same = Mpc(rim, o).decide({in.height, 0});
  CHECK(same.drops == plain.drops);
  CHECK(same.objective_mm == Approx(plain.objective_mm).epsilon(1e-12));
  CHECK(same.materials.size() == 0);
  Mpc half(rim, o);
  half.use_models(rim.model, rim.model.times(0.4));
  const Decision d = half.decide({in.height, 0});
  Setup known = rim;
  known.model_b = rim.model.times(0.4);
  MaterialMap models(in.setup.grid);
  for (std::size_t c = 0; c < models.size(); ++c)
    models.set(c, rim.rim.cells[c] ? Material::kB : Material::kA);
  CHECK(d.objective_mm == Approx(objective_mm(Predictor(known).after(in.height, d.drops, models),
                                              known.target, known.mask, 1.0))
                              .epsilon(1e-12));
  CHECK(d.drops != plain.drops);
  rim.rim = Mask(GridSpec{3, 3});
  CHECK_THROWS_WITH(check(rim), Catch::Matchers::Contains("rim"));
}

TEST_CASE(
    "A grid above a million cells is decided by strips from the full layer, near what smaller ones reach") {
  const GridSpec g{1001, 1000};
  Setup s{g, HeightMap(g, 0.05), Mask(g, 1), {}, deposition::Border::kLose, 1};
  HeightMap h(g);
  RandomStream random(1, Purpose::kInstance);
  for (double& x : h.cells) x = 0.05 - random.uniform(0.0, 0.0076);
  ControlOptions o;
  o.mpc.method = MpcMethod::kStripDp;
  o.mpc.strip_rows = 2;
  const Decision d = Mpc(s, o).decide({h, 0});
  REQUIRE(d.kind == Decision::Kind::kPrint);
  CHECK(d.objective_mm < 1.346e-3);  // bench/mpc_bench large: 1.345
  ControlOptions certified = o;
  certified.mpc.method = MpcMethod::kCertified;
  const Decision same = Mpc(s, certified).decide({h, 0});
  CHECK(same.drops == d.drops);
  CHECK_THAT(same.reason, Catch::Matchers::Contains("certified decides as strip_dp, without a bound"));
}

namespace {

struct HardLayer {
  const char* name;
  Setup setup;
  HeightMap height;
};

// Layers that one sweep leaves some tenths of a percent off: wide droplets, and a ramp oblique to the rows.
std::vector<HardLayer> hard_layers(int n) {
  const GridSpec g{n, n};
  const deposition::DropletModel wide{3.7e-3, 0.85e-3, 0.3e-3}, usual{};
  const Setup wide_setup{g, HeightMap(g, 0.05), Mask(g, 1), wide, deposition::Border::kLose, 1};
  Setup usual_setup = wide_setup;
  usual_setup.model = usual;
  RandomStream random(5, Purpose::kInstance);
  HeightMap even(g), ramp(g), half(g, 0.05 - 0.5 * wide.layer_height_mm());
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      even.at(i, j) = 0.05 - random.uniform(0.0, wide.layer_height_mm());
      ramp.at(i, j) = 0.05 - usual.layer_height_mm() * std::fmod((i + 0.37 * j) / double(n), 1.0);
    }
  return {{"wide droplets", wide_setup, even},
          {"wide droplets, half a layer", wide_setup, half},
          {"oblique ramp", usual_setup, ramp}};
}

}  // namespace

TEST_CASE("control.mpc.gap goes on until the gap or a hundred sweeps, and a layer says what it reached") {
  for (const HardLayer& l : hard_layers(40)) {
    CAPTURE(l.name);
    ControlOptions o;
    o.mpc.method = MpcMethod::kCertified;
    const Decision one = Mpc(l.setup, o).decide({l.height, 0});
    CHECK(one.reason == "the best layer of strips that agree on windows of droplets");
    o.mpc.gap = 0.002;
    const Decision wanted = Mpc(l.setup, o).decide({l.height, 0});
    o.mpc.gap = 0.0;
    o.mpc.sweeps = 100;
    const Decision many = Mpc(l.setup, o).decide({l.height, 0});
    CHECK(wanted.objective_mm <= one.objective_mm);
    CHECK(many.objective_mm <= wanted.objective_mm);
    CHECK_THAT(wanted.reason, Catch::Matchers::Contains("no layer is better by more than "));
    // The proof shares no code with the search.
    const double cells = double(l.setup.grid.size());
    const mpc::LowerBound bound =
        mpc::lower_bound(l.setup, l.height, {}, many.objective_mm * cells, {2, 100, 1e-6}, serially);
    const double gap = 1.0 - bound.total_mm / cells / wanted.objective_mm;
    const bool hundred = wanted.reason.find("after 100 sweeps") != std::string::npos;
    CHECK((gap <= 0.002 + 1e-4 || hundred));
    CHECK(gap < 0.01);
  }
}
