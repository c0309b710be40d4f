#include "core/vision/lines.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace firn::vision {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kBridged_mm = 0.2;  // longest gap in an end's profile that becomes straight: a few cells
constexpr double kBeside = 1.3;      // widths from the middle; FWHM = 2.355 sigma, so 3.06 sigma
constexpr double kLevelStds = 4.0;   // of a mean, above which there is a line

// Bilinear; NaN beside the picture and where a corner is not measured.
double value_at(const HeightMap& picture, double x_mm, double y_mm) {
  const GridSpec& g = picture.spec;
  const double u = (x_mm - g.origin_x_mm) / g.pitch_x_mm, v = (y_mm - g.origin_y_mm) / g.pitch_y_mm;
  const int i = int(std::floor(u)), j = int(std::floor(v));
  if (!(u >= 0.0 && v >= 0.0) || i + 1 >= g.nx || j + 1 >= g.ny) return kNaN;
  const double a = u - i, b = v - j;
  return (1.0 - b) * ((1.0 - a) * picture.at(i, j) + a * picture.at(i + 1, j)) +
         b * ((1.0 - a) * picture.at(i, j + 1) + a * picture.at(i + 1, j + 1));
}

// Means over one direction of a band in the other; NaN where less than the share is measured.
struct Band {
  std::vector<double> mean;
  double step_mm = 0.0;
  std::size_t samples = 0;  // of one mean
  bool enough = true;
};

// The place of mean n is first_mm + n step_mm along `to`; each is over [low_mm, high_mm] along `over`.
Band band(const HeightMap& picture, const Point2& at, const Point2& to, double first_mm, double last_mm,
          const Point2& over, double low_mm, double high_mm, double min_share) {
  const double pitch = std::min(picture.spec.pitch_x_mm, picture.spec.pitch_y_mm);
  const int across = std::max(1, int(std::ceil((high_mm - low_mm) / pitch)));
  const int count = std::max(2, int(std::ceil((last_mm - first_mm) / (0.5 * pitch))) + 1);
  Band b;
  b.step_mm = (last_mm - first_mm) / (count - 1);
  b.samples = std::size_t(across);
  std::size_t missing = 0;
  for (int n = 0; n < count; ++n) {
    const double t = first_mm + n * b.step_mm;
    double sum = 0.0;
    int found = 0;
    for (int k = 0; k < across; ++k) {
      const double o = low_mm + (high_mm - low_mm) * (k + 0.5) / across;
      const double h =
          value_at(picture, at.x_mm + t * to.x_mm + o * over.x_mm, at.y_mm + t * to.y_mm + o * over.y_mm);
      if (std::isnan(h)) continue;
      sum += h;
      ++found;
    }
    b.mean.push_back(found > 0 ? sum / found : kNaN);
    missing += std::size_t(across - found);
  }
  b.enough = double(missing) <= (1.0 - min_share) * double(count) * across;
  return b;
}

bool has_gap(const Band& b) {
  return std::ranges::any_of(b.mean, [](double m) { return std::isnan(m); });
}

// Gaps of at most max_mm between measured places become straight.
void bridge(Band& b, double max_mm) {
  std::size_t known = b.mean.size();  // the last one; none yet
  for (std::size_t n = 0; n < b.mean.size(); ++n) {
    if (std::isnan(b.mean[n])) continue;
    if (known < n && double(n - known) * b.step_mm <= max_mm)
      for (std::size_t k = known + 1; k < n; ++k)
        b.mean[k] = b.mean[known] + (b.mean[n] - b.mean[known]) * double(k - known) / double(n - known);
    known = n;
  }
}

// Place at which the section comes down to `level` on the way from index `from` by `step`; the last index if
// it does not.
double crossing(const std::vector<double>& h, std::size_t from, int step, double level) {
  const auto n = std::ptrdiff_t(h.size());
  for (auto k = std::ptrdiff_t(from); k + step >= 0 && k + step < n; k += step) {
    const double here = h[std::size_t(k)], next = h[std::size_t(k + step)];
    if (next <= level && here > level) return double(k) + step * (here - level) / (here - next);
  }
  return step > 0 ? double(n - 1) : 0.0;
}

// From outside to inside of an end, across the line's width.
std::optional<Band> end_band(const HeightMap& picture, const LineEnd& end, double width_mm,
                             const LineWindow& window) {
  if (!end.free || end.length_mm < window.end_inside_mm) return std::nullopt;
  const double sign = end.start ? 1.0 : -1.0;
  const Point2 inside{sign * end.direction.x_mm, sign * end.direction.y_mm};
  const Point2 left{-inside.y_mm, inside.x_mm};
  Band b = band(picture, end.at, inside, -window.end_before_mm, window.end_inside_mm, left, -0.5 * width_mm,
                0.5 * width_mm, window.min_share);
  bridge(b, kBridged_mm);
  if (!b.enough || has_gap(b)) return std::nullopt;
  return b;
}

std::size_t first_inside(const Band& b, const LineWindow& window) {
  return std::size_t((0.5 * window.end_inside_mm + window.end_before_mm) / b.step_mm);
}

