#include "core/vision/line_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/statistics/median.h"
#include "core/vision/least_squares.h"

namespace firn::vision {
namespace {

constexpr double kUnread = std::numeric_limits<double>::quiet_NaN();
constexpr double kBesideWidths = 1.3;    // from the middle on: overspray
constexpr double kFarShare = 0.88;       // of the window: the ground alone
constexpr double kPixelArea = 1.0 / 12;  // variance of a pixel's own square [px^2]
constexpr double kBilinear = 1.0 / 6;    // and, in the mean, of bilinear interpolation
constexpr double kEdgeFloor_px = 0.09;   // of an edge: pixel grid, uneven ground
constexpr double kWidthFloor = 0.003;    // of the width
constexpr double kGapFloor_px = 0.28;    // of a gap's end
constexpr double kHaloShare = 0.28;      // of the overspray: what lies beyond the window or counts as ground
constexpr double kFewSaturated = 0.02;   // of the samples
constexpr double kClipped = 0.015;       // of the light, where more of them are: that is not known
constexpr double kLeastContrast = 0.02;
constexpr double kSmallestGap_px = 3.0;
constexpr int kBinRows = 12;

// Samples of a strip about the wanted line: row a along it, column c across it.
struct Strip {
  int rows = 0, columns = 0;
  double first_along_px = 0.0, first_across_px = 0.0;  // of row 0 and column 0; 1 px apart
  std::vector<double> value;                           // NaN beside the picture
  double saturated = 0.0;                              // share of the samples
  double interpolation = 0.0;                          // variance of the blur that sampling added [px^2]

