#include "estimators/lab/layer_features.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/grid/firing_order.h"
#include "core/grid/outline.h"
#include "core/statistics/median.h"

namespace firn::lab {
namespace {

constexpr double kUm = 1e3;
constexpr int kBlock = 4;           // cells of a side of the blocks whose means hold the long waves
constexpr double kTail = 3.5;       // scaled median absolute deviations
constexpr double kMinShare = 2e-4;  // added to shares before their logarithm
constexpr double kRidge = 1e-3;     // of the regression, of a cell-layer

// The names from kFirstSymmetric on are zero on average in any laboratory that favours no direction: they
// check a laboratory, and tell nothing about its parameters.
constexpr const char* kStretchNames[] = {
    "growth by a droplet inside the part",
    "growth by a droplet on the part's rim",
    "growth under a cell's own droplet",
    "growth by a droplet beside a cell",
    "levelling towards lower neighbours",
    "scatter of a cell's growth",
    "memory of a cell's growth from layer to layer",
    "lasting differences between cells",
    "long waves in a layer's growth",
    "cells that grew far too little",
    "change of the growth from layer to layer",
    "drift of the growth",
    "roughness of the surface",
    "long waves of the surface",
    "short waves of the surface",
    "cells without a measurement",
    "droplets that land ahead of the stage or behind it",
    "growth from a layer's first row to its last",
    "growth of layers of many droplets",
    "growth by a droplet two cells away",
    "growth by a droplet at a side against one at a corner",
    "tilt of the surface along x",
    "tilt of the surface along y",
    "tilt of the droplets along x",
    "tilt of the droplets along y",
    "lowest column of cells",
    "lowest row of cells",
    "droplets that land displaced along x",
    "droplets that land displaced along y",
    "droplets that land displaced along their row",
};
constexpr std::size_t kPerStretch = std::size(kStretchNames), kFirstSymmetric = 21;
constexpr const char* kWholeNames[] = {
    "noise of the maps",
    "number of layers",
    "number of droplets",
    "final mean error",
    "final RMS error",
    "final largest error",
    "growth of the first layers over the others",
};
constexpr std::size_t kWhole = std::size(kWholeNames);
constexpr const char* kStretchWords[] = {"first", "second", "last"};

double log_share(double share) { return std::log(std::max(share, 0.0) + kMinShare); }
double log_scale(double value) { return std::log(std::max(value, 0.0) + 1e-6); }
double ratio(double a, double b) { return b > 0.0 ? a / b : 0.0; }

struct Moments {
  double n = 0.0, sum = 0.0, squares = 0.0;
  void add(double v) {
    n += 1.0;
    sum += v;
    squares += v * v;
  }
  double mean() const { return ratio(sum, n); }
  double variance() const { return n > 1.0 ? std::max(0.0, (squares - sum * sum / n) / (n - 1.0)) : 0.0; }
  double std() const { return std::sqrt(variance()); }
};

/// Regression of y on x.
struct Regression {
  Moments x, y;
  double xy = 0.0;
  void add(double a, double b) {
    x.add(a);
    y.add(b);
    xy += a * b;
  }
  double covariance() const { return x.n > 1.0 ? (xy - x.sum * y.mean()) / x.n : 0.0; }
  double slope() const { return ratio(covariance(), x.variance() + 1e-3); }
};

/// Values of the cells of a map that count, with the cell's place.
struct Places {
  GridSpec grid;
  std::vector<std::uint32_t> cells;   ///< of the part
  std::vector<std::uint32_t> inside;  ///< whose eight neighbours are of the part
};

Places places_of(const Mask& mask) {
  Places p{mask.spec, {}, {}};
  const Mask inner = inside_of(mask);
  for (std::size_t c = 0; c < mask.size(); ++c) {
    if (!mask.cells[c]) continue;
    p.cells.push_back(std::uint32_t(c));
    if (inner.cells[c]) p.inside.push_back(std::uint32_t(c));
  }
  return p;
}

/// Variance of the means of blocks of kBlock cells, as a share of the variance of the cells.
double long_wave_share(const Places& p, const std::vector<double>& value) {
  Moments all, blocks;
  const int wide = (p.grid.nx + kBlock - 1) / kBlock, tall = (p.grid.ny + kBlock - 1) / kBlock;
  std::vector<Moments> block(std::size_t(wide) * std::size_t(tall));
  for (const std::uint32_t c : p.cells) {
    if (!std::isfinite(value[c])) continue;
    all.add(value[c]);
    const int i = int(c) % p.grid.nx, j = int(c) / p.grid.nx;
    block[std::size_t(j / kBlock) * std::size_t(wide) + std::size_t(i / kBlock)].add(value[c]);
  }
  for (const Moments& b : block)
    if (b.n >= kBlock * kBlock / 2) blocks.add(b.mean());
  return ratio(blocks.variance(), all.variance());
}

/// Half the mean square of the differences of cells side by side, as a share of the variance.
double short_wave_share(const Places& p, const std::vector<double>& value) {
  Moments all;
  double sum = 0.0, pairs = 0.0;
  std::vector<double> of_part(value.size(), kNotMeasured);
  for (const std::uint32_t c : p.cells) of_part[c] = value[c];
  for (const std::uint32_t c : p.cells) {
    if (!std::isfinite(value[c])) continue;
    all.add(value[c]);
    for (const std::uint32_t n : {c + 1, c + std::uint32_t(p.grid.nx)}) {
      if (n >= of_part.size() || (n == c + 1 && n % std::uint32_t(p.grid.nx) == 0)) continue;
      if (!std::isfinite(of_part[n])) continue;
      sum += 0.5 * (of_part[n] - value[c]) * (of_part[n] - value[c]);
      pairs += 1.0;
    }
  }
  return ratio(ratio(sum, pairs), all.variance());
}

/// Slope over the part's width by least squares, along x or y.
double tilt(const Places& p, const std::vector<double>& value, bool along_x) {
  Moments place, height;
  double cross = 0.0;
  for (const std::uint32_t c : p.cells) {
    if (!std::isfinite(value[c])) continue;
    const double at = double(along_x ? int(c) % p.grid.nx : int(c) / p.grid.nx);
    place.add(at);
    height.add(value[c]);
    cross += at * value[c];
  }
  const double spread = place.squares - place.sum * place.mean();
  const double width = std::sqrt(12.0 * place.variance());  // of evenly spread places
  return ratio(cross - place.sum * height.mean(), spread) * width;
}

/// The surface about the target as far as it has been printed: min(target, q), q such that the means agree.
std::vector<double> levelled(const Places& p, const HeightMap& height, const HeightMap& target) {
  double mean = 0.0, n = 0.0, top = 0.0;
  for (const std::uint32_t c : p.cells) {
    top = std::max(top, target.cells[c]);
    if (!std::isfinite(height.cells[c])) continue;
    mean += height.cells[c];
    n += 1.0;
  }
  mean = ratio(mean, n);
  const auto reference_mean = [&](double q) {
    double sum = 0.0;
    for (const std::uint32_t c : p.cells)
      if (std::isfinite(height.cells[c])) sum += std::min(target.cells[c], q);
    return ratio(sum, n);
  };
  double low = std::min(0.0, mean), high = std::max(top, mean);
  for (int step = 0; step < 40; ++step) {
    const double q = 0.5 * (low + high);
    (reference_mean(q) < mean ? low : high) = q;
  }
  std::vector<double> out(height.cells.size(), kNotMeasured);
  for (const std::uint32_t c : p.cells) out[c] = (height.cells[c] - std::min(target.cells[c], high)) * kUm;
  return out;
}

/// The smallest mean of a column or row of inside cells.
double lowest_line(const Places& p, const std::vector<double>& value, bool columns) {
  std::vector<Moments> lines(std::size_t(columns ? p.grid.nx : p.grid.ny));
  for (const std::uint32_t c : p.inside)
    if (std::isfinite(value[c]))
      lines[std::size_t(columns ? int(c) % p.grid.nx : int(c) / p.grid.nx)].add(value[c]);
  double lowest = 0.0;
  for (const Moments& l : lines)
    if (l.n >= 3.0) lowest = std::min(lowest, l.mean() * std::sqrt(l.n));
  return lowest;
}

int fired_at(const droplet::PrintedLayer& l, const GridSpec& grid, int i, int j) {
  return grid.contains(i, j) ? int(l.fired.at(i, j)) : 0;
}

/// Regressions of the residual growth of inside cells.
struct GrowthPatterns {
  Regression rows;   ///< on the row's place in the part, from -1/2 to 1/2
  Regression ring;   ///< on the droplets two cells away
  Regression sides;  ///< on the droplets at the sides less those at the corners

