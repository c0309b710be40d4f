// Computes [Lu 2015, IV-C, V-C, Table I]: exact recovery, the identification prints, the spacing.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/control/mpc/greedy.h"
#include "core/control/mpc/objective.h"
#include "core/grid/random.h"
#include "runtime/source_folder.h"
#include "studies/identify/identification_study.h"
#include "studies/identify/identify.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

constexpr double kPaper_um[] = {4.4, 0.6, 0.2};
constexpr double kGamma = 0.6268, kDiameter_mm = 0.420;
constexpr double kGammaBound = 0.01;  // the paper gives gamma as 0.6268, 0.63 and 63 %
// Nature without chance, but for the places of droplets: the quantities that the identification prints
// measure.
const std::vector<std::string> kNoChance = {"plant.sensor_noise_mm=0", "plant.size_std=0",
                                            "plant.missed_fraction=0", "plant.satellite_fraction=0",
                                            "plant.drift=0",           "plant.dropout_fraction=0"};

std::string experiment(const char* name) { return (source_folder() / "experiments" / name).string(); }

int exactly_recovered() {
  const GridSpec g{20, 20};
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    HeightMap h(g);
    DropletPattern u(g);
    const double roughness_mm = 0.05 * double(seed) / 50.0;
    for (std::size_t c = 0; c < g.size(); ++c) {
      h.cells[c] = random.uniform(0.0, roughness_mm);
      u.cells[c] = std::uint8_t(random.below(2));
    }
    HeightMap made = h;
    deposition::HeightChange<1>(g, deposition::stencil_of({}), deposition::Border::kLose).deposit(made, u);
    control::Setup setup{g, made, Mask(g, 1), {}, deposition::Border::kLose, seed};
    control::mpc::HorizonObjective objective(setup, 1, 1);
    RandomStream search(seed, Purpose::kGreedySearch);
    objective.set_surface(h, 1.0);
    objective.set_plan(std::vector<DropletPattern>(1, DropletPattern(g, 1)));
    control::mpc::greedy_search(objective, {16, 1'000'000}, search);
    found += objective.layer(0) == u;
  }
  return found;
}

// The prints of V-C on Firn's own plant, beside the same prints without chance.
void prints_of(Reproduction& to) {
  const std::vector<std::string> noisy{"plant.model=droplets"};
  std::vector<std::string> exact = noisy;
  exact.insert(exact.end(), kNoChance.begin(), kNoChance.end());
  const Identification ours = identify(observe_print(experiment("identification.toml"), noisy));
  const Identification truth = identify(observe_print(experiment("identification.toml"), exact));
  const auto& p = ours.prints;
  const auto& t = truth.prints;
  constexpr const char* kFitted =
      "cap radius, film radius and film share of the plant's droplet, to Table I (docs/plant.md)";
  constexpr const char* kMerge =
      "the authors cured each droplet at once; ours of a site are laid in one pass, and Firn's liquid "
      "droplets that "
      "touch merge and level, unlike (2)";
  const struct {
    const char* name;
    const char* what;
    const droplet::Repeats &ours, &truth;
    double paper_um;
    const char *place, *quote, *miss;
  } rows[] = {
      {"h1", "V-C 1) single droplet, height of the centre", p.h1, t.h1, kPaper_um[0], "p. 1066, V-C 1)",
       "height change h_1 is found to be $4.4 \\mu\\text{m}$",
       "the paper's h1 is a droplet's peak, and the plant's cell mean was fitted to it: its peak is 4.68 um"},
      {"h2", "V-C 2) four side neighbours, rise of the centre / 4", p.h2, t.h2, kPaper_um[1],
       "p. 1066, V-C 2)", "Thus, $h_2 = 0.6 \\mu\\text{m}$", kMerge},
      {"h3", "V-C 3) one corner neighbour, rise of the centre", p.h3, t.h3, kPaper_um[2], "p. 1066, V-C 3)",
       "height change parameter h_3 is found to be $0.2 \\mu\\text{m}$", kMerge}};
  for (const auto& r : rows)
    to.row(ReproduceRow(
               std::string("lu.identification.droplets-") + r.name,
               fmt::format("{} (n = {}; without chance {:.3f} um)", r.what, r.ours.n, r.truth.mean_mm * 1e3),
               "um", r.ours.mean_mm * 1e3, 3)
               .prints(r.paper_um, r.place, r.quote)
               .within(r.ours.half_width_mm * 1e3)
               .fitted(kFitted)
               .not_reproduced(r.miss));
  const auto around = [&](const char* name, const char* what, const droplet::Repeats& r) {
    to.beside({std::string("lu.identification.droplets-") + name,
               fmt::format("{} a single droplet (+- {:.3f} um); the plant was fitted to it", what,
                           r.half_width_mm * 1e3),
               "um", r.mean_mm * 1e3, 3});
  };
  around("side", "Table I, h2 = 0.6 um: rise beside", p.side);
  around("corner", "Table I, h3 = 0.2 um: rise at the corner of", p.corner);
  to.picture(
      {"lu-identification-droplets",
       "Identification prints [Lu 2015, V-C] on the plant \"droplets\": mean rise about each kind of site, "
       "and h1, h2, h3 with 95 % intervals",
       identification_svg(ours)});
}

