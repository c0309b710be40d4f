// Jets holds batches of coordinates with their first three derivatives, and the chain rule that turns
// derivatives along a path into rates in time.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace firn::motion {

inline constexpr int kMaxJoints = 6;

/// Pose of the tool in the arm's base frame.
enum TaskAxis : int { kX = 0, kY = 1, kZ = 2, kYaw = 3, kTaskAxes = 4 };
using TaskVector = std::array<double, kTaskAxes>;    ///< mm, mm, mm, rad
using JointVector = std::array<double, kMaxJoints>;  ///< rad or mm, unused entries 0

/// n samples of some axes: value and three derivatives with respect to one parameter (path position s [mm] or
/// time [s]). One block of memory; of(axis, order) is contiguous over the samples, so loops over it
/// vectorise.
class Jets {
 public:
  Jets() = default;
  Jets(int axes, std::size_t samples) { resize(axes, samples); }
  /// Contents are zero afterwards only where memory is new; callers write every entry they read.
  void resize(int axes, std::size_t samples) {
    axes_ = axes;
    samples_ = samples;
    const std::size_t size = std::size_t(axes) * 4 * samples;
    if (data_.size() < size) data_.resize(size);  // never smaller: growing again would fill with zeros
  }
  int axes() const { return axes_; }
  std::size_t samples() const { return samples_; }
  double* of(int axis, int order) {
    return data_.data() + (std::size_t(axis) * 4 + std::size_t(order)) * samples_;
  }
  const double* of(int axis, int order) const {
    return data_.data() + (std::size_t(axis) * 4 + std::size_t(order)) * samples_;
  }

 private:
  int axes_ = 0;
  std::size_t samples_ = 0;
  std::vector<double> data_;
};

/// Bounds of d^n exp(i a) / exp(i a) less i a^(n), n = 4 and 5, from bounds of the angle's derivatives (Faa
/// di Bruno).
inline double rotation_rest_4(double d1, double d2, double d3) {
  return 3.0 * d2 * d2 + 4.0 * d1 * d3 + 6.0 * d1 * d1 * d2 + d1 * d1 * d1 * d1;
}
inline double rotation_rest_5(double d1, double d2, double d3, double d4) {
  return 10.0 * d2 * d3 + 5.0 * d1 * d4 + 10.0 * d1 * d1 * d3 + 15.0 * d1 * d2 * d2 +
         10.0 * d1 * d1 * d1 * d2 + d1 * d1 * d1 * d1 * d1;
}

}  // namespace firn::motion
