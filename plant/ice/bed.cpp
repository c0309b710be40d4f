#include "plant/ice/bed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/grid/random.h"
#include "plant/ice/table.h"

namespace firn::plant {
namespace {

constexpr double kLargestRadius_mm = 2.6;
constexpr int kWindow = 40;  // cells: more than 2 x kLargestRadius_mm / the smallest cell + 2
constexpr double kLayerStep_mm = 0.05;
constexpr double kSlide = 1.15, kBeyond_mm = 1.5;

}  // namespace

Bed::Bed(const IceWorldConfig& config, std::uint64_t seed)
    : config_(config),
      seed_(seed),
      cell_(config.field.cell_mm),
      x0_(config.field.x0_mm),
      y0_(config.field.y0_mm),
      nx_(int(std::ceil(config.field.width_mm / cell_))),
      ny_(int(std::ceil(config.field.height_mm / cell_))) {
  const std::size_t n = std::size_t(nx_) * std::size_t(ny_);
  table_.resize(n);
  water_.assign(n, 0.0);
  top_.assign(n, std::uint8_t(Ground::kTable));
  gain_.assign(n, 1.0f);
  pattern_.assign(n, 0.0f);
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i)
      table_[std::size_t(j) * std::size_t(nx_) + std::size_t(i)] = table_mm(centre_x_mm(i), centre_y_mm(j));
  z_ = table_;
  highest_mm_ = *std::max_element(z_.begin(), z_.end());
  add_lattice_noise({seed_, Purpose::kPattern, 0}, config_.disturbance.pattern_mm,
                    config_.disturbance.pattern, cell_, nx_, ny_, pattern_);
  renew_gain();
}

double Bed::table_mm(double x_mm, double y_mm) const {
  return table_height_mm(config_.table, seed_, x_mm, y_mm);
}

bool Bed::inside(double x_mm, double y_mm) const {
  return x_mm >= x0_ && y_mm >= y0_ && x_mm < x0_ + nx_ * cell_ && y_mm < y0_ + ny_ * cell_;
}

void Bed::set_nozzle_height(double z_mm) {
  const auto layer = std::int32_t(std::lround(z_mm / kLayerStep_mm));
  if (layer == layer_) return;
  layer_ = layer;
  renew_gain();
}

void Bed::renew_gain() {
  const IceDisturbanceParams& d = config_.disturbance;
  for (std::size_t n = 0; n < gain_.size(); ++n) gain_[n] = 1.0f + pattern_[n];
  add_lattice_noise({seed_, Purpose::kSurface, std::uint32_t(layer_)}, d.roughness_mm, d.roughness, cell_,
                    nx_, ny_, gain_);
  for (float& g : gain_) g = std::max(g, 0.1f);
}

// Low ground is over an edge only where it is low further out as well: a groove between two beads fills.
bool Bed::open_beyond(const Drop& drop, double dx, double dy, double below_mm) const {
  const double r = std::sqrt(dx * dx + dy * dy);
  if (r < 1e-9) return true;
  const double x = drop.x_mm + dx * (1.0 + kBeyond_mm / r), y = drop.y_mm + dy * (1.0 + kBeyond_mm / r);
  if (!inside(x, y)) return true;
  return z_mm(int((x - x0_) / cell_), int((y - y0_) / cell_)) < below_mm;
}

