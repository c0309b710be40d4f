#include "studies/identify/identify.h"
#include "cli/identify_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "core/grid/random.h"
#include "files/usage_error.h"
#include "plant/inkjet/field.h"
#include "studies/identify/identify_places.h"
#include "studies/identify/identify_runs.h"
#include "tests/support/planted_trial.h"

using namespace firn;

namespace {

const std::string kExperiments = std::string(FIRN_SOURCE_DIR) + "/experiments/";

// Smaller than shipped, for a test.
Identification prints(const std::vector<std::string>& more, const char* file = "identification.toml") {
  std::vector<std::string> o = {"grid.ny=90", "part.depth_mm=23.5", "control.pattern.layers=2"};
  o.insert(o.end(), more.begin(), more.end());
  return identify(observe_print(kExperiments + file, o));
}

}  // namespace

TEST_CASE("V-C, Table I: identification prints of the paper's own plant give 4.4, 0.6 and 0.2 um") {
  const Identification id = prints({"plant.model=lu2015", "plant.variation=0"});
  CHECK(id.uninformative.empty());
  REQUIRE(id.prints.complete());
  CHECK(id.prints.single.size() >= 25);
  CHECK(std::abs(id.prints.h1.mean_mm - 0.0044) < 1.5 * id.prints.h1.half_width_mm);
  CHECK(std::abs(id.prints.h2.mean_mm - 0.0006) < 1.5 * id.prints.h2.half_width_mm);
  CHECK(std::abs(id.prints.h3.mean_mm - 0.0002) < 1.5 * id.prints.h3.half_width_mm);
  CHECK(id.prints.h1.half_width_mm < 0.0002);
  CHECK(id.h1.mean_mm == Approx(0.0044).epsilon(0.02));
  CHECK(id.h2.mean_mm == Approx(0.0006).epsilon(0.05));
  CHECK(id.h3.mean_mm == Approx(0.0002).epsilon(0.15));
  const std::string svg = identification_svg(id);
  CHECK(svg.starts_with("<svg"));
  CHECK(svg.ends_with("</svg>"));
}

TEST_CASE("V-C: a side droplet beside a cured centre gives it what (4) says, less than h2") {
  const Identification id = prints({"plant.model=lu2015", "plant.variation=0"}, "identification-cured.toml");
  REQUIRE(id.prints.complete());
  CHECK(id.prints.single.size() >= 25);
  constexpr double kH1 = 0.0044, kH2 = 0.0006, kH3 = 0.0002;
  double centre = kH1;
  // The ground of the last two has its share of the first two, which lie at its corners.
  for (const double side : {kH2, kH2, kH2 + 2 * kH3, kH2 + 2 * kH3})
    centre += kH2 * (1.0 - (centre - side) / (kH1 + kH2));
  CHECK((centre - kH1) / 4 == Approx(0.00014).epsilon(0.02));
  CHECK(std::abs(id.prints.h1.mean_mm - kH1) < 1.5 * id.prints.h1.half_width_mm);
  CHECK(std::abs(id.prints.h2.mean_mm - (centre - kH1) / 4) < 1.5 * id.prints.h2.half_width_mm);
  CHECK(id.prints.h2.half_width_mm < 0.0001);
  CHECK(std::abs(id.prints.h3.mean_mm - kH3) <
        1.5 * id.prints.h3.half_width_mm);  // mean of both: no ink is lost
}