  /// @param residual of a layer, its mean 0
  void take(const droplet::PrintedLayer& l, const Places& p, const std::vector<double>& residual) {
    const int width = p.grid.nx;
    for (const std::uint32_t c : p.inside) {
      if (!std::isfinite(residual[c])) continue;
      const int i = int(c) % width, j = int(c) / width;
      const auto at = [&](int a, int b) { return fired_at(l, p.grid, i + a, j + b); };
      double near = 0.0, far = 0.0;
      for (int b = -2; b <= 2; ++b)
        for (int a = -2; a <= 2; ++a) (std::max(std::abs(a), std::abs(b)) == 2 ? far : near) += at(a, b);
      const double side = at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1);
      rows.add(double(j) / p.grid.ny - 0.5, residual[c]);
      ring.add(far, residual[c]);
      sides.add(2.0 * side - (near - at(0, 0)), residual[c]);
    }
  }
};

/// One stretch of layers.
class Stretch {
 public:
  Stretch(const FeatureInput& input, const Places& places, std::size_t first, std::size_t last)
      : in_(input), p_(places), first_(first), last_(last) {}

  std::array<double, kPerStretch> features() {
    regress();
    residuals();
    surface();
    droplets();
    return out_;
  }

 private:
  static bool counts(const droplet::PrintedLayer& l, std::uint32_t c) {
    return l.use[c] != droplet::Use::kNothing && std::isfinite(l.after.cells[c]) &&
           std::isfinite(l.before.cells[c]);
  }

