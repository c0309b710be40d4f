#include "core/vision/illumination.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>

#include "core/statistics/median.h"
#include "core/vision/illumination_kernels.h"
#include "core/vision/least_squares.h"
#include "core/vision/raster.h"

namespace firn::vision {
namespace {

// Values without another reason were chosen on rendered pictures (tests/bench/droplet_pictures.cpp, seeds
// below 50,000). Shares of the white level have no unit.

// Noise: pixels that are compared with that two to the right.
constexpr int kNoiseRows = 48, kNoiseStep_px = 5;

// Ground: a polynomial through the medians of tiles.
constexpr int kTiles = 32;                                       // along the longer side
constexpr std::array kTerms{1, 3, 3, 6, 6, 10, 10, 10};          // of each fit: level, plane, quadric, cubic
constexpr double kMaxResidualPlane = 0.12, kMaxResidual = 0.06;  // share of white; up to 3 terms, from 6 on
constexpr std::size_t kMinTiles = 12;  // that a fit needs; else the one before stands
constexpr double kResidualStds = 3.5;  // a tile farther off belongs to an object; but within
constexpr double kMinResidualNoise = 2.0, kMinResidualWhite = 0.01;  // … of the noise, of white it does not
constexpr double kRidge = 1e-4;            // of terms in use; 1 of the others: grounds in few tiles
constexpr double kMaxUneven = 0.15;        // share of the depth: a larger residual is an object's
constexpr std::size_t kMinNeighbours = 3;  // tiles of 3 x 3 whose median is a residual

// Depth of objects below the ground.
constexpr double kMinDepth = 0.06, kMinDepthStds = 3.0;  // share of white; of the noise
constexpr std::size_t kDeepestRank = 2;                  // block that is the deepest: two may be specks
constexpr float kNearlyDeepest = 0.85f;                  // of its depth: blocks whose median is opaque
constexpr std::size_t kDepthStep = 13;                   // blocks apart whose ground gives the typical depth
constexpr std::size_t kBlocksAtOnce = 64;
constexpr double kRounding = 0.999;  // of a contrast in float, lest one just above the limit be passed over

struct Blocks {
  int columns = 0, rows = 0;
  std::vector<float> mean;
  std::vector<std::uint16_t> min, max;
};

void add_row(const std::uint16_t* row, int n, std::uint32_t* sum, std::uint16_t* low, std::uint16_t* high) {
  for (int x = 0; x < n; ++x) {
    sum[x] += row[x];
    low[x] = std::min(low[x], row[x]);
    high[x] = std::max(high[x], row[x]);
  }
}

Blocks measure_blocks(const Frame& f) {
  Blocks b;
  b.columns = (f.width + kBlock - 1) / kBlock;
  b.rows = (f.height + kBlock - 1) / kBlock;
  const std::size_t n = std::size_t(b.columns) * std::size_t(b.rows);
  b.mean.resize(n);
  b.min.resize(n);
  b.max.resize(n);
  static_assert(kBlock == 4);
  const std::size_t w = std::size_t(b.columns) * kBlock;
  std::vector<std::uint32_t> sum(w);
  std::vector<std::uint16_t> low(w), high(w);
  for (int by = 0; by < b.rows; ++by) {
    const int height = std::min(kBlock, f.height - by * kBlock);
    if (height == kBlock) {
      illumination_kernels().add_rows(&f.pixels[f.index(0, by * kBlock)], std::size_t(f.width), f.width,
                                      sum.data(), low.data(), high.data());
    } else {
      std::fill(sum.begin(), sum.end(), 0u);
      std::fill(low.begin(), low.end(), std::uint16_t(65535));
      std::fill(high.begin(), high.end(), std::uint16_t(0));
      for (int dy = 0; dy < height; ++dy)
        add_row(&f.pixels[f.index(0, by * kBlock + dy)], f.width, sum.data(), low.data(), high.data());
    }
    const std::size_t line = std::size_t(by) * std::size_t(b.columns);
    const int whole = height == kBlock ? f.width / kBlock : 0;
    illumination_kernels().join_blocks(whole, sum.data(), low.data(), high.data(), &b.mean[line],
                                       &b.min[line], &b.max[line]);
    for (int bx = whole; bx < b.columns; ++bx) {
      const int width = std::min(kBlock, f.width - bx * kBlock);
      std::uint32_t s = 0;
      std::uint16_t lo = 65535, hi = 0;
      for (int dx = 0; dx < width; ++dx) {
        const std::size_t x = std::size_t(bx) * kBlock + std::size_t(dx);
        s += sum[x];
        lo = std::min(lo, low[x]);
        hi = std::max(hi, high[x]);
      }
      const std::size_t i = line + std::size_t(bx);
      b.mean[i] = float(double(s) / double(width * height));
      b.min[i] = lo;
      b.max[i] = hi;
    }
  }
  return b;
}

// Median of |difference| of neighbours two pixels apart, over a sample of rows. An interpolated or compressed
// picture has noise that is alike in neighbours.
double measure_noise(const Frame& f) {
  std::vector<int> d;
  const int step = std::max(1, f.height / kNoiseRows);
  for (int y = step / 2; y < f.height; y += step)
    for (int x = 0; x + 2 < f.width; x += kNoiseStep_px)
      d.push_back(std::abs(int(f.at(x, y)) - int(f.at(x + 2, y))));
  // Whole grey levels: the median of a rounded value is interpolated inside its level.
  const int middle = statistics::upper_median(d);
  const auto below = std::ranges::count_if(d, [&](int v) { return v < middle; });
  const double share = (0.5 * double(d.size()) - double(below)) / double(std::ranges::count(d, middle));
  const double width = middle == 0 ? 0.5 : 1.0, begin = middle == 0 ? 0.0 : middle - 0.5;
  return statistics::kMadToStd * (begin + width * share) / std::sqrt(2.0);
}

struct Tile {
  double x, y, level;
};

// statistics::upper_median of whole numbers: halving the range between the least and the largest needs counts
// alone, which are vector instructions.
std::int32_t level_median(const std::vector<std::int32_t>& levels) {
  const int n = int(levels.size());
  std::int32_t least = 0, largest = 0;
  illumination_kernels().extremes(levels.data(), n, least, largest);
  while (least < largest) {
    const std::int32_t middle = least + (largest - least) / 2;
    if (illumination_kernels().count_up_to(levels.data(), n, middle) > n / 2)
      largest = middle;
    else
      least = middle + 1;
  }
  return least;
}

// @param whole_columns, whole_rows blocks of kBlock x kBlock pixels, whose means are multiples of 1/16
std::vector<Tile> measure_tiles(const Blocks& b, int whole_columns, int whole_rows, int& columns, int& rows) {
  const int side = std::max(1, std::max(b.columns, b.rows) / kTiles);
  columns = (b.columns + side - 1) / side;
  rows = (b.rows + side - 1) / side;
  std::vector<Tile> tiles;
  std::vector<std::int32_t> values;
  for (int ty = 0; ty < rows; ++ty)
    for (int tx = 0; tx < columns; ++tx) {
      const int x0 = tx * side, x1 = std::min(b.columns, x0 + side), y0 = ty * side,
                y1 = std::min(b.rows, y0 + side), width = x1 - x0;
      const bool whole = x1 <= whole_columns && y1 <= whole_rows;
      values.resize(std::size_t(width) * std::size_t(y1 - y0));
      for (int y = y0; y < y1; ++y) {
        const float* from = &b.mean[std::size_t(y) * std::size_t(b.columns) + std::size_t(x0)];
        std::int32_t* to = &values[std::size_t(y - y0) * std::size_t(width)];
        if (whole)
          illumination_kernels().scale_by_16(from, width, to);
        else  // the bits of levels, which are not negative, have their order
          for (int x = 0; x < width; ++x) to[x] = std::bit_cast<std::int32_t>(from[x]);
      }
      const std::int32_t median = level_median(values);
      const float level = whole ? float(median) / 16 : std::bit_cast<float>(median);
      tiles.push_back({0.5 * (x0 + x1 - 1), 0.5 * (y0 + y1 - 1), double(level)});
    }
  return tiles;
}

// Half-sample mode [Robertson and Cryer 1974]: the densest half of the densest half …
double half_sample_mode(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  std::size_t from = 0, n = v.size();
  while (n > 2) {
    const std::size_t half = (n + 1) / 2;
    std::size_t best = from;
    for (std::size_t i = from; i + half <= from + n; ++i)
      if (v[i + half - 1] - v[i] < v[best + half - 1] - v[best]) best = i;
    from = best;
    n = half;
  }
  return 0.5 * (v[from] + v[from + n - 1]);
}

using Cubic = SmallLeastSquares<10>::Row;

Cubic powers(double x, double y) {
  return {1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y};
}

double value(const Cubic& c, double x, double y) {
  const Cubic p = powers(x, y);
  double s = 0.0;
  for (int i = 0; i < 10; ++i) s += c[i] * p[i];
  return s;
}

// Tiles near the most frequent level, then a plane, a quadric and a cubic, each through the tiles that the
// one before explains.
Cubic fit_ground(const std::vector<Tile>& tiles, double cx, double cy, double size, double noise,
                 double white) {
  std::vector<double> levels;
  for (const Tile& t : tiles) levels.push_back(t.level);
  Cubic ground{half_sample_mode(levels)};
  for (const int terms : kTerms) {
    std::vector<double> near;
    const double widest = (terms <= 3 ? kMaxResidualPlane : kMaxResidual) * white;
    for (const Tile& t : tiles) {
      const double r = std::abs(t.level - value(ground, (t.x - cx) / size, (t.y - cy) / size));
      if (r < widest) near.push_back(r);
    }
    if (near.size() < kMinTiles) break;
    const double spread = statistics::kMadToStd * statistics::median(near);
    const double limit = std::min(
        widest, std::max({kResidualStds * spread, kMinResidualNoise * noise, kMinResidualWhite * white}));
    SmallLeastSquares<10> sums;
    for (const Tile& t : tiles) {
      const double x = (t.x - cx) / size, y = (t.y - cy) / size;
      if (std::abs(t.level - value(ground, x, y)) > limit) continue;
      Cubic row = powers(x, y);
      for (int i = terms; i < 10; ++i) row[i] = 0.0;
      sums.add(row, t.level, 1.0);
    }
    for (int i = 0; i < 10; ++i) {
      Cubic one{};
      one[i] = 1.0;
      sums.add(one, 0.0, i < terms ? kRidge : 1.0);
    }
    Cubic next{};
    if (!sums.solve(next)) break;
    ground = next;
  }
  return ground;
}

// Residuals of the cubic: the median of 3 x 3 tiles' residuals; tiles that differ by more belong to objects.
std::vector<double> uneven_residuals(const std::vector<Tile>& tiles, int columns, int rows, double limit,
                                     const std::vector<double>& ground) {
  std::vector<double> residual(tiles.size()), result(tiles.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) residual[i] = tiles[i].level - ground[i];
  std::vector<double> near;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      near.clear();
      for (int v = std::max(0, y - 1); v <= std::min(rows - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(columns - 1, x + 1); ++u) {
          const double r = residual[std::size_t(v) * std::size_t(columns) + std::size_t(u)];
          if (std::abs(r) < limit) near.push_back(r);
        }
      const std::size_t i = std::size_t(y) * std::size_t(columns) + std::size_t(x);
      result[i] = near.size() >= kMinNeighbours ? statistics::median(near) : 0.0;
    }
  return result;
}

// Bilinear between the tiles' middles.
void add_tiles(const std::vector<double>& tiles, int columns, int rows, Illumination& illumination) {
  const int side = std::max(1, std::max(illumination.columns, illumination.rows) / kTiles);
  std::vector<double> line(static_cast<std::size_t>(columns)), share(std::size_t(illumination.columns));
  std::vector<int> first;  // block of each span between two tiles
  for (int x = 0, span = -1; x < illumination.columns; ++x) {
    const double tx = std::clamp((x - 0.5 * (side - 1)) / side, 0.0, double(columns - 1));
    const int x0 = std::min(int(tx), std::max(0, columns - 2));
    share[std::size_t(x)] = tx - x0;
    for (; span < x0; ++span) first.push_back(x);
  }
  first.push_back(illumination.columns);
  for (int y = 0; y < illumination.rows; ++y) {
    const double ty = std::clamp((y - 0.5 * (side - 1)) / side, 0.0, double(rows - 1));
    const int y0 = std::min(int(ty), std::max(0, rows - 2)), y1 = std::min(y0 + 1, rows - 1);
    const auto at = [&](int i, int j) {
      return tiles[std::size_t(j) * std::size_t(columns) + std::size_t(i)];
    };
    for (int i = 0; i < columns; ++i) line[std::size_t(i)] = at(i, y0) + (ty - y0) * (at(i, y1) - at(i, y0));
    float* ground = &illumination.ground[std::size_t(y) * std::size_t(illumination.columns)];
    for (std::size_t i = 0; i + 1 < first.size(); ++i) {
      const double from = line[i], to = line[std::min(i + 1, line.size() - 1)];
      illumination_kernels().add_line(&share[std::size_t(first[i])], first[i + 1] - first[i], from, to - from,
                                      ground + first[i]);
    }
  }
}

// Level of opaque objects: the median of the blocks that are nearly as dark as the darkest.
double dark_level(const Blocks& b, const std::vector<float>& ground, double min_contrast, bool& empty) {
  std::vector<float> contrast, means;
  const float nearly = float(kRounding * min_contrast);
  for (std::size_t from = 0; from < b.mean.size(); from += kBlocksAtOnce) {
    const std::size_t to = std::min(b.mean.size(), from + kBlocksAtOnce);
    if (!illumination_kernels().any_deeper(&ground[from], &b.mean[from], int(to - from), nearly)) continue;
    for (std::size_t i = from; i < to; ++i)
      if (double(ground[i] - b.mean[i]) > min_contrast) {
        contrast.push_back(ground[i] - b.mean[i]);
        means.push_back(b.mean[i]);
      }
  }
  empty = contrast.empty();
  if (empty) return 0.0;
  std::vector<float> sorted(contrast);
  const std::size_t rank = std::min<std::size_t>(sorted.size() - 1, kDeepestRank);
  std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(rank), sorted.end(), std::greater<>());
  const float deepest = sorted[rank];
  std::vector<float> levels;
  for (std::size_t i = 0; i < contrast.size(); ++i)
    if (contrast[i] >= kNearlyDeepest * deepest) levels.push_back(means[i]);
  if (levels.empty()) return 0.0;
  return double(statistics::upper_median(levels));
}

// Levels of the inverted picture.
void invert(int white, Blocks& b, std::vector<Tile>& tiles, Illumination& illumination) {
  for (std::size_t i = 0; i < b.mean.size(); ++i) {
    b.mean[i] = float(white) - b.mean[i];
    illumination.ground[i] = float(white) - illumination.ground[i];
    b.min[i] = std::uint16_t(white - std::min<int>(white, b.max[i]));
  }
  for (Tile& t : tiles) t.level = white - t.level;
}

}  // namespace

