// Computes the local cubic regression of equally spaced samples. The 7-point one is the Savitzky-Golay filter
// that ends MTTS [Barnett 2012, 4.2.6].
#pragma once

#include <span>
#include <vector>

namespace firn::motion::thesis {

/// Each sample becomes the value of the least-squares cubic through the `window` (odd, >= 5) samples around
/// it; near the ends the first (last) window's cubic is evaluated off its centre. Inputs shorter than the
/// window come back as they are.
std::vector<double> local_cubic(std::span<const double> samples, int window);

/// window = 7: the centre has weights (-2, 3, 6, 7, 6, 3, -2) / 21.
std::vector<double> savitzky_golay_7(std::span<const double> samples);

}  // namespace firn::motion::thesis