  static double rise_um(const droplet::PrintedLayer& l, std::uint32_t c) {
    return (l.after.cells[c] - l.before.cells[c]) * kUm;
  }

  Eigen::Vector3d inputs(const droplet::PrintedLayer& l, std::uint32_t c) const {
    const std::uint32_t w = std::uint32_t(p_.grid.nx);
    const std::uint32_t around[8] = {c - 1, c + 1, c - w, c + w, c - w - 1, c - w + 1, c + w - 1, c + w + 1};
    double drops = 0.0, lower = 0.0, n = 0.0;
    for (const std::uint32_t a : around) {
      drops += l.fired.cells[a];
      if (!std::isfinite(l.before.cells[a])) continue;
      lower += l.before.cells[a];
      n += 1.0;
    }
    return {double(l.fired.cells[c]), drops, (ratio(lower, n) - l.before.cells[c]) * kUm};
  }

  /// Growth of an inside cell by its own droplets, those around it and the height of its neighbours over it.
  void regress() {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double rise_in = 0.0, drops_in = 0.0, rise_all = 0.0, drops_all = 0.0, missing = 0.0, cells = 0.0;
    for (std::size_t k = first_; k < last_; ++k) {
      const droplet::PrintedLayer& l = in_.layers[k];
      for (const std::uint32_t c : p_.cells) {
        cells += 1.0;
        if (!counts(l, c)) {
          missing += 1.0;
          continue;
        }
        rise_all += rise_um(l, c);
        drops_all += l.fired.cells[c];
      }
      for (const std::uint32_t c : p_.inside) {
        if (!counts(l, c)) continue;
        const Eigen::Vector3d x = inputs(l, c);
        normal += x * x.transpose();
        right += x * rise_um(l, c);
        rise_in += rise_um(l, c);
        drops_in += l.fired.cells[c];
      }
    }
    normal.diagonal().array() += kRidge * cells + 1e-9;
    response_ = normal.llt().solve(right);
    out_[0] = ratio(rise_in, drops_in);
    out_[1] = ratio(rise_all - rise_in, drops_all - drops_in);
    out_[2] = response_[0];
    out_[3] = response_[1];
    out_[4] = response_[2];
    out_[15] = log_share(ratio(missing, cells));
  }

