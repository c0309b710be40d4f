// Computes Huber's loss: a square up to kClip standard deviations, then a straight line, so that the
// influence of a droplet that did not come is at most kClip.
#pragma once

#include <cmath>

namespace firn::droplet {

inline constexpr double kClip = 3.0;  // standard deviations

/// Doubled, so that inside it is the square. @param weight 1 / variance of the difference
inline double loss(double difference, double weight) {
  const double z2 = weight * difference * difference;
  return z2 <= kClip * kClip ? z2 : 2.0 * kClip * std::sqrt(z2) - kClip * kClip;
}
inline bool beyond(double difference, double weight) {
  return weight * difference * difference > kClip * kClip;
}
inline double clipped(double difference, double weight) {
  if (!beyond(difference, weight)) return difference;
  return (difference > 0.0 ? kClip : -kClip) / std::sqrt(weight);
}

}  // namespace firn::droplet
