#include "core/vision/line_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/statistics/median.h"
#include "core/vision/least_squares.h"
#include "core/vision/line_strip.h"

namespace firn::vision {
namespace {

// Values without another reason were chosen on rendered pictures (tests/bench/line_pictures.cpp, seeds below
// 50,000). Widths are the line's at half contrast.

// What is read at all.
constexpr double kMinLength_px = 4.0, kMinWindow_px = 8.0;     // of the stretch, of the window
constexpr double kMinWindowWidths = 1.2;                       // of the window: ground has to be seen beside
constexpr double kMinContrast = 0.02, kMinContrastStds = 8.0;  // of the line; in the noise of its mean
constexpr double kMinWidth_px = 2.0, kMaxWidths = 4.0;         // of the line; over the expected width
constexpr std::size_t kMinLineRows = 4;

// Search and profile across the line.
constexpr double kSearchShare = 0.2;  // half of a sliding mean's length over the expected width
constexpr double kCoreShare = 0.3;    // half of the line's middle over its width
constexpr double kEdgeShare = 0.12, kPeakShare = 0.25, kMinFit_px = 2.0;  // half of a parabola: of the width
constexpr double kMaxVertex = 0.1;           // of the peak: a vertex farther from the middle's level is none
constexpr int kMinFitSamples = 4;            // of a parabola
constexpr int kBinRows = 12, kMaxBins = 40;  // stretches whose edges are averaged robustly
constexpr std::size_t kMinBins = 4;          // fewer are no better than the mean profile
constexpr double kMaxBinShift = 0.5;         // widths: a bin's edge farther off belongs to another line

// Gaps.
constexpr std::size_t kUsualQuarters = 3;  // of the rows are paler than the usual level: gaps are few of them
constexpr double kMinUsualShare = 0.5;     // of the contrast that found the line
constexpr double kMinGap_px = 3.0;
constexpr double kMinGapSlope = 0.02;                 // of the level, a pixel
constexpr double kClear_px = 2.0, kClearBlurs = 3.0;  // rows beside a gap that are not read

// Overspray and standard deviations.
constexpr double kBesideWidths = 1.3;    // from the middle on: overspray
constexpr double kPixelArea = 1.0 / 12;  // variance of a pixel's own square [px^2]
constexpr double kEdgeNoise = 1.5;       // std of a parabola's crossing over that of its samples' mean
constexpr double kMinSlope = 1e-6;
constexpr double kEdgeFloor_px = 0.09;   // of an edge: pixel grid, uneven ground
constexpr double kWidthFloor = 0.003;    // of the width
constexpr double kGapFloor_px = 0.28;    // of a gap's end
constexpr double kHaloShare = 0.28;      // of the overspray: what lies beyond the window or counts as ground
constexpr double kFewSaturated = 0.02;   // of the samples
constexpr double kClippedLight = 0.015;  // of the light, where more of them are: so much is not known

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
  if (l.samples < kMinFitSamples || !sums.solve(q)) return l;
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
  const double half = std::max(kMinFit_px, kEdgeShare * width);
  e.low = falls_below(p, middle, -1, 0.5 * peak);
  e.high = falls_below(p, middle, 1, 0.5 * peak);
  if (!e.found()) return e;
  e.low = refined(p, e.low, half, 0.5 * peak, e.low_slope, e.samples);
  e.high = refined(p, e.high, half, 0.5 * peak, e.high_slope, e.samples);
  return e;
}

double peak_of(const std::vector<double>& p, double middle, double width) {
  const Local l = parabola(p, middle, std::max(kMinFit_px, kPeakShare * width));
  if (!l.found) return kUnread;
  // The vertex, where it lies inside; else the level.
  const double vertex = l.bend < 0.0 ? l.level - l.slope * l.slope / (4 * l.bend) : l.level;
  return std::abs(vertex - l.level) < kMaxVertex * std::abs(l.level) ? vertex : l.level;
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
    const double steep = std::max(kMinGapSlope, std::min(slope[0], slope[1]));
    g.std_px = std::sqrt(along.noise * along.noise / (steep * steep) + kGapFloor_px * kGapFloor_px);
    if (g.to_px - g.from_px >= kMinGap_px) {
      // A speck that covers the middle of a gap for a row or two does not divide it.
      if (!gaps.empty() && g.from_px - gaps.back().to_px < kMinGap_px)
        gaps.back().to_px = g.to_px;
      else
        gaps.push_back(g);
    }
    a = end + 1;
  }
  return gaps;
}

// Where the line is: its columns' medians, since gaps and dirt are few of the rows.
struct Sighting {
  std::vector<double> median;  // by column
  double contrast = 0.0;       // mean of the middle's columns; negative: brighter than the ground
  int column = -1;             // of the middle; -1: there is no line
  int rows = 0;                // of the strip that lie in the picture
};

