#include "core/motion/curve/tube_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/motion/curve/constants.h"
#include "core/motion/curve/frechet.h"
#include "core/motion/curve/held_samples.h"
#include "core/motion/curve/polyline_thinning.h"

namespace firn::motion {
namespace {

/// The points are places of a curve, and the polygon between them is not meant.
bool samples(const TubeOptions& options) { return options.radius_mm < options.between_mm; }

void take(std::span<const Point2> points, const std::vector<std::size_t>& kept, std::vector<Point2>& out) {
  out.clear();
  for (const std::size_t i : kept) out.push_back(points[i]);
}

void lengths(std::span<const Point2> line, std::vector<double>& length) {
  length.assign(1, 0.0);
  for (std::size_t i = 1; i < line.size(); ++i)
    length.push_back(length.back() + distance(line[i - 1], line[i]));
}

/// Sizes of the cells along the thinned shape, from the turn at each of its vertices.
class CellField {
 public:
  CellField(std::span<const Point2> shape, double radius, double chords, double largest) : largest_(largest) {
    at_.push_back(0.0);
    for (std::size_t i = 1; i < shape.size(); ++i)
      at_.push_back(at_.back() + distance(shape[i - 1], shape[i]));
    size_.assign(shape.size(), largest);
    for (std::size_t i = 1; i + 1 < shape.size(); ++i) {
      const double before = at_[i] - at_[i - 1], after = at_[i + 1] - at_[i];
      const double x =
          (shape[i + 1].x_mm - shape[i].x_mm) / after - (shape[i].x_mm - shape[i - 1].x_mm) / before;
      const double y =
          (shape[i + 1].y_mm - shape[i].y_mm) / after - (shape[i].y_mm - shape[i - 1].y_mm) / before;
      const double turn = std::sqrt(x * x + y * y);
      size_[i] = std::min({largest, chords * std::max(before, after), kCellTurn * radius / turn});
    }
    for (std::size_t i = 1; i < size_.size(); ++i)
      size_[i] = std::min(size_[i], size_[i - 1] + kCellGrowth * (at_[i] - at_[i - 1]));
    for (std::size_t i = size_.size() - 1; i-- > 0;)
      size_[i] = std::min(size_[i], size_[i + 1] + kCellGrowth * (at_[i + 1] - at_[i]));
  }
  double total() const { return at_.back(); }

  double at(double t) {
    while (i_ > 0 && t < at_[i_]) --i_;
    while (i_ + 2 < at_.size() && t >= at_[i_ + 1]) ++i_;
    return std::min({largest_, size_[i_] + kCellGrowth * std::abs(t - at_[i_]),
                     size_[i_ + 1] + kCellGrowth * std::abs(at_[i_ + 1] - t)});
  }

 private:
  std::vector<double> at_, size_;
  double largest_;
  std::size_t i_ = 0;
};

/// Knots over [0, total]: each cell as long as the field in its middle times `finer`, all of them shortened
/// by one share so that the last one ends at the end.
void place_knots(CellField field, double finer, double total, std::vector<double>& knots) {
  const double end = field.total();
  const auto step = [&](double t, double share) {
    double h = share * finer * field.at(t);
    for (int round = 0; round < kCellRounds; ++round)
      h = share * finer * field.at(std::min(end, t + 0.5 * h));
    return h;
  };
  double cells = 0.0;
  for (double t = 0.0; t < end;) {
    const double h = step(t, 1.0);
    cells += std::min(1.0, (end - t) / h);
    t += h;
  }
  const double whole = std::max(kMinCells, std::ceil(cells)), scale = total / end;
  knots.assign(1, 0.0);
  double t = 0.0;
  for (double cell = 1.0; cell < whole; ++cell) {
    t += step(t, cells / whole);
    if (t >= end - 0.3 * step(t, cells / whole)) break;  // steps of other sizes add up to a little more
    knots.push_back(t * scale);
  }
  knots.push_back(total);
}

/// Places of the polygon itself beside its thinned line: in proportion to the lengths between two vertices
/// of that.
class PolygonAt {
 public:
  PolygonAt(std::span<const Point2> points, std::vector<double>& length) : points_(points), length_(length) {
    lengths(points, length);
  }
  /// At a share x of the way from points[first] to points[last]. Calls come in the order of the path.
  Point2 operator()(std::size_t first, std::size_t last, double x) {
    const double s = length_[first] + x * (length_[last] - length_[first]);
    i_ = std::max(i_, first);
    while (i_ + 1 < last && s >= length_[i_ + 1]) ++i_;
    const double y = (s - length_[i_]) / (length_[i_ + 1] - length_[i_]);
    const Point2 &a = points_[i_], &b = points_[i_ + 1];
    return {a.x_mm + y * (b.x_mm - a.x_mm), a.y_mm + y * (b.y_mm - a.y_mm)};
  }

