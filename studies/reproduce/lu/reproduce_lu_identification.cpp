// Computes [Lu 2015, IV-C, V-C, Table I]: exact recovery, the identification prints, the identification
// during printing, the spacing.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/control/mpc/greedy.h"
#include "core/control/mpc/objective.h"
#include "core/grid/random.h"
#include "studies/identify/identification_study.h"
#include "studies/identify/identify.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

constexpr const char* kExperiments = FIRN_SOURCE_DIR "/experiments/";
constexpr double kPaper_um[] = {4.4, 0.6, 0.2};
constexpr double kGamma = 0.6268, kDiameter_mm = 0.420;
// Nature without chance, but for the places of droplets: the quantities that the identification prints
// measure.
const std::vector<std::string> kNoChance = {"plant.sensor_noise_mm=0", "plant.size_std=0",
                                            "plant.missed_fraction=0", "plant.satellite_fraction=0",
                                            "plant.drift=0",           "plant.dropout_fraction=0"};

std::string experiment(const char* name) { return std::string(kExperiments) + name; }

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

std::string interval(double mean_mm, double half_mm) {
  return fmt::format("{:.3f} +- {:.3f} um", mean_mm * 1e3, half_mm * 1e3);
}

// The prints of V-C on a plant, beside the same prints without chance.
void prints_of(Reproduction& to, const char* id, const char* plant, const std::vector<std::string>& overrides,
               bool paper_values) {
  std::vector<std::string> noisy = overrides, exact = overrides;
  noisy.push_back(std::string("plant.model=") + plant);
  exact = noisy;
  exact.insert(exact.end(), kNoChance.begin(), kNoChance.end());
  const Identification ours = identify(observe_print(experiment("identification.toml"), noisy));
  const Identification truth = identify(observe_print(experiment("identification.toml"), exact));
  const auto& p = ours.prints;
  const auto& t = truth.prints;
  const struct {
    const char* name;
    const char* what;
    const droplet::Repeats &ours, &truth;
    double paper_um;
  } rows[] = {{"h1", "V-C 1) single droplet, height of the centre", p.h1, t.h1, kPaper_um[0]},
              {"h2", "V-C 2) four side neighbours, rise of the centre / 4", p.h2, t.h2, kPaper_um[1]},
              {"h3", "V-C 3) one corner neighbour, rise of the centre", p.h3, t.h3, kPaper_um[2]},
              {"side", "beside a single droplet", p.side, t.side, kPaper_um[1]},
              {"corner", "at the corner of a single droplet", p.corner, t.corner, kPaper_um[2]}};
  for (const auto& r : rows) {
    const std::string row = std::string("lu.identification.") + id + "-" + r.name;
    // Five intervals of 95 % a plant: four half widths are beyond chance.
    to.row(row_holds(
        row, fmt::format("{} (n = {}; without chance {:.3f} um)", r.what, r.ours.n, r.truth.mean_mm * 1e3),
        fmt::format("{:.1f} um", r.paper_um), interval(r.ours.mean_mm, r.ours.half_width_mm),
        std::abs(r.ours.mean_mm - r.truth.mean_mm) <= 1.5 * r.ours.half_width_mm + 1e-6, RowKind::kProperty));
  }
  if (paper_values)
    for (int n = 0; n < 3; ++n) {
      const Known& k = n == 0 ? ours.h1 : n == 1 ? ours.h2 : ours.h3;
      to.row(row_near(fmt::format("lu.identification.{}-fit-h{}", id, n + 1),
                      fmt::format("Table I, h{}: (3)-(5) fitted to the same prints", n + 1), "um",
                      kPaper_um[n], k.mean_mm * 1e3, n == 0 ? 0.05 : 0.03));
    }
  to.picture({fmt::format("lu-identification-{}", id),
              fmt::format("Identification prints [Lu 2015, V-C] on the plant \"{}\": mean rise about each "
                          "kind of site, and h1, h2, h3 with 95 % intervals",
                          plant),
              identification_svg(ours)});
}

void learned_while_printing(Reproduction& to) {
  const int seeds = to.quick() ? 6 : 200;
  std::vector<PlantedTrial> trials(static_cast<std::size_t>(seeds));
  int done = 0;
  std::mutex lock;
  run_jobs(seeds, to.threads(), [&](int n) {
    trials[std::size_t(n)] = planted_trial(experiment("excitation.toml"), std::uint64_t(n + 1), 0.2);
    const std::lock_guard hold(lock);
    to.progress(0.15 + 0.6 * ++done / seeds, "half-filled layers");
  });
  const PlantedTotals t = totals_of(trials);
  const std::string what = fmt::format(
      "lu2015 plant, 20 % variation, 1 um noise, 10 random half-filled layers, {} seeds: ", seeds);
  to.row(row_at_most("lu.identification.online-h1", what + "worst error of h1", "%", std::string(),
                     100 * t.worst_error[0], 3.0, RowKind::kProperty));
  to.row(row_at_most("lu.identification.online-layer", what + "worst error of h1 + 4 h2 + 4 h3", "%",
                     std::string(), 100 * t.worst_error[3], 3.0, RowKind::kProperty));
  // 200 seeds x 4: two beyond three sigma are expected of right intervals.
  int beyond = 0;
  for (const int within : t.within_3_sigma) beyond += t.trials - within;
  to.row(row_at_most("lu.identification.online-3-sigma",
                     what + "errors beyond 3 of the reported sigma, of all four quantities", "",
                     std::string(), beyond, std::max(1.0, std::floor(0.01 * 4 * seeds)), RowKind::kProperty));
  for (const int n : {0, 3}) {
    const double share = 100.0 * t.covered[n] / t.trials;
    const bool holds = to.quick() ? t.covered[n] >= seeds - 2 : share >= 90.0 && share <= 98.0;
    to.row(
        row_holds(fmt::format("lu.identification.online-cover-{}", n == 0 ? "h1" : "layer"),
                  what + (n == 0 ? "95 % intervals of h1 cover" : "95 % intervals of h1 + 4 h2 + 4 h3 cover"),
                  "", fmt::format("{:.1f} %", share), holds));
  }
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
  to.row(row_informative("lu.identification.gamma",
                         fmt::format("(1), V-C: gamma with the most consistent height of n x n squares, n = "
                                     "2..6 (independent plant, +- {:.3f})",
                                     choice.std_error),
                         "", 0.6268, choice.gamma));
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
      "missed, satellite, drift and sensor noise switched off: the mean response that the intervals have to "
      "cover.");
  to.row(row_near("lu.identification.recovery",
                  "IV-C: exact solution found, 20 x 20, 50 random surfaces and patterns", "of 50", 50,
                  exactly_recovered(), 0));
  to.row(row_near("lu.identification.spacing", "Table I: gamma d", "um", 263.256, kGamma * kDiameter_mm * 1e3,
                  0.001));
  to.row(row_near("lu.identification.side", "V-D.2: 8 spacings", "um", 2106.0,
                  8 * kGamma * kDiameter_mm * 1e3, 0.1));
  to.progress(0.02, "identification prints");
  prints_of(to, "lu2015", "lu2015", {"plant.variation=0"}, true);
  prints_of(to, "droplets", "droplets", {}, false);
  learned_while_printing(to);
  to.progress(0.8, "spacing");
  spacing(to);
}

}  // namespace firn