  void residuals() {
    const std::size_t layers = last_ - first_;
    std::vector<std::vector<double>> r(layers, std::vector<double>(p_.grid.size(), kNotMeasured));
    Moments scatter, growth, change;
    GrowthPatterns patterns;
    std::vector<std::array<double, 2>> by_number;  // of a layer's droplets, and its growth by one of them
    double waves = 0.0, wave_layers = 0.0, before = kNotMeasured;
    std::vector<double> all;
    for (std::size_t n = 0; n < layers; ++n) {
      const droplet::PrintedLayer& l = in_.layers[first_ + n];
      Moments layer;
      double expected = 0.0;
      for (const std::uint32_t c : p_.inside) {
        if (!counts(l, c)) continue;
        const double told = inputs(l, c).dot(response_);
        r[n][c] = rise_um(l, c) - told;
        expected += told;
        layer.add(r[n][c]);
      }
      if (layer.n < 2.0) continue;
      for (const std::uint32_t c : p_.inside)
        if (std::isfinite(r[n][c])) r[n][c] -= layer.mean();
      for (const std::uint32_t c : p_.inside)
        if (std::isfinite(r[n][c])) all.push_back(r[n][c]);
      patterns.take(l, p_, r[n]);
      scatter.n += layer.n - 1.0;
      scatter.squares += layer.variance() * (layer.n - 1.0);
      waves += long_wave_share(p_, r[n]);
      wave_layers += 1.0;
      // A layer of few droplets has no relative growth.
      if (expected / layer.n < 0.3 * std::abs(out_[0])) continue;
      const double relative = layer.mean() * layer.n / expected;
      growth.add(relative);
      by_number.push_back({std::log(expected / layer.n), relative});
      if (std::isfinite(before)) change.add(relative - before);
      before = relative;
    }
    const double variance = ratio(scatter.squares, scatter.n);
    double pairs = 0.0, product = 0.0;
    Moments lasting;
    std::vector<double> mean(p_.grid.size(), kNotMeasured);
    for (const std::uint32_t c : p_.inside) {
      Moments cell;
      for (std::size_t n = 0; n < layers; ++n) {
        if (!std::isfinite(r[n][c])) continue;
        cell.add(r[n][c]);
        if (n == 0 || !std::isfinite(r[n - 1][c])) continue;
        product += r[n][c] * r[n - 1][c];
        pairs += 1.0;
      }
      if (cell.n < 2.0) continue;
      mean[c] = cell.mean();
      lasting.add(cell.mean() * std::sqrt(cell.n));
    }
    out_[5] = log_scale(std::sqrt(variance));
    out_[6] = ratio(ratio(product, pairs), variance);
    out_[7] = ratio(lasting.variance(), variance);
    out_[8] = log_share(ratio(waves, wave_layers));
    out_[9] = log_share(low_share(all));
    out_[10] = log_scale(std::sqrt(ratio(change.squares, change.n)) + 1e-3);
    out_[11] = log_scale(growth.std() + 1e-3);
    out_[17] = patterns.rows.slope();
    out_[18] = growth_by_number(by_number);
    out_[19] = patterns.ring.slope();
    out_[20] = patterns.sides.slope();
    out_[25] = ratio(lowest_line(p_, mean, true) * std::sqrt(double(layers)), std::sqrt(variance));
    out_[26] = ratio(lowest_line(p_, mean, false) * std::sqrt(double(layers)), std::sqrt(variance));
  }

  /// Covariance of a layer's relative growth with the logarithm of its droplets, over its standard deviation.
  static double growth_by_number(const std::vector<std::array<double, 2>>& layers) {
    Regression p;
    for (const auto& [number, relative] : layers) p.add(number, relative);
    return p.covariance() / (p.x.std() + 0.02);
  }

