#include "core/control/mpc/objective.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace firn::control::mpc {

HorizonObjective::HorizonObjective(const Setup& s, int horizon, int max_drops, ErrorKind error,
                                   double price_mm2, double mean_weight, double outside_price)
    : grid_(s.grid),
      model_(s.grid, deposition::stencil_of(s.model), s.border),
      surface_(s.grid),
      predicted_(s.grid),
      max_drops_(max_drops),
      cost_{1.0, error, price_mm2, mean_weight, outside_price},
      row_(std::size_t(s.grid.nx) + 2),
      plan_(std::size_t(horizon), DropletPattern(s.grid)) {
  const std::size_t n = row_ * (std::size_t(s.grid.ny) + 2),
                    steps = std::size_t(horizon) * std::size_t(max_drops);
  for (const Material m : {Material::kA, Material::kB}) {
    Ink& ink = inks_[m == Material::kB];
    ink.drop_height_mm = s.model_of(m).layer_height_mm();
    ink.stencil = deposition::stencil_of(s.model_of(m));
    for (const deposition::Link& link : deposition::links_of(ink.stencil)) {
      if (!(link.w_mm > 0.0)) continue;
      ink.links.push_back(link);
      ink.offsets.push_back(std::ptrdiff_t(link.dy) * std::ptrdiff_t(row_) + link.dx);
    }
  }
  // Beyond the border: infinitely low ground takes its full share, an infinitely high wall takes nothing.
  const double inf = std::numeric_limits<double>::infinity();
  height_.assign(steps + 1, std::vector<double>(n, s.border == deposition::Border::kLose ? -inf : inf));
  drops_.assign(steps, std::vector<std::uint8_t>(n, 0));
  target_.assign(n, 0.0);
  counts_.assign(n, 0);
  delta_.assign(n, 0.0);
  next_.assign(n, 0.0);
  for (int j = 0; j < s.grid.ny; ++j)
    for (int i = 0; i < s.grid.nx; ++i)
      padded_.push_back(std::uint32_t(std::size_t(j + 1) * row_ + std::size_t(i) + 1));
  for (std::uint32_t c = 0; c < s.grid.size(); ++c) {
    if (!s.mask.cells[c]) continue;
    part_.push_back(c);
    target_[padded(c)] = s.target.cells[c];
    counts_[padded(c)] = 1;
  }
  count_ = double(part_.size());
  per_cell_ = 1.0 / count_;
  outside_mm_ = outside_price * s.model.layer_height_mm();
  if (steps == 1) {
    table_.resize(s.grid.size());
    error_.assign(n + 1, 0.0);
    deviation_.assign(n + 1, 0.0);
  }
}

void HorizonObjective::move_only(const Mask& cells) {
  only_.clear();
  for (const std::uint32_t c : part_)
    if (cells.cells[c]) only_.push_back(c);
}

void HorizonObjective::set_surface(const HeightMap& height, double alpha,
                                   std::span<const MaterialMap> materials) {
  cost_.alpha = alpha;
  set_materials(materials);
  surface_ = height;
  store(surface_, 0);
  if (!table_.empty()) fill_table();
}

void HorizonObjective::set_materials(std::span<const MaterialMap> materials) {
  if (materials.empty() || materials[0].size() == 0) {
    materials_.clear();
    return;
  }
  materials_.resize(drops_.size());
  stencils_.resize(grid_.size());
  for (std::size_t step = 0; step < drops_.size(); ++step) {
    const MaterialMap& layer = materials[step / std::size_t(max_drops_)];
    materials_[step].assign(target_.size(), 0);
    for (std::uint32_t c = 0; c < grid_.size(); ++c)
      materials_[step][padded(c)] = layer.of(c) == Material::kB;
  }
}

void HorizonObjective::set_plan(std::span<const DropletPattern> plan) {
  plan_.assign(plan.begin(), plan.end());
  refresh();
}