bool Bed::land(const Drop& drop) {
  const IceBeadParams& p = config_.bead[std::size_t(drop.material)];
  ledger_.landed[drop.material] += drop.volume_mm3;
  const double alone_mm = std::sqrt(drop.volume_mm3 / (std::numbers::pi * p.pool_mm));
  const double radius =
      std::clamp(std::max(alone_mm, drop.per_length_mm2 / (std::numbers::sqrt3 * p.pool_mm)), 1.3 * cell_,
                 kLargestRadius_mm);
  const int i0 = int(std::floor((drop.x_mm - radius - x0_) / cell_)),
            i1 = int(std::floor((drop.x_mm + radius - x0_) / cell_));
  const int j0 = int(std::floor((drop.y_mm - radius - y0_) / cell_)),
            j1 = int(std::floor((drop.y_mm + radius - y0_) / cell_));
  if (i0 < 0 || j0 < 0 || i1 >= nx_ || j1 >= ny_) {
    ledger_.lost += drop.volume_mm3;
    return false;
  }
  const int w = i1 - i0 + 1, h = j1 - j0 + 1;
  std::array<double, kWindow * kWindow> k, z, cap;

  // Ground under the liquid: the second highest of five places (one may be debris, others beyond an edge).
  std::array<double, 5> under{};
  constexpr double kPlaces[5][2] = {{0, 0}, {0.4, 0}, {-0.4, 0}, {0, 0.4}, {0, -0.4}};
  for (std::size_t n = 0; n < 5; ++n)
    under[n] = z_mm(int((drop.x_mm + kPlaces[n][0] * radius - x0_) / cell_),
                    int((drop.y_mm + kPlaces[n][1] * radius - y0_) / cell_));
  std::nth_element(under.begin(), under.begin() + 1, under.end(), std::greater<>());
  const double edge_below = under[1] - p.edge_mm;

  const double inverse = 1.0 / (radius * radius);
  double sum_k = 0.0, sum_kz = 0.0, sum_low = 0.0;
  for (int b = 0; b < h; ++b) {
    const double dy = centre_y_mm(j0 + b) - drop.y_mm, dx0 = centre_x_mm(i0) - drop.x_mm;
    const double* row = &z_[std::size_t(j0 + b) * std::size_t(nx_) + std::size_t(i0)];
    double *kr = &k[std::size_t(b * w)], *zr = &z[std::size_t(b * w)], *cr = &cap[std::size_t(b * w)];
    for (int a = 0; a < w; ++a) {
      const double dx = dx0 + a * cell_;
      const double part = std::min(1.0, std::max(0.0, 3.0 * (1.0 - (dx * dx + dy * dy) * inverse)));
      const bool low = row[a] < edge_below && open_beyond(drop, dx, dy, edge_below);
      zr[a] = row[a];
      cr[a] = low ? 0.0 : p.deepest_mm;
      kr[a] = part;
      sum_k += low ? 0.0 : part;
      sum_kz += low ? 0.0 : part * row[a];
      sum_low += low ? part : 0.0;
    }
  }
  const int n = w * h;
  const double all = drop.volume_mm3 / (cell_ * cell_);
  // On a rim little goes over. From a spire narrower than the pool the liquid beyond it slides off, and a
  // little more.
  const double low_share = sum_low > 0.0 ? sum_low / (sum_k + sum_low) : 0.0;
  const double slide = std::min(1.0, 2.0 * low_share), held_back = p.spill + (kSlide - p.spill) * slide;
  const double over = all * std::min(1.0, low_share * held_back);
  const double goal = all - over;
  double level = sum_k > 0.0 ? (sum_kz + goal) / sum_k : under[1] + p.pool_mm, held = 0.0;
  for (int step = 0; step < 4; ++step) {
    double slope = 0.0;
    held = 0.0;
    for (int m = 0; m < n; ++m) {
      const double d = level - z[std::size_t(m)], c = cap[std::size_t(m)];
      held += k[std::size_t(m)] * std::min(c, std::max(0.0, d));
      slope += d > 0.0 && d < c ? k[std::size_t(m)] : 0.0;
    }
    if (step == 3 || slope < 1e-9) break;
    level += (goal - held) / slope;
  }
  const double scale = held > 0.0 ? goal / held : 0.0, fallen = over > 0.0 ? over / sum_low : 0.0;
  if (held <= 0.0 && over <= 0.0) {  // only higher ground: a jet into a crack
    ledger_.lost += drop.volume_mm3;
    return false;
  }
  double frozen = 0.0;
  for (int b = 0; b < h; ++b) {
    const std::size_t at = std::size_t(j0 + b) * std::size_t(nx_) + std::size_t(i0);
    for (int a = 0; a < w; ++a) {
      const std::size_t m = std::size_t(b * w + a), cell = at + std::size_t(a);
      const double share = cap[m] > 0.0 ? scale * std::min(cap[m], std::max(0.0, level - z[m])) : fallen;
      const double dz = k[m] * share * double(gain_[cell]);
      z_[cell] = z[m] + dz;
      frozen += dz;
      if (drop.material == 0) water_[cell] += dz;
      if (dz > 0.01) top_[cell] = std::uint8_t(drop.material == 0 ? Ground::kWater : Ground::kScaffold);
      highest_mm_ = std::max(highest_mm_, z_[cell]);
    }
  }
  ledger_.grown += (frozen - (held > 0.0 ? goal : 0.0) - over) * cell_ * cell_;
  if (held <= 0.0) ledger_.lost += goal * cell_ * cell_;
  return true;
}

