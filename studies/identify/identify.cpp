#include <fmt/core.h>

#include <optional>
#include <stdexcept>

#include "core/control/pattern.h"
#include "core/options/display_unit.h"
#include "estimators/droplet/excitation.h"
#include "files/usage_error.h"
#include "studies/identify/identify.h"

namespace firn {
namespace {

constexpr double kZ = 1.959964;
constexpr double kMinExcitation = 0.01;  // full layers give about 0.002, half-filled ones 0.05 to 0.2
// Of the droplets alone: below, no surface makes up for it, and the fit is spared.
constexpr double kMinDesign = 0.1 * kMinExcitation;
constexpr double kAtPrior = 0.5;  // of the prior's variance: more, and the prior says more than the layers

std::string shown(const Known& k) {
  const DisplayUnit unit = display_unit_for(k.mean_mm);
  return fmt::format("{:.4g} +- {:.2g} {}", k.mean_mm * unit.per_mm, k.half_width_mm * unit.per_mm,
                     unit.name);
}

std::string alike(double excitation, const Known& layer_height) {
  return fmt::format(
      "no excitation: its layers are too much alike (excitation {:.4f}, {} is needed): they tell h1 + 4 h2 + "
      "4 h3 = {}, "
      "but not h1, h2 and h3 apart; print experiments/identification.toml or experiments/excitation.toml",
      excitation, kMinExcitation, shown(layer_height));
}

// Empty, or what is ruled out before anything is fitted: by the droplets alone, or by a look at some layers.
std::string ruled_out(const ObservedRun& run, const Identification& id,
                      const std::vector<droplet::PrintedLayer>& printed, Known& layer_height) {
  if (id.droplets == 0) return "no excitation: no droplet was fired";
  const droplet::DesignExcitation design = droplet::design_excitation(printed);
  if (const std::string names = droplet::unseen_constants(design); !names.empty())
    return "no excitation of " + names + ": no measured cell has a droplet " +
           (!design.own     ? "of its own"
            : !design.sides ? "at a side"
                            : "at a corner, as in a record of one row of cells");
  double excitation = design.excitation;
  if (excitation >= kMinDesign) {
    const std::optional<double> glance = run.glance_excitation();
    if (!glance || *glance >= kMinExcitation) return "";
    excitation = *glance;
  }
  const droplet::Repeats even = droplet::layer_height_of_even_cells(printed);
  if (even.n < 2) return "";
  layer_height = {even.mean_mm, even.half_width_mm};
  return alike(excitation, layer_height);
}

// Layers in each of which whole sites were printed.
std::vector<droplet::PrintedLayer> sites_of(const Experiment& e,
                                            const std::vector<droplet::PrintedLayer>& printed) {
  const control::PatternOptions& p = e.control.pattern;
  const bool one_by_one =
      e.control.scheme == "pattern" && p.kind == control::PatternKind::kIdentification && on(p.one_by_one);
  return one_by_one ? droplet::layers_together(printed, control::kSiteDroplets) : printed;
}

std::array<std::string, 3> not_found(const droplet::Estimate& fit) {
  std::array<std::string, 3> out;
  for (std::size_t n = 0; n < 3; ++n)
    if (fit.at_bound[n])
      out[n] = "at its bound";
    else if (fit.prior_share[n] > kAtPrior)
      out[n] = "at its prior";
  return out;
}

}  // namespace

Identification identify(const ObservedRun& run) {
  Identification id;
  id.layers = run.layers();
  id.droplets = run.droplets();
  id.noise_std_mm = run.noise_std_mm();
  const std::vector<droplet::PrintedLayer> printed = run.printed();
  id.prints = droplet::find_identification_prints(sites_of(run.experiment(), printed));
  if (id.layers > 0 && !id.prints.complete()) id.uninformative = ruled_out(run, id, printed, id.layer_height);
  if (!id.uninformative.empty()) return id;
  try {
    const ObservedRun::Learned learned = run.learn();
    id.fit = learned.all;
    id.held_out = learned.held_out;
  } catch (const std::invalid_argument& error) {
    id.uninformative = error.what();
    return id;
  }
  const auto& recorded = run.experiment().model;
  id.prior_of_maps = run.prior().h1_mm != recorded.h1_mm;
  const auto& m = id.fit.model;
  id.h1 = {m.h1_mm, kZ * id.fit.std_mm(0)};
  id.h2 = {m.h2_mm, kZ * id.fit.std_mm(1)};
  id.h3 = {m.h3_mm, kZ * id.fit.std_mm(2)};
  id.layer_height = {m.layer_height_mm(), kZ * id.fit.layer_height_std_mm()};
  id.not_found = not_found(id.fit);
  if (id.prints.complete()) return id;
  if (id.fit.excitation < kMinExcitation)
    id.uninformative = alike(id.fit.excitation, id.layer_height);
  else if (!id.not_found[0].empty())
    id.uninformative = "h1 ended " + id.not_found[0] + " (" + shown(id.h1) +
                       "): the maps do not follow the droplets as the model of Lu (3)-(5) has it";
  else if (id.h1.half_width_mm > 0.5 * m.h1_mm)
    id.uninformative = "h1 is known to half of itself at best: " + shown(id.h1);
  return id;
}

droplet::SpacingResult spacing_of(const ObservedRun& run, double diameter_mm) {
  const Experiment& e = run.experiment();
  const control::PatternOptions& p = e.control.pattern;
  if (e.control.scheme != "pattern" || p.kind != control::PatternKind::kSquares)
    throw UsageError("a run of control.scheme = \"pattern\", control.pattern.kind = \"squares\" is wanted");
  const auto layers = run.printed();
  if (layers.empty()) throw UsageError("no layer was printed and measured");
  // Squares are found by their droplets: a square begins at a cell whose left and lower neighbours, a step
  // away, have no droplet.
  const droplet::PrintedLayer& l = layers.front();
  const int s = p.square_step;
  const auto fired = [&](int i, int j) { return l.fired.spec.contains(i, j) && l.fired.at(i, j) > 0; };
  std::vector<droplet::Square> squares;
  for (int j = 0; j < e.grid.ny; ++j)
    for (int i = 0; i < e.grid.nx; ++i) {
      if (!fired(i, j) || fired(i - s, j) || fired(i, j - s)) continue;
      int n = 1;
      while (fired(i + n * s, j)) ++n;
      squares.push_back({i, j, n, s});
    }
  const double step_mm = s * 0.5 * (e.grid.pitch_x_mm + e.grid.pitch_y_mm);
  // A rise is the difference of two maps.
  return droplet::evaluate_spacing(step_mm / diameter_mm,
                                   droplet::square_rises(l.before, l.after, l.use, squares),
                                   1.41421356 * run.noise_std_mm());
}

}  // namespace firn