void HorizonObjective::store(const HeightMap& height, std::size_t step) {
  for (std::size_t j = 0; j < std::size_t(grid_.ny); ++j)
    std::copy_n(height.data() + j * std::size_t(grid_.nx), grid_.nx,
                height_[step].data() + (j + 1) * row_ + 1);
}

void HorizonObjective::fill_table() {
  for (const std::uint32_t c : part_) {
    Shares& s = table_[c] = {};
    const std::size_t p = padded(c);
    const Ink& ink = ink_at(0, p);
    const double* h = height_[0].data() + p;
    double own = ink.drop_height_mm;
    for (std::size_t q = 0; q < ink.links.size(); ++q) {
      const deposition::Link& link = ink.links[q];
      const double f = link.spread_mm(h[0] - h[ink.offsets[q]]);
      own -= f;
      if (counts_[std::size_t(std::ptrdiff_t(p) + ink.offsets[q])])
        s.mm[std::size_t((link.dy + 1) * 4 + link.dx + 1)] = f;
      else
        s.outside_mm += f;
    }
    s.mm[5] = own;
    for (const double f : s.mm) {
      s.sum_mm += f;
      s.square_mm2 += f * f;
    }
  }
}

double HorizonObjective::step_model(std::size_t step, const DropletPattern& layer, int pass) {
  if (materials_.empty()) return model_.step(predicted_.data(), layer.data(), pass).lost_mm;
  for (std::uint32_t c = 0; c < grid_.size(); ++c) stencils_[c] = ink_at(step, padded(c)).stencil;
  return model_.step(predicted_.data(), layer.data(), pass, stencils_).lost_mm;
}

void HorizonObjective::refresh() {
  predicted_.cells = surface_.cells;
  double over_border_mm = 0.0;
  for (std::size_t step = 0; step < drops_.size(); ++step) {
    const int pass = int(step % std::size_t(max_drops_));
    const DropletPattern& layer = plan_[step / std::size_t(max_drops_)];
    for (std::uint32_t c = 0; c < grid_.size(); ++c) drops_[step][padded(c)] = layer.cells[c] > pass;
    over_border_mm += step_model(step, layer, pass);
    store(predicted_, step + 1);
  }
  const std::vector<double>& h = height_.back();
  double sum = 0.0;
  for (std::uint32_t c : part_) sum += h[padded(c)] - target_[padded(c)];
  reference_mm_ = sum / count_;
  sums_ = {};
  for (std::uint32_t c : part_) {
    const std::size_t p = padded(c);
    const double d = h[p] - target_[p] - reference_mm_;
    sums_.abs_error += std::abs(target_[p] - h[p]);
    sums_.first += d;
    sums_.second += d * d;
    note_height(p);
  }
  const double mean = sums_.first / count_;
  variance_ = std::max(0.0, sums_.second / count_ - mean * mean);
  root_ = std::sqrt(variance_);
  for (const DropletPattern& layer : plan_) sums_.droplets += double(layer.total());
  if (cost_.outside_price > 0.0) {
    sums_.outside = over_border_mm;
    for (std::uint32_t c = 0; c < grid_.size(); ++c)
      if (!counts_[padded(c)]) sums_.outside += predicted_.cells[c] - surface_.cells[c];
  }
  const double error = cost_.error == ErrorKind::kSquare
                           ? std::sqrt(square_of(sums_))
                           : (sums_.abs_error + cost_.outside_price * sums_.outside) / count_;
  value_mm_ = cost_.alpha * error + (1.0 - cost_.alpha) * root_;
}

bool HorizonObjective::allowed(const Move& m) const {
  const int n = plan_[std::size_t(m.layer)].cells[m.cell] + m.change;
  return n >= 0 && n <= max_drops_;
}

std::size_t HorizonObjective::step_of(const Move& m) const {
  const int count = plan_[std::size_t(m.layer)].cells[m.cell];
  return std::size_t(m.layer) * std::size_t(max_drops_) + std::size_t(m.change > 0 ? count : count - 1);
}