 private:
  std::span<const Point2> points_;
  const std::vector<double>& length_;
  std::size_t i_ = 0;
};

/// Vertices of the line, and places of the polygon between them about half a cell apart. @param kept the
/// line's vertices among `points`
void set_places(TubeWork& work, std::span<const Point2> points, const std::vector<std::size_t>& kept,
                const TubeOptions& options, double share, std::vector<TubePlace>& places) {
  const double radius = share * options.radius_mm;
  places.clear();
  work.lines = false;
  PolygonAt polygon(points, work.point_length);
  std::size_t cell = 0;
  for (std::size_t i = 0; i + 1 < work.line.size(); ++i) {
    const double from = work.length[i], to = work.length[i + 1];
    const bool line = options.hold_lines && is_line(work.line, work.length, i);
    work.lines |= line;
    const double bulge = samples(options) && !line ? bulge_mm(work.line, i, options.max_between_mm) : 0.0;
    const double between = line ? radius : share * std::max(options.between_mm, bulge);
    if (i > 0) places.push_back({from, work.line[i], radius});
    double t = from;
    for (;;) {
      while (cell + 2 < work.knots.size() && t >= work.knots[cell + 1]) ++cell;
      const double h = kPlaceSpacing * (work.knots[cell + 1] - work.knots[cell]);
      const double left = to - t;
      if (left < 1.5 * h) break;
      t += left < 2.5 * h ? 0.5 * left : h;
      const double x = (t - from) / (to - from);
      places.push_back({t, polygon(kept[i], kept[i + 1], x), between});
    }
  }
}

/// Control points on the line at the Greville abscissae: inside the hull of the line.
void guess_control(TubeWork& work) {
  const auto& knots = work.knots;
  const std::size_t cells = knots.size() - 1;
  const auto knot = [&](std::ptrdiff_t i) {
    return knots[std::size_t(std::clamp<std::ptrdiff_t>(i, 0, std::ptrdiff_t(cells)))];
  };
  work.control.clear();
  std::size_t i = 0;
  for (std::ptrdiff_t k = -1; k <= std::ptrdiff_t(cells) + 1; ++k) {
    const double t = (knot(k - 1) + knot(k) + knot(k + 1)) / 3.0;
    while (i + 2 < work.length.size() && t >= work.length[i + 1]) ++i;
    const double x = (t - work.length[i]) / (work.length[i + 1] - work.length[i]);
    work.control.push_back({work.line[i].x_mm + x * (work.line[i + 1].x_mm - work.line[i].x_mm),
                            work.line[i].y_mm + x * (work.line[i + 1].y_mm - work.line[i].y_mm)});
  }
}

/// Positions and second derivatives at the knots from the control points.
void to_curve(const TubeWork& work, Curve& curve) {
  const auto& c = work.control;
  const auto& tau = work.extended;
  const std::size_t n = work.knots.size();
  curve.s = work.knots;
  for (auto* v : {&curve.x, &curve.y, &curve.xx, &curve.yy}) v->resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    // at knot k, which is tau[k + 3], control points k .. k + 2 count
    const double a = tau[k + 3] - tau[k + 2], b = tau[k + 4] - tau[k + 3];
    const double a2 = tau[k + 3] - tau[k + 1], b2 = tau[k + 5] - tau[k + 3];
    const auto second = [&](double c0, double c1, double c2) {
      const double d0 = 3.0 * (c1 - c0) / (tau[k + 4] - tau[k + 1]);
      const double d1 = 3.0 * (c2 - c1) / (tau[k + 5] - tau[k + 2]);
      return 2.0 * (d1 - d0) / (tau[k + 4] - tau[k + 2]);
    };
    const auto value = [&](double c0, double c1, double c2) {
      // knot insertion
      const double p0 = (b * c0 + a2 * c1) / (a2 + b), p1 = (b2 * c1 + a * c2) / (a + b2);
      return (b * p0 + a * p1) / (a + b);
    };
    if (k == 0) {
      curve.x[k] = c.front().x_mm;
      curve.y[k] = c.front().y_mm;
    } else if (k + 1 == n) {
      curve.x[k] = c.back().x_mm;
      curve.y[k] = c.back().y_mm;
    } else {
      curve.x[k] = value(c[k].x_mm, c[k + 1].x_mm, c[k + 2].x_mm);
      curve.y[k] = value(c[k].y_mm, c[k + 1].y_mm, c[k + 2].y_mm);
    }
    curve.xx[k] = second(c[k].x_mm, c[k + 1].x_mm, c[k + 2].x_mm);
    curve.yy[k] = second(c[k].y_mm, c[k + 1].y_mm, c[k + 2].y_mm);
  }
}

void straight_line(Point2 a, Point2 b, Curve& curve) {
  const double total = distance(a, b);
  curve.s = {0.0, total};
  curve.x = {a.x_mm, b.x_mm};
  curve.y = {a.y_mm, b.y_mm};
  curve.xx = {0.0, 0.0};
  curve.yy = {0.0, 0.0};
  curve.straight = true;
}

/// Derivative of the given order at t in cell k as a form of control points k .. k + 3: the control values
/// are differenced, and those of the derivative blended as de Boor does.
std::array<double, 4> derivative_form(const std::vector<double>& knot, std::size_t k, int order, double t) {
  std::array<double, 4> form{};
  for (std::size_t unit = 0; unit < 4; ++unit) {
    double c[4] = {};
    c[unit] = 1.0;
    const int degree = 3 - order;
    for (int o = 0; o < order; ++o)
      for (int j = 0; j + o < 3; ++j)
        c[j] = double(3 - o) * (c[j + 1] - c[j]) /
               (knot[k + std::size_t(j) + 4] - knot[k + std::size_t(j + o) + 1]);
    for (int r = 1; r <= degree; ++r)
      for (int j = 0; j + r <= degree; ++j) {
        const double low = knot[k + std::size_t(j + r + order)], high = knot[k + std::size_t(j) + 4];
        const double x = (t - low) / (high - low);
        c[j] = (1.0 - x) * c[j] + x * c[j + 1];
      }
    form[unit] = c[0];
  }
  return form;
}

/// Distances by which chords miss an arc that turns at the polygon's vertices as these do: length times
/// turn / 8. A larger turn is a corner.
void set_missed(std::span<const Point2> points, const std::vector<double>& length,
                std::vector<double>& missed) {
  missed.assign(points.size(), 0.0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double turn = std::abs(turn_at(points[i - 1], points[i], points[i + 1]));
    if (turn < kMaxSampledTurn)
      missed[i] = 0.125 * turn * std::min(length[i] - length[i - 1], length[i + 1] - length[i]);
  }
}

/// Share of the tube's radius where the polygon misses its curve by x tolerances: 1 - x^2 / 4 up to x = 1,
/// then back to 1 at x = 2. The true curve lies x tolerances outside of coarse chords, so a curve at the
/// tube's inner edge would be faster than one through finer samples of the same path. From x = 2 on the
/// vertex is a corner that is meant.
double share_of(double x) { return 1.0 - kMissedReduction * x * x * std::clamp(2.0 - x, 0.0, 1.0); }

/// Lines given as such stay: on a chord too long to be between two samples the tube is narrower, beyond
/// kLineEnd_mm of its ends. Shorter chords on a line may be samples of a curve that happens to be flat.
void narrow(std::span<const Point2> points, double tolerance, double total, TubeWork& work) {
  const std::vector<double>& length = work.point_length;
  if (tolerance > 0.0) set_missed(points, length, work.missed);
  const double scale = total / length.back();
  std::size_t k = 0;
  for (TubePlace& place : work.places) {
    while (k + 2 < points.size() && scale * length[k + 1] < place.t) ++k;
    const bool line =
        place.t > scale * length[k] + kLineEnd_mm && place.t < scale * length[k + 1] - kLineEnd_mm;
    if (line)
      place.share = kLineShare;
    else if (tolerance > 0.0)
      place.share = share_of(std::max(work.missed[k], work.missed[k + 1]) / tolerance);
    place.radius *= place.share;
  }
}

/// Weights of held samples' cells: beside a rest the jerk of a motion grows with |r'''| v^3, and v^6 with
/// the fourth power of the distance from there. The tight turn into a cusp is all of the objective otherwise,
/// and the rest of the path stays rough.
void weigh_rests(TubeWork& work) {
  for (std::size_t k = 0; k + 1 < work.knots.size(); ++k) {
    const double at = 0.5 * (work.knots[k] + work.knots[k + 1]);
    const double x = std::min(1.0, std::min(at, work.knots.back() - at) / kRestReach_mm);
    work.weight.push_back(std::max(kMinRestWeight, x * x * x * x));
  }
}

/// The spline of least energy in work.places. @param near_places of fit_spline()
void fit_inside(bool near_places, TubeWork& work, Curve& curve) {
  work.base.clear();
  work.linear.clear();
  fit_spline(work.knots, work.places, near_places, work);
  to_curve(work, curve);
}

/// Places and spline of a fit whose line and cells are set.
void fit_cells(std::span<const Point2> points, const TubeOptions& options, TubeWork& work, Curve& curve) {
  const bool samples = motion::samples(options);
  set_places(work, points, work.kept, options, samples ? 1.0 : kTubePlaceRadius, work.places);
  if (!samples) narrow(points, options.tolerance_mm, work.length.back(), work);
  guess_control(work);
  work.control.front() = points.front();
  work.control.back() = points.back();
  work.weight.clear();
  if (samples) weigh_rests(work);
  fit_inside(samples, work, curve);
}

/// Halves the cells with places that the last fit left outside of their radii, and those beside them. Returns
/// whether there are any.
bool split_cells(TubeWork& work) {
  std::vector<double>& knots = work.knots;
  std::vector<bool> split(knots.size() + 1, false);  // cell k at k + 1
  std::size_t cell = 0;
  for (std::size_t i = 0; i < work.places.size(); ++i) {
    while (cell + 2 < knots.size() && work.places[i].t >= knots[cell + 1]) ++cell;
    const double x = work.states.off_x[i], y = work.states.off_y[i], radius = work.places[i].radius;
    if (x * x + y * y > radius * radius) split[cell] = split[cell + 1] = split[cell + 2] = true;
  }
  std::vector<double> finer{knots.front()};
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    if (split[k + 1]) finer.push_back(0.5 * (knots[k] + knots[k + 1]));
    finer.push_back(knots[k + 1]);
  }
  std::swap(knots, finer);
  return knots.size() > finer.size();
}

}  // namespace