TEST_CASE("Rows of single droplets give the heights of each place: those of the plant's own droplet there") {
  const ObservedRun run = observe_print(
      kExperiments + "places.toml",
      {"grid.ny=180", "part.depth_mm=47.3", "actuation.positions_x=2", "actuation.positions_y=4",
       "control.pattern.layers=2", "plant.drift=0", "plant.missed_fraction=0", "plant.satellite_fraction=0"});
  for (const OffsetKind kind : {OffsetKind::kGrid, OffsetKind::kX}) {
    const PlaceIdentification id = identify_places(run, kind);
    INFO(id.uninformative);
    REQUIRE(id.uninformative.empty());
    REQUIRE(id.table.size() == (kind == OffsetKind::kX ? 3 : 9));
    const GridSpec g{9, 9, run.experiment().grid.pitch_x_mm, run.experiment().grid.pitch_y_mm, 0.0, 0.0};
    for (int n = 1; n < id.table.size(); ++n) {
      const plant::DropletParams p;
      plant::Field ground(g, p.fine_cells, p.margin_cells);
      ground.land(p, p.volume_mm3, g.x_mm(4) + id.table[n].x * g.pitch_x_mm,
                  g.y_mm(4) + id.table[n].y * g.pitch_y_mm);
      ground.cure(p.cure_shrink);
      const HeightMap truth = ground.cell_means();
      double worst = 0.0, worst_mixed = 0.0;
      const auto mixed = deposition::mixed_kernel({4.35e-3, 0.60e-3, 0.20e-3}, id.table[n]);  // docs/plant.md
      for (int dy = -2; dy <= 2; ++dy)
        for (int dx = -2; dx <= 2; ++dx) {
          const double true_mm = truth.at(4 + dx, 4 + dy);
          worst = std::max(worst, std::abs(id.prints.kernels[std::size_t(n)].at(dx, dy) - true_mm) / 7.6e-3);
          worst_mixed = std::max(worst_mixed, std::abs(mixed.at(dx, dy) - true_mm) / 7.6e-3);
        }
      CAPTURE(n, id.table[n].x, id.table[n].y, worst, worst_mixed);
      CHECK(worst < 0.04);
    }
    const Experiment e = parse_experiment(places_toml(id), "lab.toml");
    CHECK(e.actuation.heights_mm.size() == std::size_t(id.table.size() - 1) * 25);
    CHECK(e.actuation.offsets == kind);
    CHECK(e.actuation.heights_mm[12] == Approx(id.prints.kernels[1].at(0, 0)).margin(1e-7));
  }
}

TEST_CASE("Rows of droplets of two sizes give the heights of both, and the share of the small ones") {
  const ObservedRun run =
      observe_print(kExperiments + "places.toml",
                    {"grid.ny=240", "part.depth_mm=63", "actuation.positions_x=2", "actuation.positions_y=4",
                     "actuation.small_share=0.6", "plant.camera.threshold_v=8", "control.pattern.layers=2",
                     "plant.drift=0", "plant.missed_fraction=0", "plant.satellite_fraction=0"});
  const PlaceIdentification id = identify_places(run);
  INFO(id.uninformative);
  REQUIRE(id.uninformative.empty());
  REQUIRE(id.table.size() == 18);
  CHECK(id.prints.small_drop_height_mm / id.prints.drop_height_mm ==
        Approx(0.5).margin(0.03));  // 14 V of 20 V
  const Experiment e = parse_experiment(places_toml(id), "lab.toml");
  CHECK(e.actuation.heights_mm.size() == 17 * 25);
  CHECK(e.actuation.small_share == Approx(0.5).margin(0.03));
  const plant::DropletParams p;
  const GridSpec g{9, 9, run.experiment().grid.pitch_x_mm, run.experiment().grid.pitch_y_mm, 0.0, 0.0};
  for (int n = id.table.places(); n < id.table.size(); ++n) {
    plant::DropletParams small = p;
    small.cap_radius_mm *= std::cbrt(0.5);
    small.film_radius_mm *= std::cbrt(0.5);
    plant::Field ground(g, p.fine_cells, p.margin_cells);
    ground.land(small, 0.5 * p.volume_mm3, g.x_mm(4) + id.table[n].x * g.pitch_x_mm,
                g.y_mm(4) + id.table[n].y * g.pitch_y_mm);
    ground.cure(p.cure_shrink);
    const HeightMap truth = ground.cell_means();
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        CAPTURE(n, dx, dy);
        CHECK(std::abs(id.prints.kernels[std::size_t(n)].at(dx, dy) - truth.at(4 + dx, 4 + dy)) <
              0.06 * 7.6e-3);
      }
  }
}

TEST_CASE("Droplets at too few heights in a row of cells tell no kernel, and why") {
  const PlaceIdentification id = identify_places(
      observe_print(kExperiments + "places.toml", {"grid.ny=60", "part.depth_mm=15.7", "actuation.offsets=x",
                                                   "actuation.positions_x=2", "control.pattern.layers=1"}));
  CHECK_THAT(id.uninformative, Catch::Contains("one line along each row of cells"));
}

TEST_CASE("A print without places tells none of them") {
  const PlaceIdentification id =
      identify_places(observe_print(kExperiments + "identification.toml",
                                    {"grid.ny=90", "part.depth_mm=23.5", "control.pattern.layers=1"}));
  CHECK_THAT(id.uninformative, Catch::Contains("actuation.offsets is none"));
}

