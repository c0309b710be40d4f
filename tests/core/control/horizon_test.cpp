#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/anneal.h"
#include "core/control/mpc/descent.h"
#include "core/control/mpc/flip_kernel.h"
#include "core/control/mpc/horizon_search.h"
#include "core/control/mpc/mpc.h"
#include "core/control/prediction.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::test;

namespace {

// A random surface `layers` layers below the target at most, holes in the mask, either border.
StripInstance deep_instance(std::uint64_t seed, int nx, int ny, double layers, bool two_inks = false) {
  StripInstance in = random_instance(seed, nx, ny, two_inks);
  RandomStream random(seed, Purpose::kSurface);
  for (double& h : in.height.cells) h = 0.1 - random.uniform(0.0, layers * in.setup.model.layer_height_mm());
  return in;
}

double by_model_mm(const StripInstance& in, const std::vector<DropletPattern>& plan, double alpha) {
  Predictor predict(in.setup);
  HeightMap h = in.height;
  for (const DropletPattern& u : plan) h = predict.after(h, u, in.materials);
  return objective_mm(h, in.setup.target, in.setup.mask, alpha);
}

ControlOptions options(MpcMethod method, int horizon, double alpha = 1.0) {
  ControlOptions o;
  o.mpc.method = method;
  o.mpc.horizon = horizon;
  o.mpc.alpha = {{1, alpha}};
  return o;
}

std::vector<DropletPattern> plan_of(const mpc::HorizonObjective& objective) {
  std::vector<DropletPattern> plan;
  for (int n = 0; n < objective.horizon(); ++n) plan.push_back(objective.layer(n));
  return plan;
}

}  // namespace

TEST_CASE(
    "Descent in raster order leaves no single droplet more or less that improves, by brute force, and needs "
    "no luck") {
  for (std::uint64_t seed = 1; seed <= 18; ++seed) {
    const int horizon = 1 + int(seed % 3), max_drops = 1 + int(seed / 3 % 2);
    const double alpha = seed % 2 ? 1.0 : 0.6;
    const StripInstance in = deep_instance(seed, 7, 6, horizon);
    mpc::HorizonObjective objective(in.setup, horizon, max_drops);
    objective.set_surface(in.height, alpha);
    RandomStream random(seed, Purpose::kTest);
    objective.set_plan(std::vector<DropletPattern>(std::size_t(horizon), random_drops(in, random)));
    const double before = objective.value_mm();
    const auto result = mpc::descend(objective, horizon, 1'000'000);
    REQUIRE(result.optimal);
    auto plan = plan_of(objective);
    const double value = by_model_mm(in, plan, alpha);
    CHECK(value <= before);
    for (auto& layer : plan)
      for (std::size_t c = 0; c < layer.size(); ++c)
        for (const int change : {1, -1}) {
          const int n = layer.cells[c] + change;
          if (!in.setup.mask.cells[c] || n < 0 || n > max_drops) continue;
          layer.cells[c] = std::uint8_t(n);
          CHECK(by_model_mm(in, plan, alpha) >= value - 1e-12);
          layer.cells[c] = std::uint8_t(n - change);
        }
    CHECK_FALSE(mpc::descend(objective, horizon, 3).optimal);
  }
}

TEST_CASE("Strips of one layer after the other never raise the objective") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const StripInstance in = deep_instance(seed, 11, 9, 2.5);
    const mpc::HorizonStart state{in.setup, in.height, {}};
    RandomStream random(seed, Purpose::kTest);
    std::vector<DropletPattern> plan{random_drops(in, random), DropletPattern(in.setup.grid),
                                     DropletPattern(in.setup.grid)};
    double last = by_model_mm(in, plan, 1.0);
    for (int n = 0; n < 3; ++n) {
      mpc::strips_of_layer(plan, n, state, 3);
      const double now = by_model_mm(in, plan, 1.0);
      CHECK(now <= last + 1e-9);
      last = now;
    }
  }
}

TEST_CASE(
    "A longer horizon by strips and annealing is never worse than a shorter one on the same state, and "
    "better on the average than the greedy search") {
  double greedy = 0.0, strips = 0.0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const StripInstance in = deep_instance(seed, 14, 12, 0.5 + double(seed % 4));
    double last = 1e9;
    for (int horizon = 1; horizon <= 3; ++horizon) {
      const Decision d = Mpc(in.setup, options(MpcMethod::kStripDp, horizon)).decide({in.height, 4, 0, 0.0});
      CHECK(d.objective_mm <= last + 1e-9);
      last = d.objective_mm;
    }
    strips += last;
    greedy += Mpc(in.setup, options(MpcMethod::kGreedy, 3)).decide({in.height, 4, 0, 0.0}).objective_mm;
  }
  CHECK(strips < 0.9 * greedy);
}