void fit_tube(std::span<const Point2> points, const TubeOptions& options, TubeWork& work, Curve& curve) {
  const bool samples = motion::samples(options);
  const double within = samples ? 0.0 : kLineThinning * options.radius_mm;
  curve.straight = false;
  curve.yaw.clear();
  curve.yaw2.clear();
  if (samples) {
    work.kept.resize(points.size());
    std::iota(work.kept.begin(), work.kept.end(), std::size_t{0});
  } else {
    thin_polyline(points, within, work.kept);
  }
  take(points, work.kept, work.line);
  samples ? held_lengths(work.line, options.radius_mm, work.length) : lengths(work.line, work.length);
  thin_polyline(work.line, (samples ? kSampleCellThinning : kCellThinning) * options.radius_mm, work.coarse);
  take(work.line, work.coarse, work.shape);
  if (work.shape.size() == 2) return straight_line(points.front(), points.back(), curve);
  const double total = work.length.back();
  place_knots({work.shape, options.between_mm, samples ? kSampleCellChords : kCellChords,
               std::min(options.largest_mm, total / kMinCells)},
              !samples && options.tolerance_mm > 0.0 ? kMovedCellShare : kCellShare, total, work.knots);
  fit_cells(points, options, work, curve);
  // samples may ask for a turn that is tighter than the cells there allow; beside a line that is none, too
  if (!samples || work.lines) return;
  for (int splits = 0; !work.converged && splits < kMaxSplits && split_cells(work); ++splits)
    fit_cells(points, options, work, curve);
}