TEST_CASE("The nearest kernel is nowhere negative, has the wanted height, and none of the same is nearer") {
  RandomStream random(4, Purpose::kTest);
  for (int trial = 0; trial < 30; ++trial) {
    deposition::OffsetKernel rise;
    for (double& h : rise.height_mm) h = random.uniform(-1e-3, 2e-3);
    const double height_mm = random.uniform(2e-3, 2e-2);
    const deposition::OffsetKernel k = droplet::nearest_kernel(rise, height_mm);
    const auto squares = [&](const deposition::OffsetKernel& of) {
      double sum = 0.0;
      for (std::size_t n = 0; n < 25; ++n) sum += std::pow(of.height_mm[n] - rise.height_mm[n], 2);
      return sum;
    };
    CHECK(k.drop_height_mm() == Approx(height_mm).epsilon(1e-12));
    for (const double h : k.height_mm) CHECK(h >= 0.0);
    for (int other = 0; other < 50; ++other) {  // some height moved from one cell to another
      deposition::OffsetKernel moved = k;
      double& from = moved.height_mm[random.below(25)];
      const double by = from * random.uniform();
      from -= by;
      moved.height_mm[random.below(25)] += by;
      CHECK(squares(moved) >= squares(k) - 1e-18);
    }
  }
}

TEST_CASE("Half-filled layers identify planted values, and they believe what they see, not model.h1_mm") {
  const PlantedTrial t = planted_trial(kExperiments + "excitation.toml", 5, 0.2);
  for (int n = 0; n < 4; ++n) {
    CHECK(std::abs(t.z(n)) < 4.0);
    CHECK(std::abs(t.error(n)) < 0.05);
  }
  CHECK(std::abs(t.error(0)) < 0.03);
  CHECK(std::abs(t.error(3)) < 0.03);
}

TEST_CASE("A run of full layers is refused with what it does tell") {
  const Identification id = identify(observe_print(
      kExperiments + "cuboid.toml", {"plant.model=lu2015", "control.scheme=open_loop",
                                     "control.open_loop.layers=3", "part.width_mm=10", "part.depth_mm=10"}));
  CHECK(id.uninformative.find("h1 + 4 h2 + 4 h3") != std::string::npos);
  CHECK(id.layer_height.mean_mm == Approx(1.1 * 0.0076).epsilon(0.03));
}

TEST_CASE(
    "A long run of layers that are much alike is refused before anything is fitted, a short one after it") {
  const std::vector<std::string> usual = {
      "control.scheme=smf", "part.width_mm=3",        "part.depth_mm=3",        "grid.nx=14",
      "grid.ny=14",         "control.max_layers=400", "process.nozzle_gap_mm=2"};
  const auto of_height = [&](const char* mm) {
    std::vector<std::string> overrides = usual;
    overrides.push_back(std::string("part.height_mm=") + mm);
    return identify(observe_print(kExperiments + "cuboid.toml", overrides));
  };
  const Identification tall = of_height("0.8");
  CHECK(tall.layers > 80);
  CHECK_THAT(tall.uninformative, Catch::Contains("too much alike") && Catch::Contains("h1 + 4 h2 + 4 h3 = "));
  CHECK(tall.fit.evaluations == 0);
  CHECK(tall.layer_height.mean_mm == Approx(0.0076).epsilon(0.1));
  const Identification low = of_height("0.2");
  CHECK(low.fit.evaluations > 0);
  CHECK_THAT(low.uninformative, Catch::Contains("too much alike"));
}

TEST_CASE("What a look at some layers finds of a long run is near what its fit finds") {
  const ObservedRun run = observe_print(kExperiments + "excitation.toml",
                                        {"control.pattern.layers=82", "grid.nx=11", "grid.ny=11",
                                         "part.width_mm=2.2", "part.depth_mm=2.2", "control.max_layers=400"});
  const std::optional<double> glance = run.glance_excitation();
  REQUIRE(glance);
  const double fitted = run.learn().all.excitation;
  CAPTURE(*glance, fitted, run.layers());
  CHECK(*glance > fitted / 3);
  CHECK(*glance < 3 * fitted);
  CHECK(identify(run).fit.evaluations > 0);
}