template <class Visit>
void HorizonObjective::first_change(const Move& m, std::size_t step, const Visit& visit) const {
  const std::size_t p = padded(m.cell);
  const double* h = height_[step].data() + p;
  const Ink& ink = ink_at(step, p);
  const double sign = m.change;
  double own = ink.drop_height_mm;
  for (std::size_t q = 0; q < ink.links.size(); ++q) {
    const double f = ink.links[q].spread_mm(h[0] - h[ink.offsets[q]]);
    visit(std::size_t(std::ptrdiff_t(p) + ink.offsets[q]), sign * f);
    own -= f;
  }
  visit(p, sign * own);
}

// Cells of the padded grid within `radius` of the centre; the padding itself counts as one ring of cells.
template <class Visit>
void HorizonObjective::window(std::size_t centre, int radius, const Visit& visit) const {
  const int ci = int(centre % row_), cj = int(centre / row_);
  for (int j = std::max(cj - radius, 0); j <= std::min(cj + radius, grid_.ny + 1); ++j)
    for (int i = std::max(ci - radius, 0); i <= std::min(ci + radius, grid_.nx + 1); ++i)
      visit(std::size_t(j) * row_ + std::size_t(i));
}

void HorizonObjective::widen(std::size_t step, std::size_t centre, int radius, bool keep) {
  std::vector<double>& h = height_[step];
  const std::vector<std::uint8_t>& u = drops_[step];
  window(centre, radius, [&](std::size_t p) { next_[p] += delta_[p]; });
  // Flows of this step change where a droplet and its neighbour stand at another height difference than
  // before.
  window(centre, radius + 1, [&](std::size_t p) {
    if (!u[p]) return;  // beyond the border there are no droplets
    const Ink& ink = ink_at(step, p);
    for (std::size_t q = 0; q < ink.links.size(); ++q) {
      const std::size_t n = std::size_t(std::ptrdiff_t(p) + ink.offsets[q]);
      const double d = delta_[p] - delta_[n];
      if (d == 0.0) continue;
      const deposition::Link& link = ink.links[q];
      const double f = link.spread_mm(h[p] - h[n] + d) - link.spread_mm(h[p] - h[n]);
      next_[n] += f;
      next_[p] -= f;
    }
  });
  window(centre, radius, [&](std::size_t p) {
    if (keep) h[p] += delta_[p];
    delta_[p] = 0.0;
  });
  std::swap(delta_, next_);
}

int HorizonObjective::propagate(const Move& m, std::size_t step, bool keep) {
  first_change(m, step, [&](std::size_t p, double delta) { delta_[p] = delta; });
  int radius = 1;
  for (++step; step < drops_.size(); ++step, ++radius) widen(step, padded(m.cell), radius, keep);
  return radius;
}

void HorizonObjective::add(std::size_t p, double delta, Sums& s) const {
  if (!counts_[p]) {
    s.outside += delta;
    return;
  }
  const double h = height_.back()[p], error = target_[p] - h;
  s.abs_error += std::abs(error - delta) - std::abs(error);
  s.first += delta;
  s.second += delta * (2.0 * (-error - reference_mm_) + delta);
}

void HorizonObjective::note_height(std::size_t p) {
  if (error_.empty() || !counts_[p]) return;
  error_[p] = target_[p] - height_.back()[p];
  deviation_[p] = -error_[p] - reference_mm_;
}

double HorizonObjective::square_of(const Sums& s) const {
  const double mean = reference_mm_ + s.first * per_cell_;
  return std::max(0.0, (s.second + cost_.price_mm2 * s.droplets + outside_mm_ * s.outside) * per_cell_ +
                           reference_mm_ * (2.0 * s.first * per_cell_ + reference_mm_) +
                           cost_.mean_weight * mean * mean);
}