void refit_tube(TubeWork& work, Curve& curve) { fit_inside(false, work, curve); }

void widen_tube(double by_mm, TubeWork& work) {
  for (TubePlace& place : work.places)
    place.radius = std::max(place.radius + place.share * by_mm, 0.5 * place.radius);
}

void narrow_tube(std::span<const StretchBeyond> stretches, double more_mm, TubeWork& work) {
  const std::vector<double>& knots = work.knots;
  std::size_t first = 0;  // place
  for (const StretchBeyond& stretch : stretches) {
    const auto cell = [&](double t) {
      return std::size_t(std::upper_bound(knots.begin(), knots.end(), t) - knots.begin());
    };
    const double from = knots[std::max(cell(stretch.from), kDependentCells + 1) - kDependentCells - 1],
                 to = knots[std::min(cell(stretch.to) + kDependentCells, knots.size() - 1)];
    while (first < work.places.size() && work.places[first].t < from) ++first;
    for (std::size_t i = first; i < work.places.size() && work.places[i].t <= to; ++i) {
      TubePlace& place = work.places[i];
      place.narrower = std::max(place.narrower, stretch.beyond_mm + more_mm);
    }
  }
  for (TubePlace& place : work.places)
    place.radius = std::max(place.radius - std::exchange(place.narrower, 0.0), 0.5 * place.radius);
}