TEST_CASE(
    "Intervals by leaving one run out hold what differs from run to run, and those of all beads do not") {
  // Each run has a wire of its own: its heights are higher or lower by some percent, all layers alike.
  constexpr double kA = -0.46, kB = 1.65;
  int held = 0, held_by_all = 0;
  constexpr int kTrials = 60;
  for (std::uint64_t trial = 1; trial <= kTrials; ++trial) {
    RandomStream random(trial, Purpose::kTest);
    std::vector<std::vector<bead::Bead>> runs(5);
    std::vector<bead::Bead> all;
    int layer_of_all = 0;
    for (auto& run : runs) {
      const double wire = 0.1 * random.normal();
      for (int layer = 1; layer <= 6; ++layer, ++layer_of_all)
        for (std::uint32_t segment = 0; segment < 12; ++segment) {
          const double v = random.uniform(4.0, 15.0);
          run.push_back({layer, segment, v, std::exp(kA * std::log(v) + kB + wire + 0.05 * random.normal())});
          all.push_back(run.back());
          all.back().layer = layer_of_all;
        }
    }
    const PooledIdentification p = pool(runs, std::vector<std::string>(5, "run"));
    REQUIRE(p.uninformative.empty());
    REQUIRE(p.constants.size() == 2);
    CHECK(p.constants[0].value == Approx(bead::fit_bead_law(all).law.a));
    held += std::abs(p.constants[1].value - kB) <= p.constants[1].half_width;
    const bead::BeadFit fit = bead::fit_bead_law(all);
    held_by_all += std::abs(fit.law.b - kB) <= fit.b_half_width;
  }
  CHECK(held >= 0.88 * kTrials);
  CHECK(held_by_all < held);
}

TEST_CASE("Constants of several runs are their means, with the interval of a mean over runs") {
  std::vector<Identification> runs(3);
  for (const std::size_t n : {0u, 1u, 2u}) {
    runs[n].h1.mean_mm = 0.0044 + 0.0001 * double(n);
    runs[n].h2.mean_mm = 0.0006;
  }
  runs[1].not_found[2] = "at its prior";
  const PooledIdentification p = pool(runs, {"a", "b", "c"});
  CHECK(p.constants[0].value == Approx(0.0045));
  CHECK(p.constants[0].half_width == Approx(4.302653 * 0.0001 / std::sqrt(3.0)));
  CHECK(p.constants[1].half_width == Approx(0.0).margin(1e-12));
  CHECK(p.constants[2].runs_without_it == std::vector<std::string>{"b"});
  runs[2].uninformative = "full layers";
  CHECK(pool(runs, {"a", "b", "c"}).uninformative == "c: full layers");
  CHECK_THROWS_AS(pool({runs[0]}, {"a"}), UsageError);
}

TEST_CASE("What is no run, has no squares or too few spacings is named") {
  IdentifyOptions o;
  o.runs = {"/nowhere"};
  CHECK_THROWS_AS(run_identify(o), UsageError);
  o.runs = {"/nowhere", "/nowhere"};
  CHECK_THROWS_WITH(run_identify(o), Catch::Contains("/nowhere: is no run folder"));
  o.runs = {FIRN_SOURCE_DIR "/tests/replay/golden/v1-mpc"};
  o.spacing = true;
  CHECK_THROWS_WITH(run_identify(o), Catch::Contains("squares"));
}

TEST_CASE("Squares at three spacings: too narrow piles up by size, too wide leaves ribs") {
  std::vector<droplet::SpacingResult> results;
  for (const double gamma : {0.45, 0.65, 0.95}) {
    const double pitch = 0.5 * gamma * 0.42;
    results.push_back(spacing_of(
        observe_print(
            kExperiments + "spacing.toml",
            {"grid.nx=90", "grid.ny=60", "grid.pitch_x_mm=" + std::to_string(pitch),
             "grid.pitch_y_mm=" + std::to_string(pitch), "part.width_mm=" + std::to_string(88 * pitch),
             "part.depth_mm=" + std::to_string(58 * pitch), "control.pattern.largest_square=4",
             "control.pattern.spacing_cells=7"}),
        0.42));
    CHECK(results.back().gamma == Approx(gamma).epsilon(1e-4));
    CHECK(results.back().height_mm > 0.002);
  }
  CHECK(results[0].between_sizes > results[2].between_sizes);
  CHECK(results[2].within > results[1].within);
  CHECK(spacing_svg(results, droplet::choose_spacing(results)).find("gamma") != std::string::npos);
}
