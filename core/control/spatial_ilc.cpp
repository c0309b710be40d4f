#include "core/control/spatial_ilc.h"

#include <algorithm>
#include <numbers>

#include "core/control/halftone.h"
#include "core/exact/exact_math.h"

namespace firn::control {
namespace {

std::vector<double> cosines(int n) {
  std::vector<double> c(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) c[std::size_t(k)] = exact::cos(std::numbers::pi * k / n);
  return c;
}

const ControlOptions& checked_ilc(const ControlOptions& options) {
  check_extra("spatial_ilc", kSpatialIlcOptions, options.extra);
  return options;
}

double option(const ControlOptions& options, const char* name) {
  ExtraValues values = options.extra;
  values.complete(kSpatialIlcOptions);
  return values.number(name);
}

}  // namespace

LearningFilter::LearningFilter(const GridSpec& grid, const deposition::DropletModel& model, double change,
                               double effort)
    : grid_(grid),
      transform_(grid.nx, grid.ny),
      kernel_(grid.size()),
      keep_(grid.size()),
      learn_(grid.size()) {
  const std::vector<double> cx = cosines(grid.nx), cy = cosines(grid.ny);
  const double whole = model.layer_height_mm(), r = change * whole * whole, s = effort * whole * whole;
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      const std::size_t n = grid.index(i, j);
      const double x = cx[std::size_t(i)], y = cy[std::size_t(j)];
      const double k = model.h1_mm + 2.0 * model.h2_mm * (x + y) + 4.0 * model.h3_mm * x * y;
      // A kernel that blurs so much that a frequency vanishes cannot change it: its dose stays.
      const double weight = k * k + r + s;
      kernel_[n] = k;
      keep_[n] = weight > 0.0 ? (k * k + r) / weight : 1.0;
      learn_[n] = weight > 0.0 ? k / weight : 0.0;
    }
}

Grid<double> LearningFilter::next_dose(const Grid<double>& dose, const Grid<double>& error) {
  Grid<double> next = dose, learned = error;
  transform_.forward(next.cells.data());
  transform_.forward(learned.cells.data());
  for (std::size_t n = 0; n < next.size(); ++n)
    next.cells[n] = keep_[n] * next.cells[n] + learn_[n] * learned.cells[n];
  transform_.inverse(next.cells.data());
  return next;
}

SpatialIlc::SpatialIlc(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      dh_mm_(setup.model.layer_height_mm()),
      noise_gate_(checked_ilc(options).noise_gate),
      part_cells_(setup.mask.count()),
      filter_(setup.grid, setup.model, option(options, "ilc_change"), option(options, "ilc_effort")),
      predict_(setup) {}

Decision SpatialIlc::decide(const Measurement& m) {
  check(m, setup_);
  if (m.layer < after_.layer) before_ = after_ = Memory{};
  if (m.layer > after_.layer) before_ = after_;  // else: measured again, as if the first time had not been

  const HeightMap height = known_heights(m);
  const bool first = before_.layer < 0;
  Grid<double> dose(setup_.grid), error(setup_.grid);
  bool at_target = true;
  for (std::size_t c = 0; c < dose.size(); ++c) {
    if (!setup_.mask.cells[c]) continue;
    const double now = std::min(double(m.layer) * dh_mm_, setup_.target.cells[c]),
                 next = std::min(double(m.layer + 1) * dh_mm_, setup_.target.cells[c]);
    at_target = at_target && next == now;
    const double wanted = next - height.cells[c];
    // Nothing is learned yet of the first layer: a full dose is taken for its nominal rise.
    dose.cells[c] = first ? 1.0 : before_.dose.cells[c];
    error.cells[c] = wanted - (first ? dh_mm_ : height.cells[c] - before_.height.cells[c]);
  }
  Decision d;
  Grid<double> none(setup_.grid);
  d.drops = halftone(filter_.next_dose(dose, error), setup_.mask, 1, Rounding::kDiffusion, none);
  d.materials = materials_at(setup_, height);
  predict_.score(d, height, 1.0);
  after_ = {m.layer, height, Grid<double>(setup_.grid)};
  if (at_target && !beats_noise(d, part_cells_, m.noise_std_mm, noise_gate_)) {
    end_print(d,
              "the nominal height is reached and no layer betters the part beyond the measurement's noise");
    return d;
  }
  for (std::size_t c = 0; c < dose.size(); ++c) after_.dose.cells[c] = d.drops.cells[c];
  d.kind = Decision::Kind::kPrint;
  d.reason = "layer " + std::to_string(m.layer + 1) + " by what the layer before it rose";
  return d;
}

}  // namespace firn::control
