// fit_tube() computes the C2 cubic spline of least third derivative inside a tube about a polyline: points
// of a path are samples with rounding, and only the tube is meant.
//
//   minimise  integral w(t) |r'''|^2 dt   subject to   |r(t_i) - p_i| <= radius_i,
//
// t = length along the polyline, p_i = its vertices and places between them. r''' is constant between the
// knots. The knots follow the polyline's turns: theta at a vertex allows radii of about radius / theta^2 over
// a length radius / theta. Convex; solved by an infeasible primal-dual interior-point method with a banded
// Newton step, linear in the number of knots.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/motion/curve/constants.h"
#include "core/motion/curve/frechet.h"
#include "core/motion/curve/path_curve.h"

namespace firn::motion {

/// One constraint: the spline at parameter t within `radius` of a place.
struct TubePlace {
  double t = 0.0;
  Point2 at;
  double radius = 0.0;
  double share = 1.0;     ///< of the tube's radius that it may use
  double narrower = 0.0;  ///< narrow_tube()
};

/// Buffers kept between paths.
struct TubeWork {
  static constexpr std::size_t kWidth = 8;            ///< of a row of Newton's matrix
  static constexpr std::size_t kBehind = kWidth + 1;  ///< rows behind the last one that solving reads
  struct Row {
    std::array<double, 4> basis;
    std::size_t first = 0;  ///< control point
    double over_square = 0.0;
    Point2 at, off;  ///< place; the first guess less that [mm]
  };
  /// One number of each row that iterations change, and neutral ones up to a whole number of vectors.
  struct States {
    std::vector<double> off_x, off_y;  ///< spline less place [mm]
    std::vector<double> over_square, slack, multiplier;
    std::vector<double> inside;          ///< 1 where slack is the room itself
    std::vector<double> step, change;    ///< of slack and multiplier
    std::vector<double> step_x, step_y;  ///< of `off`
    std::vector<double> xx, xy, yy;      ///< Hessian of the barrier
    std::vector<double> push_x, push_y;  ///< and minus its gradient
    std::size_t size() const { return slack.size(); }
  };
  struct alignas(64) BandRow {
    double at[kWidth];  ///< the diagonal and seven to the right
  };
  std::vector<std::size_t> kept, coarse;
  std::vector<Point2> line, shape;
  std::vector<double> length, point_length, missed, knots, extended;
  std::vector<TubePlace> places;
  std::vector<Row> rows;
  States states;
  std::vector<Point2> control;
  std::vector<double> weight;                 ///< of each cell, empty = 1
  std::vector<Point2> base;                   ///< the objective is of control - base; empty = 0
  std::vector<Point2> linear;                 ///< and has this linear part; empty = 0
  double value = 0.0;                         ///< of the function that step_tube() makes smaller
  std::vector<std::array<double, 4>> form;    ///< third derivative in each cell, times the root of its length
                                              ///< and its weight
  std::vector<std::array<double, 4>> near;    ///< matrix of the least squares
  std::vector<std::array<double, 4>> energy;  ///< banded Hessian of the objective, per control point
  std::vector<BandRow> band;                  ///< Newton matrix
  std::vector<double> step;                   ///< of the control points: x, y in turn
  int iterations = 0;
  bool converged = false;  ///< else the curve is inside, but not smooth
  bool lines = false;      ///< chords are held as lines
};

/// The spline with `knots` (ascending, first = start, last = end) from a guess in work.control, whose ends
/// stay, to the optimum in work.control and work.extended (knots with fourfold ends). @param near_places the
/// guess is moved to the places first, by least squares: needed where it is far outside of the radii
/// Returns the largest |r(t_i) - p_i| / radius_i, or 1.
double fit_spline(std::span<const double> knots, std::span<const TubePlace> places, bool near_places,
                  TubeWork& work);

struct TubeOptions {
  double radius_mm = 0.0;   ///< of the tube at the points
  double between_mm = 0.0;  ///< and between them; the points are thinned where it is the same
  /// and at most, where it is more than radius_mm and the points turn like samples of a curve whose sagitta
  /// is more than between_mm
  double max_between_mm = 0.0;
  double largest_mm = 5.0;    ///< cell
  double tolerance_mm = 0.0;  ///< inside of which the curve will be moved; 0 = it stays
  bool hold_lines = false;    ///< chords much longer than those beside them are lines, held like points
};

/// Fits a path's points between two rests. @param curve without speed limits
void fit_tube(std::span<const Point2> points, const TubeOptions& options, TubeWork& work, Curve& curve);

/// Makes the tube of the last fit narrower near these stretches of its curve: by the distance beyond the
/// limit plus `more_mm`, at most by half of the radius.
void narrow_tube(std::span<const StretchBeyond> stretches, double more_mm, TubeWork& work);

/// Fits inside the tube of the last fit, which was made wider or narrower.
void refit_tube(TubeWork& work, Curve& curve);

/// Makes the tube of the last fit wider by this distance, or narrower if it is negative, at most by half of
/// the radius.
void widen_tube(double by_mm, TubeWork& work);

/// The curve of work.base.
void base_curve(TubeWork& work, Curve& curve);

/// One step of descent of a function of the curve, from work.base inside the same tube: minimises
///   <gradient, r - base> + 1/2 integral w(t) |r''' - base'''|^2 dt.
/// @param fine the curve of base with more knots; @param gradient at both ends of its cells
/// @param weight w at the knots of `fine` @param value of the function along base, a share of which the step
/// is exact to
struct CurveGradient {
  std::span<const double> x[3], y[3];  ///< of r', r'', r''': [2 * cells]
};
void step_tube(const Curve& fine, const CurveGradient& gradient, std::span<const double> weight, double value,
               TubeWork& work, Curve& curve);

}  // namespace firn::motion
