#include "core/control/smf.h"

#include <algorithm>
#include <cmath>

#include "core/control/halftone.h"
#include "core/control/rim_inset.h"

namespace firn::control {
namespace {

const SmfOptions& checked_smf(const SmfOptions& o) {
  check_options("smf", kSmfOptions, o);
  return o;
}

}  // namespace

Smf::Smf(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      options_(checked_smf(options.smf)),
      dh_mm_(options_.layer_height_mm > 0.0 ? options_.layer_height_mm : setup.model.layer_height_mm()),
      noise_gate_(options.noise_gate),
      stall_layers_(options.stall_layers),
      part_cells_(setup.mask.count()),
      inset_(inset_places(setup, options.rim_inset)),
      predict_(setup),
      output_(setup.grid) {
  before_.sum = before_.error = before_.carry = Grid<double>(setup.grid);
  after_ = before_;
}

void Smf::use_options(const ControlOptions& options) {
  take_changeable(kSmfOptions, checked_smf(options.smf), options_);
  noise_gate_ = options.noise_gate;
  stall_layers_ = options.stall_layers;
}

bool Smf::keep_short_cells(Decision& d, const Measurement& m, const HeightMap& height) {
  const auto lack = [&](std::size_t c) { return (setup_.target.cells[c] - height.cells[c]) / dh_mm_; };
  double most = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c)
    if (setup_.mask.cells[c]) most = std::max(most, lack(c));
  if (most <= kMostLack) return false;
  short_cells_.add(m, setup_.target, setup_.mask);
  if (short_cells_.stalled(stall_layers_)) return false;
  for (std::size_t c = 0; c < height.size(); ++c)
    if (lack(c) < 0.5) d.drops.cells[c] = 0;
  predict_.score(d, height, 1.0);
  return beats_noise(d, part_cells_, m.noise_std_mm, noise_gate_);
}

double Smf::reference_mm(std::size_t cell, int layer) const {
  return std::min(double(layer) * dh_mm_, setup_.target.cells[cell]);
}

Decision Smf::decide(const Measurement& m) {
  check(m, setup_);
  if (m.layer < after_.layer)
    after_ = Memory{-1, Grid<double>(setup_.grid), Grid<double>(setup_.grid), Grid<double>(setup_.grid)};
  short_cells_.rewind(m.layer);
  if (m.layer > after_.layer)
    before_ = after_;
  else
    after_ = before_;  // measured again: as if the first time had not been
  const bool derivative = before_.layer >= 0;
  const double sum_limit = options_.ki_star > 0.0 ? options_.integral_limit / options_.ki_star : 0.0;

  const HeightMap height = known_heights(m);
  const MaterialMap materials = materials_at(setup_, height);
  Grid<double> wanted(setup_.grid);
  bool at_target = true;
  for (std::size_t c = 0; c < wanted.size(); ++c) {
    if (!setup_.mask.cells[c]) continue;
    const double r = reference_mm(c, m.layer), next = reference_mm(c, m.layer + 1);
    const double e = (r - m.height.cells[c]) / dh_mm_;
    const double sum = std::clamp(before_.sum.cells[c] + e, -sum_limit, sum_limit);
    double u = options_.kp * e + options_.ki_star * sum;  // (5.1), (5.2)
    if (derivative) u += options_.kd_star * (e - before_.error.cells[c]);
    output_.cells[c] = std::clamp(u, -options_.output_limit, options_.output_limit);
    after_.sum.cells[c] = sum;
    after_.error.cells[c] = e;
    const Material ink = materials.size() != 0 ? materials.of(c) : Material::kA;
    wanted.cells[c] =
        (next - r + dh_mm_ * output_.cells[c]) / setup_.model_of(ink).layer_height_mm();  // 5.2.3
    at_target = at_target && next == r;
  }
  after_.layer = m.layer;

  Decision d;
  d.drops = halftone(wanted, setup_.mask, options_.max_drops, options_.rounding, after_.carry);
  d.materials = materials;
  d.offsets = inset_;
  predict_.score(d, height, 1.0);
  const bool betters = !at_target || beats_noise(d, part_cells_, m.noise_std_mm, noise_gate_);
  if (!betters && !keep_short_cells(d, m, height)) {
    end_print(d,
              "the nominal height is reached and no layer betters the part beyond the measurement's noise");
    return d;
  }
  d.kind = Decision::Kind::kPrint;
  d.reason = !betters    ? "correction at the nominal height of the cells that are short"
             : at_target ? "correction at the nominal height"
                         : "layer " + std::to_string(m.layer + 1) + " by PID on the error surface";
  return d;
}

}  // namespace firn::control
