// build_curve() computes the curve that is followed: twice continuously differentiable, piecewise cubic, with
// curvature jumps ramped over w.
//
// Base: lines and arcs (core/motion/curve/curve_pieces.h).
// Ramped curve = base convolved with a box of width w:
//   r(s) = mean of the base over [s - w/2, s + w/2].
// A jump of curvature becomes a ramp of length w centred on it; turning angle and length stay, lines stay
// where they are, and an arc moves by R (1 - sin(w / 2R) / (w / 2R)), at most w^2 / (24 R), towards its
// centre (errata, chapter 4). A corner (tangents T1, T2) of a sparse polygon is convolved with the hat of
// half width w: shift (T2 - T1) (w - |x|)^3 / (6 w^2), at most |T2 - T1| w / 6. Vertices of a polygon sampled
// more densely than 2 w are interpolated: curvature is then linear between them, as in the thesis's sampling
// at constant spacing. The shift vanishes at both ends, which are points of the path.
// Beside given curves that have to stay (CurveOptions::exact) there is no convolution: the spline passes the
// base itself, and at a joint its cells are so short that it leaves the base by at most about kExactMm. Over
// them the spline ramps a jump of curvature and rounds a turn of less than a stop's; the motion is as slow
// there as its limits ask.
// The motion follows the C2 cubic spline through that curve at its knots: r' is quadratic, r'' linear, r'''
// constant in each cell, exactly; nothing else is approximated afterwards.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/motion/curve/constants.h"
#include "core/motion/curve/curve_pieces.h"
#include "core/path/path.h"

namespace firn::motion {

/// Sizes of the cells. The speed profile has one unknown per cell.
struct CellSizes {
  int ramp_cells = 4;          ///< per ramp of curvature
  double ramp_exit_mm = 0.15;  ///< first cell beside a ramp
  double growth = 1.4;         ///< ratio of neighbouring cells on lines
  double rest_growth = 1.3;    ///< the same beside a rest
  double largest_mm = 5.0;
  double arc_angle_rad = 0.12;  ///< turning of one cell on an arc
  double rest_mm = 0.06;        ///< first cell at rest
  double split = 1.0;           ///< every cell of the spline is divided into about so many
  double tight_mm = 2.0;        ///< where the radius is smaller, into as many times more (up to three)
  double min_cells = 60.0;      ///< curves of few cells are divided up to here (at most into four)
  double min_mm = 0.0;          ///< no cell of the spline is divided into shorter ones
};

struct Curve {
  std::vector<double> s;            ///< knots [mm], s[0] = 0
  std::vector<double> x, y;         ///< positions at the knots
  std::vector<double> xx, yy;       ///< second derivatives at the knots
  std::vector<double> yaw, yaw2;    ///< of the tool at the knots and its second derivative; empty = constant
  std::vector<double> speed_limit;  ///< largest path speed in each cell (knots - 1), mm/s
  bool straight = false;            ///< one line

  std::size_t cells() const { return s.empty() ? 0 : s.size() - 1; }
  /// Position in cell i at s_mm.
  Point2 at(std::size_t cell, double s_mm) const;
};

struct CurveOptions {
  double ramp_mm = 0.4;
  double tolerance_mm =
      0.0;  ///< > 0: each ramp as long as this deviation allows; corners of any angle are rolled
  /// > 0: each ramp and hat is also no longer than the tolerance allows where that is less than ramp_mm, and
  /// vertices are interpolated, arcs recognised only where the chords' sagitta is below this
  double held_sagitta_mm = 0.0;
  CellSizes sizes;
  std::span<const double> yaw{};        ///< of the tool at the points, linear between them; empty = constant
  std::span<const GivenCurve> given{};  ///< among the points

  double hold_mm = 0.0;  ///< > 0: the points stay, too, within about so much

  /// Given curves stay where they are: without a tolerance the spline passes them.
  bool exact() const { return (!given.empty() || hold_mm > 0.0) && tolerance_mm <= 0.0; }
  /// At joints of an exact path.
  double exact_mm() const { return given.empty() && hold_mm > 0.0 ? kHeldJointShare * hold_mm : kExactMm; }
};

/// Buffers kept between paths.
struct CurveWork {
  struct Joint {
    double s = 0.0, half_ramp = 0.0, half_hat = 0.0;
    double turn_x = 0.0, turn_y = 0.0;  ///< T2 - T1
    bool interpolate = false;           ///< the vertex itself is a point of the curve
    bool smooth = false;                ///< and needs no knot: its neighbours' spline passes it
    double spacing = 0.0;               ///< > 0: length of the cells beside an exact joint
  };
  struct Mark {
    double s, spacing, growth;
  };
  std::vector<CurvePiece> pieces;
  std::vector<double> offset, point_s;
  std::vector<double> yaw_s,
      yaw_half;  ///< of each point: where it is, and half of the hat that rounds its kink
  std::vector<Joint> joints;
  std::vector<Mark> marks;
  std::vector<double> sweep;
  Curve coarse;
};

/// The spline of one segment between two stops, into work.coarse (without speed limits).
void build_curve(std::span<const Point2> points, const CurveOptions& spec, CurveWork& work);

/// Parts of build_curve: where the points are along the curve and how far each kink of the yaw
/// is rounded; the yaw's C2 cubic spline at the knots. A kink is rounded by the hat of half width w, as
/// corners of the path are: off by at most (jump of the slope) w / 6; points closer than 2 w are
/// interpolated.
void place_yaw(std::span<const Point2> points, const CurveOptions& spec, CurveWork& work);
void sample_yaw(const CurveOptions& spec, CurveWork& work, Curve& curve);

/// Shift of a unit kink at distance x under the hat of half width `half`: (half - |x|)^3 / (6 half^2).
double hat_shift(double x, double half);

/// Part of build_curve: where the spline's knots are.
void place_knots(const CurveOptions& spec, CurveWork& work, std::vector<double>& knots);

/// work.coarse with cells as the speed profile needs them: the same curve, more knots.
void refine(const CellSizes& sizes, CurveWork& work, Curve& fine);

/// Divides the cells of `curve` whose excess is above `most`, and their neighbours, into three.
void divide(const CellSizes& sizes, CurveWork& work, std::span<const double> excess, double most,
            Curve& curve);

/// Each cell's speed limit from those of the segments of `points` (empty = none).
void set_speed_limit(std::span<const Point2> points, std::span<const double> speed_limit, CurveWork& work,
                     Curve& curve);

/// Natural or clamped-curvature cubic spline by a tridiagonal elimination, for which Eigen has no solver:
/// second derivatives `m` of the C2 cubic through (s, f), given m
/// at the ends.
void spline(std::span<const double> s, std::span<const double> f, double m_first, double m_last,
            std::vector<double>& m, std::vector<double>& sweep);

}  // namespace firn::motion