void spacing(Reproduction& to) {
  std::vector<double> gammas = {0.45, 0.5, 0.55, 0.6, kGamma, 0.66, 0.7, 0.8, 0.9};
  if (to.quick()) gammas = {0.45, kGamma, 0.9};
  std::vector<droplet::SpacingResult> results(gammas.size());
  run_jobs(int(gammas.size()), to.threads(), [&](int n) {
    const double pitch = 0.5 * gammas[std::size_t(n)] * kDiameter_mm, width = 118 * pitch,
                 depth = 178 * pitch;
    std::vector<std::string> o = {
        fmt::format("grid.pitch_x_mm={}", pitch), fmt::format("grid.pitch_y_mm={}", pitch),
        fmt::format("part.width_mm={}", width), fmt::format("part.depth_mm={}", depth)};
    results[std::size_t(n)] = spacing_of(observe_print(experiment("spacing.toml"), o), kDiameter_mm);
  });
  const droplet::SpacingChoice choice = droplet::choose_spacing(results);
  to.row(
      ReproduceRow(
          "lu.identification.gamma",
          fmt::format("(1), V-C: gamma with the most consistent height of n x n squares, n = 2..6 (+- "
                      "{:.3f})",
                      choice.std_error),
          "", choice.gamma, 4)
          .prints(kGamma, "p. 1066, Table I", "Droplet spacing ratio (\u03b3) 0.6268")
          .within(kGammaBound)
          .not_reproduced("gamma depends on how far the liquid ink spreads, which the paper does not print; "
                          "Firn's droplets were not fitted to it"));
  to.picture({"lu-spacing",
              fmt::format("Height of n x n squares on the independent plant by spacing: between sizes and "
                          "within; least at gamma = {:.3f}",
                          choice.gamma),
              spacing_svg(results, choice)});
}

}  // namespace

void reproduce_lu_identification(Reproduction& to) {
  to.note(
      "Identification prints as in V-C, all droplets of a site in one pass: by (4), droplets that are cured "
      "one by one, the "
      "neighbours after the centre, would add only sat(h2 - h1) of h2 to it. \"Without chance\" is the same "
      "print with size, "
      "missed, satellite, drift and sensor noise switched off.");
  to.row(ReproduceRow("lu.identification.recovery",
                      "IV-C: exact solution found, 20 x 20, 50 random surfaces and patterns", "of 50",
                      double(exactly_recovered()), 0)
             .prints(50.0, "p. 1063, IV-C",
                     "our algorithm is able to reach the exact solution for all the 50 different (random) "
                     "combinations")
             .within(0));
  to.progress(0.02, "identification prints");
  prints_of(to);
  to.progress(0.8, "spacing");
  spacing(to);
}

}  // namespace firn