// The difference of two roots by their squares: no cancellation, however many cells share one droplet.
double HorizonObjective::gain_of(const Sums& c) const {
  double error_part = cost_.alpha * (c.abs_error + cost_.outside_price * c.outside) * per_cell_;
  if (cost_.error == ErrorKind::kSquare) {
    const double before = square_of(sums_);
    const double mean = reference_mm_ + sums_.first * per_cell_, mean_rise = c.first * per_cell_;
    const double rise =
        (c.second + cost_.price_mm2 * c.droplets + outside_mm_ * c.outside + 2.0 * reference_mm_ * c.first) *
            per_cell_ +
        cost_.mean_weight * mean_rise * (2.0 * mean + mean_rise);
    const double now = std::max(0.0, before + rise), roots = std::sqrt(now) + std::sqrt(before);
    error_part = roots > 0.0 ? cost_.alpha * ((now - before) / roots) : 0.0;
  }
  if (cost_.alpha == 1.0) return error_part;
  const double change = (c.second - (2.0 * sums_.first + c.first) * c.first * per_cell_) * per_cell_;
  const double variance = std::max(0.0, variance_ + change), roots = std::sqrt(variance) + root_;
  return roots > 0.0 ? error_part + (1.0 - cost_.alpha) * ((variance - variance_) / roots) : error_part;
}

double HorizonObjective::single_step_gain(std::uint32_t cell, double sign) const {
  const Shares& s = table_[cell];
  const double* share = s.mm;
  const double* error = error_.data() + padded(cell) - row_ - 1;
  const double* deviation = deviation_.data() + padded(cell) - row_ - 1;
  Sums change;
  double worse[4] = {}, crossed[4] = {};
  for (int j = 0; j < 3; ++j, share += 4, error += row_, deviation += row_)
    for (int i = 0; i < 4; ++i) {
      worse[i] += std::abs(error[i] - sign * share[i]) - std::abs(error[i]);
      crossed[i] += share[i] * deviation[i];
    }
  change.abs_error = (worse[0] + worse[1]) + (worse[2] + worse[3]);
  const double cross = (crossed[0] + crossed[1]) + (crossed[2] + crossed[3]);
  change.first = sign * s.sum_mm;
  change.droplets = sign;
  change.outside = sign * s.outside_mm;
  change.second = 2.0 * sign * cross + s.square_mm2;
  return gain_of(change);
}

double HorizonObjective::gain_mm(const Move& m) {
  if (!table_.empty()) return single_step_gain(m.cell, m.change);
  const std::size_t step = step_of(m);
  Sums change;
  change.droplets = m.change;
  if (step + 1 == drops_.size()) {
    first_change(m, step, [&](std::size_t p, double delta) { add(p, delta, change); });
    return gain_of(change);
  }
  const int radius = propagate(m, step, false);
  window(padded(m.cell), radius, [&](std::size_t p) {
    if (delta_[p] != 0.0) add(p, delta_[p], change);
    delta_[p] = 0.0;
  });
  return gain_of(change);
}

void HorizonObjective::apply(const Move& m) {
  const std::size_t step = step_of(m);
  Sums change;
  change.droplets = m.change;
  const int radius = propagate(m, step, true);
  window(padded(m.cell), radius, [&](std::size_t p) {
    add(p, delta_[p], change);
    height_.back()[p] += delta_[p];
    note_height(p);
    delta_[p] = 0.0;
  });
  drops_[step][padded(m.cell)] = m.change > 0;
  std::uint8_t& count = plan_[std::size_t(m.layer)].cells[m.cell];
  count = std::uint8_t(count + m.change);
  value_mm_ += gain_of(change);
  sums_.abs_error += change.abs_error;
  sums_.first += change.first;
  sums_.second += change.second;
  sums_.droplets += change.droplets;
  sums_.outside += change.outside;
  const double mean = sums_.first / count_;
  variance_ = std::max(0.0, sums_.second / count_ - mean * mean);
  root_ = std::sqrt(variance_);
}

}  // namespace firn::control::mpc