  static double low_share(const std::vector<double>& r) {
    if (r.empty()) return 0.0;
    std::vector<double> size;
    for (const double v : r) size.push_back(std::abs(v));
    const double scale = statistics::kMadToStd * statistics::upper_median(size);
    const auto low = std::ranges::count_if(r, [&](double v) { return v < -kTail * scale; });
    return double(low) / double(r.size());
  }

  void surface() {
    double rough = 0.0, low = 0.0, high = 0.0, x = 0.0, y = 0.0;
    for (std::size_t k = first_; k < last_; ++k) {
      const std::vector<double> e = levelled(p_, in_.layers[k].after, in_.target);
      Moments m;
      for (const std::uint32_t c : p_.cells)
        if (std::isfinite(e[c])) m.add(e[c]);
      rough += m.variance();
      low += long_wave_share(p_, e);
      high += short_wave_share(p_, e);
      x += tilt(p_, e, true);
      y += tilt(p_, e, false);
    }
    const double layers = double(last_ - first_);
    out_[12] = log_scale(std::sqrt(rough / layers));
    out_[13] = log_share(low / layers);
    out_[14] = high / layers;
    out_[21] = x / layers;
    out_[22] = y / layers;
  }

  /// Where droplets lie. Growth beyond that of the mean response is correlated with the difference of the
  /// droplets on either side: it has the sign of the displacement. By row, and with the sign of the stage's
  /// way, because a droplet that keeps the stage's speed is displaced the other way where the stage comes
  /// back.
  void droplets() {
    const std::uint32_t width = std::uint32_t(p_.grid.nx);
    std::vector<double> number(p_.grid.size(), kNotMeasured);
    for (const std::uint32_t c : p_.cells) number[c] = 0.0;
    double all = 0.0, along_x = 0.0, along_y = 0.0, along_way = 0.0, x_squares = 0.0, y_squares = 0.0;
    Moments residual, rows;
    for (std::size_t k = first_; k < last_; ++k) {
      const droplet::PrintedLayer& l = in_.layers[k];
      std::vector<double> row_product(std::size_t(p_.grid.ny), 0.0), row_squares(row_product);
      for (const std::uint32_t c : p_.cells) {
        number[c] += l.fired.cells[c];
        all += l.fired.cells[c];
        if (!counts(l, c)) continue;
        const int i = int(c % width), j = int(c / width);
        const double x = fired_at(l, p_.grid, i - 1, j) - fired_at(l, p_.grid, i + 1, j),
                     y = fired_at(l, p_.grid, i, j - 1) - fired_at(l, p_.grid, i, j + 1);
        double around = -double(l.fired.cells[c]);
        for (int b = -1; b <= 1; ++b)
          for (int a = -1; a <= 1; ++a) around += fired_at(l, p_.grid, i + a, j + b);
        const double r = rise_um(l, c) - response_[0] * l.fired.cells[c] - response_[1] * around;
        residual.add(r);
        along_x += x * r;
        along_way += towards_plus_x(j) ? x * r : -x * r;
        along_y += y * r;
        x_squares += x * x;
        y_squares += y * y;
        row_product[std::size_t(j)] += x * r;
        row_squares[std::size_t(j)] += x * x;
      }
      for (std::size_t j = 0; j < row_product.size(); ++j)
        if (row_squares[j] > 0.0) rows.add(row_product[j] / std::sqrt(row_squares[j]));
    }
    for (const std::uint32_t c : p_.cells) number[c] *= ratio(double(p_.cells.size()), all);
    out_[23] = tilt(p_, number, true);
    out_[24] = tilt(p_, number, false);
    out_[27] = ratio(along_x, x_squares);
    out_[28] = ratio(along_y, y_squares);
    out_[29] = ratio(ratio(rows.squares, rows.n), residual.variance());
    out_[16] = ratio(along_way, x_squares);
  }