Illumination measure_illumination(const Frame& frame, Polarity polarity, Frame& inverted) {
  Blocks b = measure_blocks(frame);
  Illumination illumination;
  illumination.columns = b.columns;
  illumination.rows = b.rows;
  illumination.noise = measure_noise(frame);
  int columns = 0, rows = 0;
  std::vector<Tile> tiles = measure_tiles(b, frame.width / kBlock, frame.height / kBlock, columns, rows);
  const double cx = 0.5 * (b.columns - 1), cy = 0.5 * (b.rows - 1), size = 0.5 * std::max(b.columns, b.rows);
  const double white = frame.white;
  Cubic cubic = fit_ground(tiles, cx, cy, size, illumination.noise, white);
  illumination.ground.resize(b.mean.size());
  ContrastSums sums;
  const double min_depth = std::max(kMinDepth * white, kMinDepthStds * illumination.noise);
  std::vector<double> u(std::size_t(b.columns));
  for (int x = 0; x < b.columns; ++x) u[std::size_t(x)] = (x - cx) / size;
  for (int y = 0; y < b.rows; ++y) {
    const double v = (y - cy) / size;
    const std::array<double, 4> k{cubic[0] + v * (cubic[2] + v * (cubic[5] + v * cubic[9])),
                                  cubic[1] + v * (cubic[4] + v * cubic[8]), cubic[3] + v * cubic[7],
                                  cubic[6]};
    const std::size_t row = std::size_t(y) * std::size_t(b.columns);
    illumination_kernels().cubic_row(u.data(), b.columns, k, white, min_depth, &b.mean[row],
                                     &illumination.ground[row], sums);
  }
  illumination.inverted =
      polarity == Polarity::kBright || (polarity == Polarity::kAuto && sums.brighter > sums.darker);
  illumination.opposite = std::min(sums.darker, sums.brighter) / std::max({sums.darker, sums.brighter, 1.0});
  if (illumination.inverted) {
    inverted = inverted_frame(frame);
    invert(frame.white, b, tiles, illumination);
  }
  illumination.dark = dark_level(b, illumination.ground, min_depth, illumination.empty);
  illumination.min_pixel = std::move(b.min);
  if (illumination.empty) return illumination;

  const auto depth = [&] {
    std::vector<float> g;
    for (std::size_t i = 0; i < illumination.ground.size(); i += kDepthStep)
      g.push_back(illumination.ground[i]);
    return std::max(1.0, double(statistics::upper_median(g)) - illumination.dark);
  };
  illumination.depth = depth();
  std::vector<double> at_tiles;
  for (const Tile& t : tiles)
    at_tiles.push_back(
        double(illumination.ground[std::size_t(int(t.y)) * std::size_t(b.columns) + std::size_t(int(t.x))]));
  const std::vector<double> rest =
      uneven_residuals(tiles, columns, rows, kMaxUneven * illumination.depth, at_tiles);
  add_tiles(rest, columns, rows, illumination);
  illumination.depth = depth();
  return illumination;
}

}  // namespace firn::vision