TEST_CASE(
    "A decision over several layers depends on seed, layer and attempt alone, and its value is the model's") {
  const StripInstance in = deep_instance(5, 13, 12, 2.0);
  Mpc fresh(in.setup, options(MpcMethod::kStripDp, 2)), used(in.setup, options(MpcMethod::kStripDp, 2));
  const StripInstance other = deep_instance(6, 13, 12, 3.0);
  used.decide({other.height, 1, 0, 0.0});
  const Decision a = fresh.decide({in.height, 7, 1, 0.0}), b = used.decide({in.height, 7, 1, 0.0});
  CHECK(a.drops == b.drops);
  CHECK(a.iterations == b.iterations);
  mpc::HorizonObjective objective(in.setup, 2, 1);
  objective.set_surface(in.height, 1.0);
  objective.set_plan(std::vector<DropletPattern>(2, DropletPattern(in.setup.grid)));
  RandomStream random(1, Purpose::kGreedySearch);
  mpc::anneal(objective, objective.part_cells(), {2, 20, 1e-3, 1e-5, 1'000'000}, random);
  CHECK(objective.value_mm() == Approx(by_model_mm(in, plan_of(objective), 1.0)).margin(1e-13));
}

TEST_CASE("Annealing stops at its bound of evaluations") {
  const StripInstance in = deep_instance(9, 13, 12, 2.0);
  mpc::HorizonObjective objective(in.setup, 2, 1);
  objective.set_surface(in.height, 1.0);
  objective.set_plan(std::vector<DropletPattern>(2, DropletPattern(in.setup.grid)));
  RandomStream random(1, Purpose::kGreedySearch);
  CHECK(mpc::anneal(objective, objective.part_cells(), {2, 1000, 1e-3, 1e-5, 777}, random).evaluations ==
        777);
}

TEST_CASE(
    "The single-precision field anneals to plans whose heights are the model's, with one ink and two, either "
    "border") {
  for (std::uint64_t seed = 1; seed <= 18; ++seed) {
    const int horizon = 1 + int(seed % 3);
    StripInstance in = deep_instance(seed, 11, 9, double(horizon), seed % 2);
    const std::vector<MaterialMap> materials(std::size_t(horizon), in.materials);
    RandomStream random(seed, Purpose::kTest);
    mpc::HorizonObjective objective(in.setup, horizon, 1);
    const double alpha = seed % 5 ? 1.0 : 0.5;
    objective.set_surface(in.height, alpha, materials);
    objective.set_plan(std::vector<DropletPattern>(std::size_t(horizon), random_drops(in, random)));
    mpc::HorizonState field(in.setup, in.height, materials, horizon);
    field.set_plan(plan_of(objective));
    for (const int sweeps : {1, 7}) {
      mpc::anneal(field, objective.cost(), objective.part_cells(), {horizon, sweeps, 1e-3, 1e-4, 1'000'000},
                  random);
      const auto plan = field.plan(in.setup.grid);
      for (const auto& layer : plan)
        for (std::size_t c = 0; c < layer.size(); ++c) REQUIRE((in.setup.mask.cells[c] || !layer.cells[c]));
      double sum = 0.0;
      for (const float e : field.error_mm) sum += std::abs(double(e));
      CHECK(sum / field.cells == Approx(by_model_mm(in, plan, 1.0)).margin(2e-8));
    }
    for (int n = 0; n < 200; ++n) {  // droplet by droplet, without a refresh
      const int layer = int(random.below(std::uint32_t(horizon)));
      const auto cells = objective.part_cells();
      const std::size_t p = field.at(cells[random.below(std::uint32_t(cells.size()))]);
      mpc::Flip flip;
      mpc::ObjectiveDeltas sums;
      mpc::make_flip(field, layer, p, flip);
      mpc::sums_of(field, layer, p, flip, sums);
      const auto total = [&] {
        double sum = 0.0;
        for (const float e : field.error_mm) sum += std::abs(double(e));
        return sum;
      };
      const double before = total();
      mpc::keep_flip(field, layer, p, flip, sums);
      CHECK(std::abs(total() - before - sums.abs_error_mm) < 1e-7);
    }
    const std::vector<float> kept = field.error_mm;
    field.refresh();
    for (std::size_t n = 0; n < kept.size(); ++n) REQUIRE(std::abs(kept[n] - field.error_mm[n]) < 5e-6f);
  }
}