  const FeatureInput& in_;
  const Places& p_;
  std::size_t first_, last_;
  Eigen::Vector3d response_ = Eigen::Vector3d::Zero();
  std::array<double, kPerStretch> out_{};
};

/// Growth of the part by one of its droplets, over layers [first, last).
double growth_by_droplet(const FeatureInput& in, std::size_t first, std::size_t last) {
  double rise = 0.0, drops = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    const droplet::PrintedLayer& l = in.layers[k];
    for (std::size_t c = 0; c < in.mask.size(); ++c) {
      if (!in.mask.cells[c] || !std::isfinite(l.after.cells[c]) || !std::isfinite(l.before.cells[c]))
        continue;
      rise += (l.after.cells[c] - l.before.cells[c]) * kUm;
      drops += l.fired.cells[c];
    }
  }
  return ratio(rise, drops);
}

std::array<double, kWhole> whole(const FeatureInput& in) {
  double droplets = 0.0;
  for (const auto& l : in.layers)
    for (const auto n : l.fired.cells) droplets += n;
  const std::size_t first = std::max<std::size_t>(1, in.layers.size() / 6);
  const double early = growth_by_droplet(in, 0, first),
               later = growth_by_droplet(in, first, in.layers.size());
  const ErrorStats e = error_stats(in.layers.back().after, in.target, in.mask);
  return {log_scale(in.noise_std_mm * kUm),
          std::log(double(in.layers.size())),
          std::log(droplets + 1.0),
          e.mean_mm * kUm,
          log_scale(e.rms_mm * kUm),
          log_scale(std::max(std::abs(e.min_mm), std::abs(e.max_mm)) * kUm),
          ratio(early, later)};
}

void check_sizes(const FeatureInput& in) {
  if (in.layers.size() < std::size_t(kMinLayers))
    throw std::invalid_argument(std::to_string(in.layers.size()) +
                                (in.layers.size() == 1 ? " measured layer" : " measured layers") +
                                ", at least " + std::to_string(kMinLayers) + " are needed");
  for (const auto& l : in.layers)
    if (l.after.size() != in.mask.size() || in.target.size() != in.mask.size() ||
        l.use.size() != in.mask.size())
      throw std::invalid_argument("maps, mask and target differ in size");
}

}  // namespace

std::size_t feature_count() { return (kStretches + 1) * kPerStretch + kWhole; }

std::string feature_name(std::size_t feature) {
  const std::size_t stretch = feature / kPerStretch;
  if (stretch > std::size_t(kStretches)) return kWholeNames[feature - (kStretches + 1) * kPerStretch];
  const std::string name = kStretchNames[feature % kPerStretch];
  if (stretch == std::size_t(kStretches)) return name;
  return name + " in the " + kStretchWords[stretch] + " third of the layers";
}

std::vector<std::size_t> fitted_features() {
  std::vector<std::size_t> out = features_of_stretch(kStretches);
  for (std::size_t n = 0; n < kWhole; ++n) out.push_back((kStretches + 1) * kPerStretch + n);
  return out;
}

std::vector<std::size_t> features_of_stretch(int stretch) {
  std::vector<std::size_t> out;
  for (std::size_t n = 0; n < kFirstSymmetric; ++n) out.push_back(std::size_t(stretch) * kPerStretch + n);
  return out;
}

std::vector<std::size_t> checked_features() {
  std::vector<std::size_t> out;
  for (std::size_t f = 0; f < feature_count(); ++f)
    if (f / kPerStretch != std::size_t(kStretches)) out.push_back(f);
  return out;
}

std::vector<double> layer_features(const FeatureInput& input) {
  check_sizes(input);
  const Places places = places_of(input.mask);
  std::vector<double> out, means(kPerStretch, 0.0);
  for (int s = 0; s < kStretches; ++s) {
    const std::size_t layers = input.layers.size();
    const auto f =
        Stretch(input, places, layers * std::size_t(s) / kStretches, layers * std::size_t(s + 1) / kStretches)
            .features();
    out.insert(out.end(), f.begin(), f.end());
    for (std::size_t n = 0; n < kPerStretch; ++n) means[n] += f[n] / kStretches;
  }
  out.insert(out.end(), means.begin(), means.end());
  const auto w = whole(input);
  out.insert(out.end(), w.begin(), w.end());
  for (double& v : out)
    if (!std::isfinite(v)) v = 0.0;
  return out;
}

}  // namespace firn::lab