void Bed::add_debris(double x_mm, double y_mm, double height_mm, double radius_mm) {
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i) {
      const double dx = centre_x_mm(i) - x_mm, dy = centre_y_mm(j) - y_mm;
      const double part = 1.0 - (dx * dx + dy * dy) / (radius_mm * radius_mm);
      if (part <= 0.0) continue;
      const std::size_t cell = std::size_t(j) * std::size_t(nx_) + std::size_t(i);
      z_[cell] += height_mm * part;
      top_[cell] = std::uint8_t(Ground::kDebris);
      ledger_.debris += height_mm * part * cell_ * cell_;
      highest_mm_ = std::max(highest_mm_, z_[cell]);
    }
}

double Bed::height_mm(double x_mm, double y_mm) const {
  const double u = (x_mm - x0_) / cell_ - 0.5, v = (y_mm - y0_) / cell_ - 0.5;
  if (!(u >= 0.0 && v >= 0.0 && u < nx_ - 1 && v < ny_ - 1)) return table_mm(x_mm, y_mm);
  const int i = int(u), j = int(v);
  const double fx = u - i, fy = v - j;
  return (1 - fy) * ((1 - fx) * z_mm(i, j) + fx * z_mm(i + 1, j)) +
         fy * ((1 - fx) * z_mm(i, j + 1) + fx * z_mm(i + 1, j + 1));
}

Ground Bed::ground(double x_mm, double y_mm) const {
  if (!inside(x_mm, y_mm)) return Ground::kTable;
  return Ground(
      top_[std::size_t((y_mm - y0_) / cell_) * std::size_t(nx_) + std::size_t((x_mm - x0_) / cell_)]);
}

double Bed::slope(double x_mm, double y_mm) const {
  const double gx = height_mm(x_mm + cell_, y_mm) - height_mm(x_mm - cell_, y_mm);
  const double gy = height_mm(x_mm, y_mm + cell_) - height_mm(x_mm, y_mm - cell_);
  return std::sqrt(gx * gx + gy * gy) / (2.0 * cell_);
}

HeightMap Bed::mean_over(const GridSpec& grid) const { return mean_of(z_, grid); }

HeightMap Bed::thickness_over(const GridSpec& grid, int material) const {
  if (material == 0) return mean_of(water_, grid);
  std::vector<double> rest(z_.size());
  for (std::size_t n = 0; n < z_.size(); ++n) rest[n] = z_[n] - table_[n] - water_[n];
  return mean_of(rest, grid);
}

// Fine cells count by the area they share with the grid's cell.
HeightMap Bed::mean_of(const std::vector<double>& values, const GridSpec& grid) const {
  HeightMap out(grid, std::numeric_limits<double>::quiet_NaN());
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      const double left = grid.origin_x_mm + (i - 0.5) * grid.pitch_x_mm, right = left + grid.pitch_x_mm;
      const double low = grid.origin_y_mm + (j - 0.5) * grid.pitch_y_mm, high = low + grid.pitch_y_mm;
      const double a0 = (left - x0_) / cell_, a1 = (right - x0_) / cell_, b0 = (low - y0_) / cell_,
                   b1 = (high - y0_) / cell_;
      if (a0 < -1e-9 || b0 < -1e-9 || a1 > nx_ + 1e-9 || b1 > ny_ + 1e-9) continue;
      double sum = 0.0, area = 0.0;
      for (int b = std::max(0, int(b0)); b < std::min(ny_, int(std::ceil(b1))); ++b)
        for (int a = std::max(0, int(a0)); a < std::min(nx_, int(std::ceil(a1))); ++a) {
          const double share = (std::min(a1, a + 1.0) - std::max(a0, double(a))) *
                               (std::min(b1, b + 1.0) - std::max(b0, double(b)));
          if (share <= 0.0) continue;
          sum += share * values[std::size_t(b) * std::size_t(nx_) + std::size_t(a)];
          area += share;
        }
      out.cells[grid.index(i, j)] = sum / area;
    }
  return out;
}

double Bed::volume_mm3() const {
  double sum = 0.0;
  for (std::size_t n = 0; n < z_.size(); ++n) sum += z_[n] - table_[n];
  return sum * cell_ * cell_;
}

void Bed::io(Archive& a) {
  a.all(z_, water_, top_, layer_, highest_mm_, ledger_);
  if (a.loading()) renew_gain();
}

}  // namespace firn::plant