TEST_CASE(
    "Squares: the objective is the root of the mean square with each droplet's price and the mean's weight, "
    "move by move and in the field") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const int horizon = 1 + int(seed % 3);
    const StripInstance in = deep_instance(seed, 9, 8, double(horizon));
    const double alpha = seed % 2 ? 1.0 : 0.7, price_mm2 = 2e-7 * double(seed % 4),
                 weight = 2.0 * double(seed % 3);
    mpc::HorizonObjective objective(in.setup, horizon, 1, ErrorKind::kSquare, price_mm2, weight);
    objective.set_surface(in.height, alpha);
    RandomStream random(seed, Purpose::kTest);
    objective.set_plan(std::vector<DropletPattern>(std::size_t(horizon), random_drops(in, random)));
    const auto cells = objective.part_cells();
    const auto expected_mm = [&] {
      Predictor predict(in.setup);
      HeightMap h = in.height;
      double droplets = 0.0, squares = 0.0, sum = 0.0;
      for (const DropletPattern& u : plan_of(objective)) {
        h = predict.after(h, u);
        droplets += double(u.total());
      }
      for (const std::uint32_t c : cells) {
        const double e = h.cells[c] - in.setup.target.cells[c];
        squares += e * e;
        sum += e;
      }
      const double mean = sum / double(cells.size());
      return alpha *
                 std::sqrt((squares + price_mm2 * droplets) / double(cells.size()) + weight * mean * mean) +
             (1.0 - alpha) * objective_mm(h, in.setup.target, in.setup.mask, 1e-300);
    };
    for (int n = 0; n < 30; ++n) {
      const int layer = int(random.below(std::uint32_t(horizon)));
      const std::uint32_t cell = cells[random.below(std::uint32_t(cells.size()))];
      const mpc::Move move{layer, cell, objective.layer(layer).cells[cell] ? -1 : 1};
      const double before = objective.value_mm(), gain = objective.gain_mm(move);
      objective.apply(move);
      CHECK(objective.value_mm() == Approx(before + gain).margin(1e-13));
      CHECK(objective.value_mm() == Approx(expected_mm()).margin(1e-12));
    }
    const double before = objective.value_mm();
    mpc::HorizonState field(in.setup, in.height, {}, horizon);
    field.set_plan(plan_of(objective));
    mpc::anneal(field, objective.cost(), cells, {horizon, 60, 3e-4, 1e-5, 1'000'000}, random);
    objective.set_plan(field.plan(in.setup.grid));
    CHECK(objective.value_mm() < before);
    ControlOptions o = options(MpcMethod::kStripDp, horizon, alpha);
    o.mpc.error = ErrorKind::kSquare;
    o.mpc.price_mm2 = price_mm2;
    o.mpc.mean_weight = weight;
    const Decision d = Mpc(in.setup, o).decide({in.height, 1, 0, 0.0});
    CHECK(d.objective_mm <= objective.value_mm() * 1.05);
    CHECK(d.objective_mm <= d.objective_none_mm);
  }
}

TEST_CASE("The mean's weight brings the mean of what MPC plans nearer to zero, and costs squares") {
  double with_mm = 0.0, without_mm = 0.0, more_mm2 = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const StripInstance in = deep_instance(seed, 12, 11, 1.0);
    double square_mm2[2] = {}, mean_mm[2] = {};
    for (const int weighted : {0, 1}) {
      ControlOptions o = options(MpcMethod::kStripDp, 1);
      o.mpc.error = ErrorKind::kSquare;
      o.mpc.mean_weight = 4.0 * weighted;
      const Decision d = Mpc(in.setup, o).decide({in.height, 1, 0, 0.0});
      const HeightMap after = Predictor(in.setup).after(in.height, d.drops);
      const ErrorStats e = error_stats(after, in.setup.target, in.setup.mask);
      mean_mm[weighted] = e.mean_mm;
      square_mm2[weighted] = e.rms_mm * e.rms_mm;
      CHECK(d.objective_mm <= d.objective_none_mm);
    }
    without_mm += std::abs(mean_mm[0]);
    with_mm += std::abs(mean_mm[1]);
    more_mm2 += square_mm2[1] - square_mm2[0];
  }
  INFO(with_mm << " instead of " << without_mm << ", squares " << more_mm2 << " more");
  CHECK(with_mm < 0.7 * without_mm);
}

TEST_CASE("A mean weight below 0 is refused by name") {
  const StripInstance in = deep_instance(1, 5, 5, 1.0);
  ControlOptions o = options(MpcMethod::kStripDp, 2);
  o.mpc.mean_weight = -1.0;
  CHECK_THROWS_WITH(Mpc(in.setup, o), Catch::Contains("mean_weight"));
}