// Returns nothing within the noise.
std::optional<double> inner_level(const Band& b, const LineWindow& window) {
  const std::size_t count = b.mean.size(), first = first_inside(b, window);
  double level = 0.0;
  for (std::size_t n = first; n < count; ++n) level += b.mean[n] / double(count - first);
  if (!(level > kLevelStds * window.noise_mm / std::sqrt(double(b.samples) * double(count - first))))
    return std::nullopt;
  return level;
}

}  // namespace

std::optional<LineReading> measure_line(const HeightMap& picture, const LineStation& s,
                                        const LineWindow& window) {
  const double half = std::min(window.half_window_mm, 0.5 * s.room_mm);
  if (half < window.min_room_mm) return std::nullopt;
  const Point2 left{-s.direction.y_mm, s.direction.x_mm};
  const double length = 0.5 * (s.to_mm - s.from_mm);
  const Band b = band(picture, s.at, left, -half, half, s.direction, -length, length, window.min_share);
  if (!b.enough || has_gap(b)) return std::nullopt;
  LineReading r;
  for (std::size_t n = 0; n < b.mean.size(); ++n)
    r.area_mm2 += b.mean[n] * b.step_mm * (n == 0 || n + 1 == b.mean.size() ? 0.5 : 1.0);
  const std::size_t top = std::size_t(std::ranges::max_element(b.mean) - b.mean.begin());
  r.height_mm = b.mean[top];
  if (!(r.height_mm > kLevelStds * window.noise_mm / std::sqrt(double(b.samples)) && r.area_mm2 > 0.0)) {
    r.width_mm = r.offset_mm = r.overspray = kNaN;
    return r;
  }
  const double low = crossing(b.mean, top, -1, 0.5 * r.height_mm),
               high = crossing(b.mean, top, 1, 0.5 * r.height_mm);
  r.width_mm = (high - low) * b.step_mm;
  r.offset_mm = 0.5 * (low + high) * b.step_mm - half;
  double beside = 0.0;
  for (std::size_t n = 0; n < b.mean.size(); ++n)
    if (std::abs(double(n) * b.step_mm - half - r.offset_mm) > kBeside * r.width_mm)
      beside += b.mean[n] * b.step_mm * (n == 0 || n + 1 == b.mean.size() ? 0.5 : 1.0);
  r.overspray = beside / r.area_mm2;
  return r;
}

HeightMap seen_through(const HeightMap& picture, double extent_x_mm, double extent_y_mm) {
  const GridSpec& g = picture.spec;
  const double x = extent_x_mm / g.pitch_x_mm, y = extent_y_mm / g.pitch_y_mm;
  const double wx = x * x / 24.0, wy = y * y / 24.0;  // half of the window's variance, in cells
  HeightMap seen = picture;
  for (int j = 1; j + 1 < g.ny; ++j)
    for (int i = 1; i + 1 < g.nx; ++i)
      seen.at(i, j) += wx * (picture.at(i - 1, j) + picture.at(i + 1, j) - 2.0 * picture.at(i, j)) +
                       wy * (picture.at(i, j - 1) + picture.at(i, j + 1) - 2.0 * picture.at(i, j));
  return seen;
}

std::optional<double> measure_end(const HeightMap& picture, const LineEnd& end, double width_mm,
                                  const LineWindow& window) {
  const std::optional<Band> b = end_band(picture, end, width_mm, window);
  if (!b) return std::nullopt;
  const std::size_t first = first_inside(*b, window);
  const std::optional<double> level = inner_level(*b, window);
  if (!level) return std::nullopt;
  // From inside to outside: the last place above half of the level.
  std::size_t n = first;
  while (n > 0 && b->mean[n] > 0.5 * *level) --n;
  if (b->mean[n] > 0.5 * *level) return std::nullopt;  // the line goes on beyond the window
  const double share = (0.5 * *level - b->mean[n]) / (b->mean[n + 1] - b->mean[n]);
  const double edge_mm = (double(n) + share) * b->step_mm - window.end_before_mm;  // > 0: inside
  return end.start ? edge_mm : -edge_mm;
}

std::optional<double> level_inside(const HeightMap& picture, const LineEnd& end, double width_mm,
                                   const LineWindow& window) {
  const std::optional<Band> b = end_band(picture, end, width_mm, window);
  return b ? inner_level(*b, window) : std::nullopt;
}

std::optional<double> measure_added_end(const AddedInk& ink, const LineEnd& end, double width_mm,
                                        const LineWindow& window) {
  const std::optional<Band> before = end_band(ink.before, end, width_mm, window),
                            after = end_band(ink.after, end, width_mm, window);
  if (!before || !after || before->mean.size() != after->mean.size()) return std::nullopt;
  const auto added = [&](std::size_t n) { return after->mean[n] - before->mean[n]; };
  const double half = 0.5 * ink.level;
  std::size_t n = 0;
  while (n < after->mean.size() && !(added(n) >= half)) ++n;
  if (n == 0 || n == after->mean.size() || after->mean[n] > ink.deepest) return std::nullopt;
  const double share = (half - added(n - 1)) / (added(n) - added(n - 1));
  const double edge_mm = (double(n - 1) + share) * after->step_mm - window.end_before_mm;
  return end.start ? edge_mm : -edge_mm;
}

}  // namespace firn::vision
