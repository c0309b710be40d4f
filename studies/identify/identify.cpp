#include <fmt/core.h>

#include <stdexcept>

#include "core/control/pattern.h"
#include "files/usage_error.h"
#include "studies/identify/identify.h"

namespace firn {
namespace {

constexpr double kZ = 1.959964;
constexpr double kMinExcitation = 0.01;  // full layers give about 0.002, half-filled ones 0.05 to 0.2

}  // namespace

Identification identify(const ObservedRun& run) {
  Identification id;
  id.layers = run.layers();
  id.droplets = run.droplets();
  id.noise_std_mm = run.noise_std_mm();
  try {
    id.fit = run.learn();
  } catch (const std::invalid_argument& error) {
    id.uninformative = error.what();
    return id;
  }
  id.prints = droplet::find_identification_prints(run.printed());
  const auto& m = id.fit.model;
  id.h1 = {m.h1_mm, kZ * id.fit.std_mm(0)};
  id.h2 = {m.h2_mm, kZ * id.fit.std_mm(1)};
  id.h3 = {m.h3_mm, kZ * id.fit.std_mm(2)};
  id.layer_height = {m.layer_height_mm(), kZ * id.fit.layer_height_std_mm()};
  if (id.prints.complete()) return id;
  if (id.droplets == 0)
    id.uninformative = "no droplet was fired";
  else if (id.fit.excitation < kMinExcitation || id.h1.half_width_mm > 0.5 * m.h1_mm)
    id.uninformative = fmt::format(
        "its layers are too much alike (excitation {:.4f}, {} is needed): they tell h1 + 4 h2 + 4 h3 = "
        "{:.3f} +- {:.3f} um, but not "
        "h1, h2 and h3 apart; print experiments/identification.toml or experiments/excitation.toml",
        id.fit.excitation, kMinExcitation, id.layer_height.mean_mm * 1e3,
        id.layer_height.half_width_mm * 1e3);
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