void base_curve(TubeWork& work, Curve& curve) {
  work.control = work.base;
  to_curve(work, curve);
}

void step_tube(const Curve& fine, const CurveGradient& gradient, std::span<const double> weight, double value,
               TubeWork& work, Curve& curve) {
  const std::size_t cells = work.knots.size() - 1;
  work.weight.assign(cells, 0.0);
  work.linear.assign(work.base.size(), {});
  const auto middle = [&](std::size_t i) { return 0.5 * (fine.s[i] + fine.s[i + 1]); };
  std::size_t i = 0;
  for (std::size_t k = 0; k < cells; ++k) {
    const double start = work.knots[k], end = work.knots[k + 1];
    const std::array<double, 4> first = derivative_form(work.extended, k, 1, start),
                                second = derivative_form(work.extended, k, 2, start),
                                third = derivative_form(work.extended, k, 3, start);
    for (; i < fine.cells() && (k + 1 == cells || middle(i) < end); ++i) {
      work.weight[k] += 0.5 * (weight[i] + weight[i + 1]) * (fine.s[i + 1] - fine.s[i]) / (end - start);
      for (const std::size_t side : {0, 1}) {
        const double t = fine.s[i + side] - start;
        const auto along = [&](const std::span<const double>(&g)[3], std::size_t a) {
          const std::size_t at = 2 * i + side;
          return g[0][at] * (first[a] + t * (second[a] + 0.5 * t * third[a])) +
                 g[1][at] * (second[a] + t * third[a]) + g[2][at] * third[a];
        };
        for (std::size_t a = 0; a < 4; ++a) {
          work.linear[k + a].x_mm += along(gradient.x, a);
          work.linear[k + a].y_mm += along(gradient.y, a);
        }
      }
    }
  }
  work.value = value;
  work.control = work.base;
  fit_spline(work.knots, work.places, false, work);
  to_curve(work, curve);
}

}  // namespace firn::motion