Sighting find_line(const Strip& s, const LineView& view, double search_px, double noise) {
  Sighting line;
  const double centre = -s.first_across_px;
  line.median.assign(std::size_t(s.columns), kUnread);
  std::vector<double> column;
  for (int c = 0; c < s.columns; ++c) {
    column.clear();
    for (int a = 0; a < s.rows; ++a)
      if (!std::isnan(s.at(a, c))) column.push_back(s.at(a, c));
    if (!column.empty()) line.median[std::size_t(c)] = statistics::median(column);
  }
  const int reach = std::max(1, int(kSearchShare * view.width_px));
  for (int c = reach; c + reach < s.columns; ++c) {
    if (std::abs(c - centre) > search_px) continue;
    double sum = 0.0;
    for (int k = c - reach; k <= c + reach; ++k) sum += line.median[std::size_t(k)] / (2 * reach + 1);
    if (std::abs(sum) > std::abs(line.contrast)) {
      line.contrast = sum;
      line.column = c;
    }
  }
  for (int a = 0; a < s.rows; ++a)
    line.rows += !std::isnan(s.at(a, std::clamp(int(centre), 0, s.columns - 1)));
  const double least = std::max(
      kMinContrast, kMinContrastStds * noise / std::sqrt(std::max(1.0, double(line.rows) * (2 * reach + 1))));
  if (std::abs(line.contrast) < least) line.column = -1;
  return line;
}

// The level of the line's middle by row, over the usual one; nothing where there is no usual level.
std::optional<Along> level_along(const Strip& s, double middle, double width, double contrast, double noise) {
  Along along;
  const int core = std::max(1, int(kCoreShare * width));
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
  if (known.size() < kMinLineRows) return std::nullopt;
  const auto usual = known.begin() + std::ptrdiff_t(known.size() * kUsualQuarters / 4);
  std::nth_element(known.begin(), usual, known.end());
  const double level = *usual;
  if (!(level > kMinUsualShare * std::abs(contrast))) return std::nullopt;
  for (double& v : along.level) v /= level;
  along.noise = noise / level / std::sqrt(2.0 * core + 1);
  return along;
}

// Rows that are well inside the line.
std::vector<int> rows_beside_gaps(const Along& along, const std::vector<LineGap>& gaps, double blur_px) {
  const double clear = kClear_px + kClearBlurs * blur_px;
  std::vector<int> rows;
  for (int a = 0; a < int(along.level.size()); ++a) {
    const bool in_gap = std::ranges::any_of(
        gaps, [&](const LineGap& g) { return a > g.from_px - clear && a < g.to_px + clear; });
    if (!std::isnan(along.level[std::size_t(a)]) && !in_gap) rows.push_back(a);
  }
  return rows;
}

// The line across: edges of the mean profile, then of stretches, which a speck at one of them does not move.
struct Across {
  Edges mean;
  double middle = 0.0, width = 0.0;  // of these
  double low = 0.0, high = 0.0;      // edges, of the stretches where there are enough
};

std::optional<Across> edges_across(const Strip& s, const std::vector<int>& rows,
                                   const std::vector<double>& raw, double variance, double middle,
                                   double width) {
  Across line;
  const std::vector<double> profile = deblurred(raw, variance);
  for (int round = 0; round < 2; ++round) {
    line.mean = find_edges(profile, middle, width, peak_of(profile, middle, width));
    if (!line.mean.found() || !(line.mean.high - line.mean.low > kMinWidth_px)) return std::nullopt;
    middle = 0.5 * (line.mean.low + line.mean.high);
    width = line.mean.high - line.mean.low;
  }
  std::vector<double> lows, highs;
  const std::size_t bins = std::clamp<std::size_t>(rows.size() / kBinRows, 1, kMaxBins);
  for (std::size_t b = 0; b < bins; ++b) {
    const std::vector<int> of_bin(rows.begin() + std::ptrdiff_t(b * rows.size() / bins),
                                  rows.begin() + std::ptrdiff_t((b + 1) * rows.size() / bins));
    const std::vector<double> p = deblurred(mean_profile(s, of_bin), variance);
    const Edges e = find_edges(p, middle, width, peak_of(p, middle, width));
    if (!e.found() || std::abs(e.low - line.mean.low) > kMaxBinShift * width ||
        std::abs(e.high - line.mean.high) > kMaxBinShift * width)
      continue;
    lows.push_back(e.low);
    highs.push_back(e.high);
  }
  const bool by_bins = lows.size() >= kMinBins;
  line.middle = middle;
  line.width = width;
  line.low = by_bins ? robust_mean(lows) : line.mean.low;
  line.high = by_bins ? robust_mean(highs) : line.mean.high;
  return line;
}

// What is known of the light.
struct LightErrors {
  double noise = 0.0;       // of a pixel's contrast
  double ground_std = 0.0;  // of the ground's level, relative
  double clipped = 0.0;     // share of the light that saturation may have cut off
};

