// smooth_dense() computes smoothed points of densely sampled free-form paths within a tolerance: vertices
// that scatter by micrometres cause unintended curvature, and are followed slowly. With a tolerance they may
// move.
#pragma once

#include <span>
#include <vector>

#include "core/motion/curve/curve_pieces.h"

namespace firn::motion {

/// Buffers kept between paths.
struct SmoothingWork {
  std::vector<double> band[4];  ///< of the matrix: diagonal and three above
  std::vector<double> x, y;
};

/// True if the pieces have a run of at least eight chords shorter than `longest_mm`, which smooth_dense would
/// move.
bool has_dense_run(std::span<const CurvePiece> pieces, double longest_mm);

/// In every such run q minimises sum |q_i - p_i|^2 + lambda sum |third difference of q|^2 [Whittaker 1923],
/// with the largest lambda that moves no point further than `tolerance_mm`. The ends of a path stay, and
/// where a run meets a line or an arc its last two points. Other points are copied.
void smooth_dense(std::span<const Point2> points, std::span<const CurvePiece> pieces, double longest_mm,
                  double tolerance_mm, SmoothingWork& work, std::vector<Point2>& out);

}  // namespace firn::motion