  double& at(int a, int c) { return value[std::size_t(a) * std::size_t(columns) + std::size_t(c)]; }
  double at(int a, int c) const { return value[std::size_t(a) * std::size_t(columns) + std::size_t(c)]; }
  double across_px(double c) const { return first_across_px + c; }
};

double sampled(const Frame& f, const Frame* flat, double x, double y) {
  if (!(x >= 0.0 && y >= 0.0 && x <= f.width - 1.0 && y <= f.height - 1.0)) return kUnread;
  const int i = std::min(int(x), f.width - 2), j = std::min(int(y), f.height - 2);
  const double u = x - i, v = y - j;
  const auto level = [&](int a, int b) {
    const double p = double(f.at(a, b));
    return flat ? p * double(flat->white) / std::max(1.0, double(flat->at(a, b))) : p;
  };
  return (1 - v) * ((1 - u) * level(i, j) + u * level(i + 1, j)) +
         v * ((1 - u) * level(i, j + 1) + u * level(i + 1, j + 1));
}

// Along an axis of the picture the samples are its pixels: interpolation would blur them.
Strip sample_strip(const Frame& f, const Frame* flat, const LineView& view) {
  Strip s;
  const Point d = view.direction, left{d.y, -d.x};
  const bool aligned = std::min(std::abs(d.x), std::abs(d.y)) < 1e-9;
  const double half = std::floor(view.window_px);
  s.columns = 2 * int(half) + 1;
  s.rows = std::max(1, int(std::floor(view.length_px)));
  s.first_across_px = -half;
  s.first_along_px = -0.5 * (s.rows - 1);
  if (aligned) {
    const auto snap = [](double along_axis) { return std::round(along_axis) - along_axis; };
    const double across = view.middle.x * left.x + view.middle.y * left.y,
                 along = view.middle.x * d.x + view.middle.y * d.y;
    s.first_across_px += snap(across + s.first_across_px);
    s.first_along_px += snap(along + s.first_along_px);
  } else {
    s.interpolation = kBilinear;
  }
  s.value.reserve(std::size_t(s.rows) * std::size_t(s.columns));
  std::size_t white = 0;
  for (int a = 0; a < s.rows; ++a)
    for (int c = 0; c < s.columns; ++c) {
      const double t = s.first_along_px + a, o = s.first_across_px + c;
      const double x = view.middle.x + t * d.x + o * left.x, y = view.middle.y + t * d.y + o * left.y;
      s.value.push_back(sampled(f, flat, x, y));
      if (!std::isnan(s.value.back())) white += f.at(int(x + 0.5), int(y + 0.5)) >= f.white;
    }
  s.saturated = double(white) / double(s.value.size());
  return s;
}

// Turns levels into contrasts, against a quadric through the far columns (a plane over a flat field).
// Returns the standard deviation of the ground's level, relative; nothing where too little of it is seen.
std::optional<double> to_contrast(Strip& s, bool flat) {
  const double window = 0.5 * (s.columns - 1), length = std::max(1.0, 0.5 * s.rows);
  using Quadric = SmallLeastSquares<6>::Row;
  const auto row_of = [&](int a, int c) -> Quadric {
    const double x = (a - 0.5 * (s.rows - 1)) / length, y = (c - window) / window;
    if (flat) return {1, x, y, 0, 0, 0};
    return {1, x, y, x * x, x * y, y * y};
  };
  const auto value_of = [](const Quadric& q, const Quadric& row) {
    double v = 0.0;
    for (int k = 0; k < 6; ++k) v += q[k] * row[k];
    return v;
  };
  std::vector<std::pair<int, int>> far;
  std::vector<double> levels;
  for (int a = 0; a < s.rows; ++a)
    for (int c = 0; c < s.columns; ++c)
      if (std::abs(c - window) >= kFarShare * window && !std::isnan(s.at(a, c))) {
        far.emplace_back(a, c);
        levels.push_back(s.at(a, c));
      }
  if (far.size() < 60) return std::nullopt;
  Quadric ground{statistics::median(levels)};
  double spread = 0.0;
  for (int round = 0; round < 5; ++round) {
    std::vector<double> off;
    for (const auto& [a, c] : far) off.push_back(std::abs(s.at(a, c) - value_of(ground, row_of(a, c))));
    spread = statistics::kMadToStd * statistics::median(off);
    const double limit = std::max(4.0 * spread, 0.004 * std::abs(ground[0]) + 0.5);
    SmallLeastSquares<6> sums;
    for (const auto& [a, c] : far) {
      const Quadric row = row_of(a, c);
      const double q = (s.at(a, c) - value_of(ground, row)) / limit;
      if (q * q < 1.0) sums.add(row, s.at(a, c), (1 - q * q) * (1 - q * q));
    }
    for (int k = 0; k < 6; ++k) {  // of terms that are off, and of strips that are too short
      Quadric one{};
      one[k] = 1.0;
      sums.add(one, 0.0, k == 0 ? 0.0 : 1e-3);
    }
    if (Quadric next{}; sums.solve(next)) ground = next;
  }
  if (!(ground[0] > 0.0)) return std::nullopt;
  for (int a = 0; a < s.rows; ++a)
    for (int c = 0; c < s.columns; ++c)
      if (double& v = s.at(a, c); !std::isnan(v))
        v = 1.0 - v / std::max(0.05 * ground[0], value_of(ground, row_of(a, c)));
  return spread / ground[0] * 2.5 / std::sqrt(double(far.size()));
}

double pixel_noise(const Strip& s) {
  std::vector<double> d;
  for (int a = 0; a + 2 < s.rows; ++a)
    for (int c = a % 3; c < s.columns; c += 3)
      if (const double v = s.at(a, c) - s.at(a + 2, c); !std::isnan(v)) d.push_back(std::abs(v));
  return d.empty() ? 0.0 : statistics::kMadToStd * statistics::median(d) / std::sqrt(2.0);
}

// Mean of the columns over the rows in use; NaN where none is.
std::vector<double> mean_profile(const Strip& s, const std::vector<int>& rows) {
  std::vector<double> sum(std::size_t(s.columns)), out(std::size_t(s.columns), kUnread);
  std::vector<int> n(std::size_t(s.columns));
  for (const int a : rows)
    for (int c = 0; c < s.columns; ++c)
      if (const double v = s.at(a, c); !std::isnan(v)) {
        sum[std::size_t(c)] += v;
        ++n[std::size_t(c)];
      }
  for (std::size_t c = 0; c < sum.size(); ++c)
    if (n[c] > 0) out[c] = sum[c] / n[c];
  return out;
}

// The profile before a blur of this variance, to second order.
std::vector<double> deblurred(const std::vector<double>& p, double variance) {
  std::vector<double> out = p;
  for (std::size_t c = 2; c + 2 < p.size(); ++c) {
    const double bend = 0.25 * (p[c + 2] - 2 * p[c] + p[c - 2]);
    if (!std::isnan(bend)) out[c] -= 0.5 * variance * bend;
  }
  return out;
}

// A parabola through the profile about a place; .level there, .slope and .bend.
struct Local {
  double level = 0.0, slope = 0.0, bend = 0.0;
  int samples = 0;
  bool found = false;
};

Local parabola(const std::vector<double>& p, double place, double half) {
  Local l;
  SmallLeastSquares<3> sums;
  const int from = std::max(0, int(std::ceil(place - half))),
            to = std::min(int(p.size()) - 1, int(std::floor(place + half)));
  for (int c = from; c <= to; ++c) {
    if (std::isnan(p[std::size_t(c)])) continue;
    const double x = c - place;
    sums.add({1, x, x * x}, p[std::size_t(c)], 1.0);
    ++l.samples;
  }
  SmallLeastSquares<3>::Row q{};
  if (l.samples < 4 || !sums.solve(q)) return l;
  return {q[0], q[1], q[2], l.samples, true};
}

// The first place outwards from `from` where the profile falls below the level; NaN: it does not.
double falls_below(const std::vector<double>& p, double from, int step, double level) {
  for (int c = int(from); c + step >= 0 && c + step < int(p.size()); c += step) {
    const double here = p[std::size_t(c)], next = p[std::size_t(c + step)];
    if (std::isnan(next)) return kUnread;
    if (next < level && here >= level) return c + step * (here - level) / (here - next);
  }
  return kUnread;
}

struct Edges {
  double low = kUnread, high = kUnread;  // columns
  double low_slope = 0.0, high_slope = 0.0, peak = 0.0;
  int samples = 0;  // of one edge's parabola
  bool found() const { return !std::isnan(low) && !std::isnan(high); }
};

// Refines a crossing by a parabola about it.
double refined(const std::vector<double>& p, double place, double half, double level, double& slope,
               int& samples) {
  for (int round = 0; round < 3; ++round) {
    const Local l = parabola(p, place, half);
    if (!l.found || l.slope == 0.0) return kUnread;
    slope = l.slope;
    samples = l.samples;
    const double root = l.slope * l.slope - 4 * l.bend * (l.level - level);
    // The root next to the place, in the form that does not cancel.
    const double step =
        root < 0.0 ? -(l.level - level) / l.slope
                   : -2 * (l.level - level) / (l.slope + (l.slope > 0 ? std::sqrt(root) : -std::sqrt(root)));
    place += std::clamp(step, -half, half);
  }
  return place;
}

Edges find_edges(const std::vector<double>& p, double middle, double width, double peak) {
  Edges e;
  e.peak = peak;
  const double half = std::max(2.0, 0.12 * width);
  e.low = falls_below(p, middle, -1, 0.5 * peak);
  e.high = falls_below(p, middle, 1, 0.5 * peak);
  if (!e.found()) return e;
  e.low = refined(p, e.low, half, 0.5 * peak, e.low_slope, e.samples);
  e.high = refined(p, e.high, half, 0.5 * peak, e.high_slope, e.samples);
  return e;
}

double peak_of(const std::vector<double>& p, double middle, double width) {
  const Local l = parabola(p, middle, std::max(2.0, 0.25 * width));
  if (!l.found) return kUnread;
  // The vertex, where it lies inside; else the level.
  const double vertex = l.bend < 0.0 ? l.level - l.slope * l.slope / (4 * l.bend) : l.level;
  return std::abs(vertex - l.level) < 0.1 * std::abs(l.level) ? vertex : l.level;
}

// Weighted mean of values among which few are wrong.
double robust_mean(std::vector<double> v) {
  std::vector<double> copy = v;
  double at = statistics::median(copy);
  for (int round = 0; round < 4; ++round) {
    std::vector<double> off;
    for (const double x : v) off.push_back(std::abs(x - at));
    const double limit = std::max(5.0 * statistics::kMadToStd * statistics::median(off), 1e-6);
    double sum = 0.0, weight = 0.0;
    for (const double x : v) {
      const double q = (x - at) / limit;
      if (q * q >= 1.0) continue;
      const double w = (1 - q * q) * (1 - q * q);
      sum += w * x;
      weight += w;
    }
    if (weight > 0.0) at = sum / weight;
  }
  return at;
}

struct Along {
  std::vector<double> level;  // of the line's middle by row, over the usual one; NaN: beside the picture
  double noise = 0.0;
};

// Rows without material, their limits between rows where the level crosses a half.
std::vector<LineGap> find_gaps(const Along& along) {
  std::vector<LineGap> gaps;
  const auto n = int(along.level.size());
  for (int a = 0; a < n;) {
    if (std::isnan(along.level[std::size_t(a)]) || along.level[std::size_t(a)] >= 0.5) {
      ++a;
      continue;
    }
    int end = a;
    while (end + 1 < n && along.level[std::size_t(end + 1)] < 0.5) ++end;
    const auto crossing = [&](int in, int out, double& slope) {
      const double i = along.level[std::size_t(in)], o = along.level[std::size_t(out)];
      slope = std::abs(o - i);
      return in + (out - in) * (0.5 - i) / (o - i);
    };
    LineGap g;
    double slope[2] = {1.0, 1.0};
    g.from_px = a > 0 && !std::isnan(along.level[std::size_t(a - 1)]) ? crossing(a, a - 1, slope[0]) : a;
    g.to_px = end + 1 < n && !std::isnan(along.level[std::size_t(end + 1)]) ? crossing(end, end + 1, slope[1])
                                                                            : end;
    const double steep = std::max(0.02, std::min(slope[0], slope[1]));
    g.std_px = std::sqrt(along.noise * along.noise / (steep * steep) + kGapFloor_px * kGapFloor_px);
    if (g.to_px - g.from_px >= kSmallestGap_px) {
      // A speck that covers the middle of a gap for a row or two does not divide it.
      if (!gaps.empty() && g.from_px - gaps.back().to_px < kSmallestGap_px)
        gaps.back().to_px = g.to_px;
      else
        gaps.push_back(g);
    }
    a = end + 1;
  }
  return gaps;
}

}  // namespace

Frame flat_field(std::span<const Frame* const> bare) {
  Frame flat;
  if (bare.empty()) return flat;
  const Frame& first = *bare.front();
  std::vector<double> gain;
  double reference = 0.0;
  for (const Frame* f : bare) {
    if (!is_valid(*f) || f->width != first.width || f->height != first.height || f->white != first.white)
      return flat;
    double sum = 0.0;
    for (const std::uint16_t p : f->pixels) sum += double(p);
    if (!(sum > 0.0)) return flat;
    if (reference == 0.0) reference = sum;
    gain.push_back(reference / sum);
  }
  flat = {first.width, first.height, 65535, std::vector<std::uint16_t>(first.pixels.size())};
  const double scale = 0.9 * 65535.0 / first.white;
  std::vector<double> v(bare.size());
  for (std::size_t i = 0; i < flat.pixels.size(); ++i) {
    for (std::size_t k = 0; k < v.size(); ++k) v[k] = gain[k] * double(bare[k]->pixels[i]);
    flat.pixels[i] = std::uint16_t(std::min(65535.0, scale * statistics::median(v) + 0.5));
  }
  return flat;
}

LinePictureReading measure_line_picture(const Frame& picture, const Frame* flat, const LineView& view,
                                        const LinePictureOptions& options) {
  LinePictureReading r;
  if (!is_valid(picture) || !(view.length_px >= 4.0) || !(view.window_px <= kMaxSide) ||
      !(view.length_px <= kMaxSide))
    return r;
  if (flat && (flat->width != picture.width || flat->height != picture.height || !is_valid(*flat)))
    flat = nullptr;
  if (!(view.window_px >= 8.0) || !(view.window_px > 1.2 * view.width_px)) return r;
  Strip s = sample_strip(picture, flat, view);
  const std::optional<double> ground_std = to_contrast(s, flat != nullptr);
  if (!ground_std) return r;
  const double clipped = s.saturated > kFewSaturated ? kClipped : 0.0;
  const double noise = pixel_noise(s), centre = -s.first_across_px;

  // Its place and its sign (darker or brighter), by medians: gaps and dirt are few of the rows.
  std::vector<double> median(std::size_t(s.columns), kUnread), column;
  for (int c = 0; c < s.columns; ++c) {
    column.clear();
    for (int a = 0; a < s.rows; ++a)
      if (!std::isnan(s.at(a, c))) column.push_back(s.at(a, c));
    if (!column.empty()) median[std::size_t(c)] = statistics::median(column);
  }
  const int reach = std::max(1, int(0.2 * view.width_px));
  double best = 0.0;
  int top = -1;
  for (int c = reach; c + reach < s.columns; ++c) {
    if (std::abs(c - centre) > options.search_px) continue;
    double sum = 0.0;
    for (int k = c - reach; k <= c + reach; ++k) sum += median[std::size_t(k)] / (2 * reach + 1);
    if (std::abs(sum) > std::abs(best)) {
      best = sum;
      top = c;
    }
  }
  int inside = 0;
  for (int a = 0; a < s.rows; ++a) inside += !std::isnan(s.at(a, std::clamp(int(centre), 0, s.columns - 1)));
  r.read_px = inside;
  const double least =
      std::max(kLeastContrast, 8.0 * noise / std::sqrt(std::max(1.0, double(inside) * (2 * reach + 1))));
  if (top < 0 || std::abs(best) < least) return r;
  const double sign = best < 0.0 ? -1.0 : 1.0;
  if (sign < 0.0) {
    for (double& v : s.value) v = -v;
    for (double& v : median) v = -v;
  }

  Edges seed = find_edges(median, top, view.width_px, peak_of(median, top, view.width_px));
  if (!seed.found()) return r;
  double middle = 0.5 * (seed.low + seed.high), width = seed.high - seed.low;
  if (!(width > 2.0) || !(width < 4.0 * view.width_px)) return r;

  // Along the line: where it is missing.
  Along along;
  const int core = std::max(1, int(0.3 * width));
  for (int a = 0; a < s.rows; ++a) {
    double sum = 0.0;
    int n = 0;
    for (int c = std::max(0, int(middle) - core); c <= std::min(s.columns - 1, int(middle) + core); ++c)
      if (!std::isnan(s.at(a, c))) {
        sum += s.at(a, c);
        ++n;
      }
    along.level.push_back(n > core ? sum / n : kUnread);
  }
  std::vector<double> known;
  for (const double v : along.level)
    if (!std::isnan(v)) known.push_back(v);
  if (known.size() < 4) return r;
  const auto usual = known.begin() + std::ptrdiff_t(known.size() * 3 / 4);
  std::nth_element(known.begin(), usual, known.end());
  const double level = *usual;
  if (!(level > 0.5 * std::abs(best))) return r;
  for (double& v : along.level) v /= level;
  along.noise = noise / level / std::sqrt(2.0 * core + 1);
  r.gaps = find_gaps(along);

  // Rows that are well inside the line.
  const double clear = 2.0 + 3.0 * options.blur_px;
  std::vector<int> rows;
  for (int a = 0; a < s.rows; ++a) {
    const bool in_gap = std::ranges::any_of(
        r.gaps, [&](const LineGap& g) { return a > g.from_px - clear && a < g.to_px + clear; });
    if (!std::isnan(along.level[std::size_t(a)]) && !in_gap) rows.push_back(a);
  }
  if (rows.size() < 4) return r;
  const double variance = options.blur_px * options.blur_px + kPixelArea + s.interpolation;
  const std::vector<double> raw = mean_profile(s, rows);
  std::vector<double> profile = deblurred(raw, variance);
  Edges all;
  for (int round = 0; round < 2; ++round) {
    all = find_edges(profile, middle, width, peak_of(profile, middle, width));
    if (!all.found() || !(all.high - all.low > 2.0)) return r;
    middle = 0.5 * (all.low + all.high);
    width = all.high - all.low;
  }
  std::vector<double> lows, highs;
  const std::size_t bins = std::clamp<std::size_t>(rows.size() / kBinRows, 1, 40);
  for (std::size_t b = 0; b < bins; ++b) {
    const std::vector<int> of_bin(rows.begin() + std::ptrdiff_t(b * rows.size() / bins),
                                  rows.begin() + std::ptrdiff_t((b + 1) * rows.size() / bins));
    const std::vector<double> p = deblurred(mean_profile(s, of_bin), variance);
    const Edges e = find_edges(p, middle, width, peak_of(p, middle, width));
    if (!e.found() || std::abs(e.low - all.low) > 0.5 * width || std::abs(e.high - all.high) > 0.5 * width)
      continue;
    lows.push_back(e.low);
    highs.push_back(e.high);
  }
  // Edges of few noisy bins are no better than those of the mean.
  const bool by_bins = lows.size() >= 4;
  const double low = by_bins ? robust_mean(lows) : all.low, high = by_bins ? robust_mean(highs) : all.high;

  // The part that another blur would make of it.
  const double wider = options.blur_px + options.blur_std_px;
  const std::vector<double> other = deblurred(raw, wider * wider + kPixelArea + s.interpolation);
  const Edges moved = find_edges(other, middle, width, peak_of(other, middle, width));
  const double blur_low = moved.found() ? moved.low - all.low : 0.0,
               blur_high = moved.found() ? moved.high - all.high : 0.0;
  const auto edge_std = [&](double slope, double by_blur) {
    const double one = 1.5 * noise / std::sqrt(std::max(1.0, double(all.samples)) * double(rows.size()));
    const double steep = std::max(1e-6, std::abs(slope)), by_noise = one / steep, by_light = clipped / steep;
    return std::sqrt(by_noise * by_noise + by_light * by_light + by_blur * by_blur +
                     kEdgeFloor_px * kEdgeFloor_px);
  };
  r.seen = true;
  r.contrast = sign * all.peak;
  r.left_px = s.across_px(high);
  r.right_px = s.across_px(low);
  r.left_std_px = edge_std(all.high_slope, blur_high);
  r.right_std_px = edge_std(all.low_slope, blur_low);
  r.width_px = high - low;
  const double both = blur_high - blur_low, left = edge_std(all.high_slope, 0.0),
               right = edge_std(all.low_slope, 0.0);
  const double ground = kWidthFloor * r.width_px;
  r.width_std_px = std::sqrt(left * left + right * right + both * both + ground * ground);

  double sum = 0.0, beside = 0.0;
  int n_beside = 0;
  for (std::size_t c = 0; c < raw.size(); ++c) {
    if (std::isnan(raw[c])) continue;
    sum += raw[c];
    if (std::abs(double(c) - middle) <= kBesideWidths * width) continue;
    beside += raw[c];
    ++n_beside;
  }
  if (sum > 0.0) {
    r.overspray = beside / sum;
    const double by_noise = noise * std::sqrt(double(n_beside) / double(rows.size())) / sum,
                 by_ground = (*ground_std + clipped) * n_beside / sum, by_halo = kHaloShare * r.overspray;
    r.overspray_std = std::sqrt(by_noise * by_noise + by_ground * by_ground + by_halo * by_halo);
  }
  return r;
}

}  // namespace firn::vision