// @param moved edges with a wider blur
void set_edges(const Strip& s, const Across& line, const Edges& moved, const LightErrors& light,
               std::size_t rows, LinePictureReading& r) {
  const double blur_low = moved.found() ? moved.low - line.mean.low : 0.0,
               blur_high = moved.found() ? moved.high - line.mean.high : 0.0;
  const auto edge_std = [&](double slope, double by_blur) {
    const double one =
        kEdgeNoise * light.noise / std::sqrt(std::max(1.0, double(line.mean.samples)) * double(rows));
    const double steep = std::max(kMinSlope, std::abs(slope)), by_noise = one / steep,
                 by_light = light.clipped / steep;
    return std::sqrt(by_noise * by_noise + by_light * by_light + by_blur * by_blur +
                     kEdgeFloor_px * kEdgeFloor_px);
  };
  r.left_px = s.across_px(line.high);
  r.right_px = s.across_px(line.low);
  r.left_std_px = edge_std(line.mean.high_slope, blur_high);
  r.right_std_px = edge_std(line.mean.low_slope, blur_low);
  r.width_px = line.high - line.low;
  const double both = blur_high - blur_low, left = edge_std(line.mean.high_slope, 0.0),
               right = edge_std(line.mean.low_slope, 0.0);
  const double floor = kWidthFloor * r.width_px;
  r.width_std_px = std::sqrt(left * left + right * right + both * both + floor * floor);
}

void set_overspray(const std::vector<double>& raw, const Across& line, const LightErrors& light,
                   std::size_t rows, LinePictureReading& r) {
  double sum = 0.0, beside = 0.0;
  int n_beside = 0;
  for (std::size_t c = 0; c < raw.size(); ++c) {
    if (std::isnan(raw[c])) continue;
    sum += raw[c];
    if (std::abs(double(c) - line.middle) <= kBesideWidths * line.width) continue;
    beside += raw[c];
    ++n_beside;
  }
  if (!(sum > 0.0)) return;
  r.overspray = beside / sum;
  const double by_noise = light.noise * std::sqrt(double(n_beside) / double(rows)) / sum,
               by_ground = (light.ground_std + light.clipped) * n_beside / sum,
               by_halo = kHaloShare * r.overspray;
  r.overspray_std = std::sqrt(by_noise * by_noise + by_ground * by_ground + by_halo * by_halo);
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
  if (!is_valid(picture) || !(view.length_px >= kMinLength_px) || !(view.window_px <= kMaxSide) ||
      !(view.length_px <= kMaxSide))
    return r;
  if (flat && (flat->width != picture.width || flat->height != picture.height || !is_valid(*flat)))
    flat = nullptr;
  if (!(view.window_px >= kMinWindow_px) || !(view.window_px > kMinWindowWidths * view.width_px)) return r;
  Strip s = sample_strip(picture, flat, view);
  const std::optional<double> ground_std = to_contrast(s, flat != nullptr);
  if (!ground_std) return r;
  const LightErrors light{pixel_noise(s), *ground_std, s.saturated > kFewSaturated ? kClippedLight : 0.0};

  Sighting sighting = find_line(s, view, options.search_px, light.noise);
  r.read_px = sighting.rows;
  if (sighting.column < 0) return r;
  const double sign = sighting.contrast < 0.0 ? -1.0 : 1.0;
  if (sign < 0.0) {
    for (double& v : s.value) v = -v;
    for (double& v : sighting.median) v = -v;
  }
  const Edges seed = find_edges(sighting.median, sighting.column, view.width_px,
                                peak_of(sighting.median, sighting.column, view.width_px));
  if (!seed.found()) return r;
  const double middle = 0.5 * (seed.low + seed.high), width = seed.high - seed.low;
  if (!(width > kMinWidth_px) || !(width < kMaxWidths * view.width_px)) return r;

  const std::optional<Along> along = level_along(s, middle, width, sighting.contrast, light.noise);
  if (!along) return r;
  r.gaps = find_gaps(*along);
  const std::vector<int> rows = rows_beside_gaps(*along, r.gaps, options.blur_px);
  if (rows.size() < kMinLineRows) return r;

  const auto variance_of = [&](double blur_px) { return blur_px * blur_px + kPixelArea + s.interpolation; };
  const std::vector<double> raw = mean_profile(s, rows);
  const std::optional<Across> line = edges_across(s, rows, raw, variance_of(options.blur_px), middle, width);
  if (!line) return r;
  const std::vector<double> wider = deblurred(raw, variance_of(options.blur_px + options.blur_std_px));
  const Edges moved = find_edges(wider, line->middle, line->width, peak_of(wider, line->middle, line->width));
  r.seen = true;
  r.contrast = sign * line->mean.peak;
  set_edges(s, *line, moved, light, rows.size(), r);
  set_overspray(raw, *line, light, rows.size(), r);
  return r;
}

}  // namespace firn::vision
